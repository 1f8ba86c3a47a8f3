"""A customised last holds the foot, changes nothing beyond its transition, and refuses what cannot be made to fit."""

import dataclasses
import inspect
from typing import Any

import numpy as np
import pytest
from scipy import spatial

from footscan.coordinates import Bools, Floats
from footscan.errors import InputError, QualityError
from footscan.foot.nurbs import clamped_knots, greville
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.shoelast.chart import bending_matrix, build_chart, project
from footscan.shoelast.compare import compare, compare_lasts
from footscan.shoelast.custom_last import CustomLast
from footscan.shoelast.custom_report import plain_maximum_energy
from footscan.shoelast.customise import CustomSettings, customise
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.model import Shoelast
from footscan.shoelast.net import interpolate_tube
from footscan.shoelast.nets import coarse_space, refined
from footscan.shoelast.pins import Pin
from footscan.shoelast.pose import moved
from footscan.shoelast.prepared_foot import PreparedFoot, prepare_foot
from footscan.shoelast.proof import LEAST_SAMPLES, LIMIT_MM
from footscan.shoelast.refusals import check_no_spike, overshoot_mm
from footscan.shoelast.skin import skin_of
from footscan.shoelast.top_line import FeatherLine
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import trimesh_from_surface


@pytest.fixture(scope="module")
def foot() -> PreparedFoot:
    return prepare_foot(trimesh_from_surface(build_foot(FootShape("right", 1.0))), "right")


@pytest.fixture(scope="module")
def shoelast() -> Shoelast:
    return build_shoelast("therapeutic", 40.0, "g", 15.0, "round")


@pytest.fixture(scope="module")
def custom(shoelast: Shoelast, foot: PreparedFoot) -> CustomLast:
    return customise(shoelast, foot, "therapeutic")


def test_no_seen_skin_stands_out_of_the_final_mesh(custom: CustomLast):
    assert custom.proof.samples >= LEAST_SAMPLES
    assert custom.proof.worst_violation_mm <= LIMIT_MM
    assert custom.proof.holds


def test_customising_ends_where_its_watcher_raises_also_inside_the_solver(shoelast: Shoelast, foot: PreparedFoot):
    callers: list[str] = []

    def watch() -> None:
        callers.append(inspect.stack()[1].function)
        if callers[-1] == "asked_to_end":
            raise InterruptedError

    with pytest.raises(InterruptedError):
        customise(shoelast, foot, "therapeutic", watch=watch)

    assert callers.count("asked_to_end") == 1
    assert callers.count("customise") >= 3


def inside_by_parity(triangles: Floats, points: Floats) -> Bools:
    """Whether an odd number of triangles lies above each point; slice by slice along x."""
    corner = np.asarray(triangles)
    low, high = corner[:, :, 0].min(axis=1), corner[:, :, 0].max(axis=1)
    inside = np.zeros(len(points), dtype=np.bool_)
    for left in np.arange(points[:, 0].min(), points[:, 0].max() + 2.0, 2.0):
        here = np.flatnonzero((points[:, 0] >= left) & (points[:, 0] < left + 2.0))
        near = corner[(high >= left) & (low <= left + 2.0)]
        a, b, c = (near[:, k] for k in range(3))
        p = points[here][:, None]

        def twice(q: Floats, r: Floats, s: Floats) -> Floats:
            return (r[..., 0] - q[..., 0]) * (s[..., 1] - q[..., 1]) - (r[..., 1] - q[..., 1]) * (s[..., 0] - q[..., 0])

        w = np.stack([twice(p, b, c), twice(a, p, c), twice(a, b, p)], axis=-1)
        over = (w > 0.0).all(axis=-1) | (w < 0.0).all(axis=-1)
        z = (w * near[None, :, :, 2]).sum(axis=-1) / np.where(over, w.sum(axis=-1), 1.0)
        inside[here] = (over & (z > p[..., 2])).sum(axis=1) % 2 == 1
    return inside


def test_an_independent_look_at_the_mesh_agrees(custom: CustomLast):
    mesh, shell, line = custom.skin.mesh(), custom.posed.shell, custom.proof.top_line
    seen = np.unique(shell.faces[custom.posed.foot.face_seen])
    xyz = shell.xyz[seen]
    edge = custom.shoelast.upper.grid(np.arange(720) / 720, np.zeros(1))[0]
    nearest = np.linalg.norm(xyz[:, None, :2] - edge[None, ::4, :2], axis=2).argmin(axis=1)
    judged = (xyz[:, 2] > edge[::4][nearest, 2] + 0.3) & ((xyz - line.origin) @ line.normal < 0.0)
    some = xyz[judged][:: max(1, int(judged.sum()) // 800)]

    inside = inside_by_parity(mesh.triangles, some + 1e-6)

    near = np.linalg.norm(mesh.vertices[None] - some[~inside][:, None], axis=2).min(axis=1, initial=np.inf)
    assert len(some) > 300
    assert np.all(near < 1.5)
    assert np.mean(inside) > 0.99


def test_the_mesh_is_closed_and_the_cone_and_back_are_held(custom: CustomLast):
    mesh = custom.skin.mesh()

    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert all(one.kept for one in custom.held.values())


def standing_out_above_the_top_line(custom: CustomLast, xyz_before: np.ndarray) -> np.ndarray:
    """Places of the standard last next to skin that stands out of it, up to 20 mm above the top line."""
    skin = custom.posed.shell.xyz
    height = (skin - custom.proof.top_line.origin) @ custom.proof.top_line.normal
    near = DistanceMesh(xyz_before, custom.skin.faces).nearest(skin[(height > 0.0) & (height < 20.0)])
    return near.xyz[near.signed > 0.0]


def test_a_change_runs_out_above_the_top_line_instead_of_ending_in_a_step(custom: CustomLast):
    before = skin_of(custom.original, custom.breaks).xyz_shoelast[: len(custom.skin.uv)]
    moved = custom.displacement_mm[: len(before)]
    height = (before - custom.proof.top_line.origin) @ custom.proof.top_line.normal
    levels = [np.abs(moved[np.abs(height - level) < 1.0]).max() for level in (0.0, 10.0, 20.0, 35.0)]

    assert levels[0] > levels[1] > levels[2] > levels[3]
    assert levels[1] > 0.4 * levels[0]
    assert levels[3] < 0.01


def test_beyond_the_transition_nothing_moves(custom: CustomLast):
    before = skin_of(custom.original, custom.breaks).xyz_shoelast
    off = np.linalg.norm(custom.skin.xyz_shoelast - before, axis=1)
    need, edge = custom.need, np.arange(2 * len(custom.breaks.around))
    asks = need.known & ((need.move_mm > 0.01) | ((need.hold_mm < -0.1) & (need.loss_mm > 0.1)))
    u = np.concatenate([need.u[asks]])
    places = np.vstack(
        [custom.original.upper.grid(u[k : k + 1], need.v[asks][k : k + 1])[0, 0] for k in range(0, len(u), 3)]
    )
    if custom.widening_mm > 0.0:
        places = np.vstack([places, before[edge][off[edge] > 0.01]])
    places = np.vstack([places, standing_out_above_the_top_line(custom, before)])

    sides = np.arange(len(custom.skin.uv))
    kd_tree: Any = spatial.KDTree
    gap = np.asarray(kd_tree(places).query(before[sides])[0])

    assert off[sides][gap > custom.transition_mm + 4.0].max(initial=0.0) < 0.01


def test_the_change_is_smoother_than_a_plain_maximum(custom: CustomLast):
    chart = build_chart(custom.original)

    assert custom.smoothness.energy < plain_maximum_energy(chart, bending_matrix(chart.tube), custom.need)


def test_a_finer_net_is_the_same_last(shoelast: Shoelast):
    fine = refined(shoelast, 2, np.array([0.013, 0.617]))

    assert np.abs(skin_of(fine).xyz_shoelast - skin_of(shoelast).xyz_shoelast).max() < 1e-9


def test_a_coarse_field_is_a_field_of_the_fine_net(shoelast: Shoelast):
    tube = shoelast.upper
    coarse = coarse_space(tube, 12.0)

    ones = coarse.spread @ np.ones(coarse.shape[0] * coarse.shape[1])

    assert coarse.shape[1] < tube.count_u
    assert np.abs(ones - 1.0).max() < 1e-9


def test_a_place_pushed_along_the_directions_is_found_again(shoelast: Shoelast):
    chart, random = build_chart(shoelast), np.random.default_rng(2)
    u, v, t = random.uniform(0, 1, 200), random.uniform(0.02, 0.95, 200), random.uniform(-2.0, 6.0, 200)
    xyz = np.array(
        [
            chart.tube.grid(u[k : k + 1], v[k : k + 1])[0, 0]
            + t[k] * chart.direction.grid(u[k : k + 1], v[k : k + 1])[0, 0]
            for k in range(200)
        ]
    )

    found = project(chart, chart.tube, xyz, np.mod(u + 0.002, 1.0), np.clip(v + 0.005, 0.0, 1.0))

    assert np.nanmax(np.abs(found[2] - t)) < 1e-3
    assert np.isfinite(found[2]).mean() > 0.98


def test_which_skin_lies_above_the_feather_line_is_told_as_by_its_heights(custom: CustomLast):
    edge, xyz = FeatherLine(custom.original), custom.posed.shell.xyz

    assert np.array_equal(edge.has_below(xyz), edge.height_mm(xyz) > 0.0)


def test_a_pin_gives_room_where_it_is_set(shoelast: Shoelast, foot: PreparedFoot, custom: CustomLast):
    at = foot.points["metatarsale_tibiale"]
    xyz = foot.frame.to_input(at[None] + [0.0, 0.0, 8.0])[0]
    pin = Pin((float(xyz[0]), float(xyz[1]), float(xyz[2])), 15.0, 6.0)

    pinned = customise(shoelast, foot, "therapeutic", CustomSettings(pins=(pin,)))

    assert pinned.proof.holds
    assert pinned.dimensions["ball_girth"][1] > custom.dimensions["ball_girth"][1] + 1.0


def test_two_sizes_short_is_refused_with_the_word_grade(foot: PreparedFoot):
    with pytest.raises(QualityError, match="grade first"):
        customise(build_shoelast("therapeutic", 37.5, "k", 15.0, "round"), foot, "therapeutic")


def test_the_wrong_side_is_refused(shoelast: Shoelast, foot: PreparedFoot):
    with pytest.raises(InputError, match="right one"):
        customise(dataclasses.replace(shoelast, side="left"), foot, "therapeutic")


def test_an_unknown_profile_is_named(shoelast: Shoelast, foot: PreparedFoot):
    with pytest.raises(InputError, match="comfort"):
        customise(shoelast, foot, "ballet")


def test_a_last_compared_with_itself_has_no_room_anywhere(shoelast: Shoelast):
    same = compare_lasts(shoelast, shoelast)

    assert np.abs(same.clearance_mm).max() < 1e-9
    assert all(one.foot_mm == one.last_mm for one in same.girths.values())


def test_one_percent_shows(shoelast: Shoelast):
    larger = moved(shoelast, np.diag([1.01, 1.01, 1.01, 1.0]))

    found = compare_lasts(shoelast, larger)

    assert found.girths["ball_girth"].foot_mm / found.girths["ball_girth"].last_mm == pytest.approx(1.01, abs=0.006)
    assert found.regions["ball"].mean_mm < -0.2


def test_only_seen_skin_counts_in_a_comparison(shoelast: Shoelast, foot: PreparedFoot):
    blind = dataclasses.replace(
        foot, face_seen=foot.face_seen & (foot.shell.xyz[foot.shell.faces][:, :, 0].min(1) < 150)
    )

    found = compare(shoelast, blind)

    assert "toe" in compare(shoelast, foot).regions
    assert "toe" not in found.regions
    assert found.unseen is not None


@pytest.fixture(scope="module")
def smoothed(shoelast: Shoelast, foot: PreparedFoot) -> CustomLast:
    wanted = {"ball_girth": 258.0}
    return customise(shoelast, foot, "therapeutic", CustomSettings(transition_mm=20.0, girths_mm=wanted, smooth_mm=0.3))


def test_a_wanted_girth_is_met_and_the_foot_still_held(smoothed: CustomLast):
    assert smoothed.dimensions["ball_girth"][1] == pytest.approx(258.0, abs=1.5)
    assert smoothed.proof.holds


def test_a_girth_smaller_than_the_foot_leaves_is_a_wish_not_met(shoelast: Shoelast, foot: PreparedFoot):
    tight = CustomSettings(transition_mm=20.0, girths_mm={"ball_girth": 230.0})

    found = customise(shoelast, foot, "therapeutic", tight)

    assert found.proof.holds
    assert found.dimensions["ball_girth"][1] < 249.0
    assert any("ball_girth" in one and "230.0" in one for one in found.unmet)


def test_smoothing_makes_a_copy_fairer_within_its_limit_and_keeps_what_was_held(smoothed: CustomLast):
    done = smoothed.smoothing

    assert done is not None
    assert done.variation[1] < 0.8 * done.variation[0]
    assert 0.01 < done.most_mm < 1.3 * done.limit_mm
    assert all(one.kept for one in smoothed.held.values())
    assert smoothed.outside_mm < 0.01
    assert np.abs(done.unsmoothed.upper.net_mm - smoothed.shoelast.upper.net_mm)[[0, -1]].max() < 1e-9


def test_a_bend_in_one_direction_costs_what_it_bends_and_how_fast_that_changes():
    """On a tube of radius R the field cos(2 pi k u) has the squared Hessian (k / R)^4 / 2 on average."""
    count, radius, height, waves = 96, 40.0, 60.0, 3
    u = np.arange(count) / count
    ring = np.column_stack([radius * np.cos(2 * np.pi * u), radius * np.sin(2 * np.pi * u), 0.0 * u])
    knots = clamped_knots(np.linspace(0.0, 1.0, 9))
    rows = [ring + np.array([0.0, 0.0, height * v]) for v in greville(knots)]
    tube = interpolate_tube(np.array(rows), knots)
    field = interpolate_tube(np.tile(np.cos(2 * np.pi * waves * u)[None, :, None], (len(rows), 1, 3)), knots)
    c = field.net_mm[..., 0].ravel()

    bend = c @ (bending_matrix(tube) @ c)
    change = c @ (bending_matrix(tube, 1.0) @ c) - bend

    area, rate = 2.0 * np.pi * radius * height, waves / radius
    assert bend == pytest.approx(0.5 * area * rate**4, rel=0.01)
    assert change == pytest.approx(0.5 * area * rate**6, rel=0.02)


def test_an_unknown_girth_is_refused(shoelast: Shoelast, foot: PreparedFoot):
    with pytest.raises(InputError, match="waist_girth"):
        customise(shoelast, foot, "therapeutic", CustomSettings(girths_mm={"toe_girth": 200.0}))


def test_a_displacement_far_beyond_the_need_is_refused(shoelast: Shoelast):
    places, need = np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0]]), np.array([4.0, 9.0])
    along = np.linspace(-20.0, 20.0, 200)
    xyz, moved = np.column_stack([along, 0.0 * along, 0.0 * along]), np.full(200, 7.5)

    beyond = overshoot_mm(places, need, xyz, np.where(np.abs(along) < 9.0, moved, 0.0), 10.0)

    assert beyond == pytest.approx(3.5)
    assert overshoot_mm(places, need, xyz, moved, 10.0) == pytest.approx(7.5)
    check_no_spike(shoelast, beyond)
    with pytest.raises(QualityError, match=r"7\.5 mm further than any skin near asks for \(at most 6 mm\)"):
        check_no_spike(shoelast, 7.5)
