"""Measurements against the same numbers taken another way: trimesh sections and SciPy hulls in the foot frame."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from footscan.foot.girth import MARGIN_MM, WALL_SHARE, measure_girth
from footscan.foot.measurements import measure
from footscan.foot.shell import NEVER_SEEN_BELOW_MM, Shell

ACROSS, LEVEL = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def measured(foot):
    return measure(foot, "right")


@pytest.fixture(scope="module")
def in_frame(foot, measured):
    """The whole foot in its own frame."""
    return foot.copy().apply_transform(measured.foot_from_input)


@pytest.fixture(scope="module")
def marks(measured):
    turn = measured.foot_from_input
    return {name: turn[:3, :3] @ mark.xyz + turn[:3, 3] for name, mark in measured.landmarks.items()}


def cut(mesh, origin, normal):
    return np.array(mesh.section(plane_origin=origin, plane_normal=normal).vertices)


def girth(points, normal):
    normal = np.asarray(normal) / np.linalg.norm(normal)
    u = np.cross(normal, [0.3, 0.5, 0.8])
    u /= np.linalg.norm(u)
    return ConvexHull(points @ np.stack([u, np.cross(normal, u)], axis=1)).area


def test_foot_length_is_the_extent_of_the_low_skin(in_frame, measured):
    low = in_frame.vertices[in_frame.vertices[:, 2] < 0.16 * measured["foot_length"].value]

    assert measured["foot_length"].value == pytest.approx(np.ptp(low[:, 0]), abs=1e-9)


def test_heel_breadth_is_the_width_at_16_percent(in_frame, measured):
    length = measured["foot_length"].value
    points = cut(in_frame, 0.16 * length * ACROSS, ACROSS)
    low = points[points[:, 2] < 0.16 * length]

    assert measured["heel_breadth"].value == pytest.approx(np.ptp(low[:, 1]), abs=1e-6)


def test_midfoot_breadth_is_the_width_at_half_the_length(in_frame, measured):
    length = measured["foot_length"].value
    points = cut(in_frame, 0.5 * length * ACROSS, ACROSS)
    low = points[points[:, 2] < 0.16 * length]

    assert measured["midfoot_breadth"].value == pytest.approx(np.ptp(low[:, 1]), abs=1e-6)


def test_instep_height_and_girth_are_those_at_half_the_length(in_frame, measured):
    points = cut(in_frame, 0.5 * measured["foot_length"].value * ACROSS, ACROSS)

    assert measured["instep_height"].value == pytest.approx(points[:, 2].max(), abs=1e-6)
    assert measured["instep_girth"].value == pytest.approx(girth(points, ACROSS), abs=1e-6)


def test_the_ball_girth_goes_through_both_metatarsal_heads(in_frame, measured, marks):
    medial, lateral = marks["metatarsale_tibiale"], marks["metatarsale_fibulare"]
    normal = np.cross(medial - lateral, LEVEL)

    assert measured["ball_girth"].value == pytest.approx(girth(cut(in_frame, medial, normal), normal), abs=1e-6)
    assert measured["foot_breadth_diagonal"].value == pytest.approx(np.linalg.norm((medial - lateral)[:2]))
    assert measured["foot_breadth"].value == pytest.approx(medial[1] - lateral[1])
    assert measured["ball_length"].value == pytest.approx(medial[0] - marks["pternion"][0])


@pytest.mark.parametrize(
    ("name", "mark"), [("long_heel_girth", "junction_point"), ("short_heel_girth", "instep_point")]
)
def test_heel_girths_go_round_the_corner_below_the_pternion(in_frame, measured, marks, name, mark):
    corner = marks["heel_corner"]
    normal = np.cross(marks[mark] - corner, [0.0, 1.0, 0.0])

    assert corner == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert measured[name].value == pytest.approx(girth(cut(in_frame, corner, normal), normal), abs=1e-6)


def test_the_junction_is_the_dorsum_nearest_to_the_heel_corner(in_frame, marks):
    angles = np.radians(np.arange(28.0, 58.0, 0.5))
    reach = []
    for angle in angles:
        direction = np.array([np.cos(angle), 0.0, np.sin(angle)])
        reach.append((cut(in_frame, np.zeros(3), np.cross(direction, [0.0, 1.0, 0.0])) @ direction).max())

    found = marks["junction_point"]
    assert np.hypot(found[0], found[2]) == pytest.approx(min(reach), abs=0.05)


def test_the_waist_is_not_thicker_than_any_parallel_cut_of_its_band(in_frame, measured, marks):
    normal = np.cross(marks["metatarsale_tibiale"] - marks["metatarsale_fibulare"], LEVEL)
    length = measured["foot_length"].value
    girths = [girth(cut(in_frame, share * length * ACROSS, normal), normal) for share in np.arange(0.52, 0.6401, 0.01)]

    assert measured["waist_girth"].value <= min(girths) + 0.01


def test_toe_angles_lie_between_the_lines_from_heel_to_ball_and_ball_to_toe(measured, marks):
    for name, heel, ball, toe, sign in (
        ("toe_1_angle", "heel_medial", "metatarsale_tibiale", "toe_1_side", -1.0),
        ("toe_5_angle", "heel_lateral", "metatarsale_fibulare", "toe_5_side", 1.0),
    ):
        back, front = marks[ball] - marks[heel], marks[toe] - marks[ball]
        lean = np.degrees(np.arctan2(front[1], front[0]) - np.arctan2(back[1], back[0]))

        assert measured[name].value == pytest.approx(sign * lean)
        assert measured[name].value > 0


def test_a_hallux_bent_to_lateral_has_the_larger_angle(foot, measured):
    bent = np.array(foot.vertices)
    beyond = np.clip(bent[:, 0] - 200.0, 0.0, None)
    bent[:, 1] -= 0.25 * beyond * (bent[:, 1] > 0)

    result = measure(trimesh.Trimesh(bent, foot.faces, process=False), "right")

    assert result["toe_1_angle"].value > measured["toe_1_angle"].value + 3.0


def test_volume_and_surface_are_those_of_the_slice(in_frame, measured):
    height = 0.35 * measured["foot_length"].value
    places = trimesh.sample.sample_surface(in_frame, 200_000, seed=1)[0]
    levels = (np.arange(400) + 0.5) / 400 * height
    areas = [abs(_area(in_frame, level)) for level in levels]

    share = np.mean(places[:, 2] < height)
    assert measured["surface_area"].value == pytest.approx(in_frame.area * share / 100.0, rel=5e-3)
    assert measured["volume"].value == pytest.approx(np.sum(areas) * height / 400 / 1000.0, rel=1e-3)


def _area(mesh, level):
    xy = mesh.section(plane_origin=level * LEVEL, plane_normal=LEVEL).discrete[0][:, :2]
    return np.sum(xy[:-1, 0] * xy[1:, 1] - xy[:-1, 1] * xy[1:, 0]) / 2.0


def _pipe(radius_mm):
    """A closed cylinder along x that lies on the board."""
    pipe = trimesh.creation.cylinder(radius=radius_mm, height=200.0, sections=720)
    pipe.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
    return pipe.apply_translation([100.0, 0.0, radius_mm])


@pytest.mark.parametrize("turn_deg", [0.0, 20.0])
def test_the_interval_runs_from_the_seen_arc_to_walls_down_to_the_board(turn_deg):
    radius, length = 30.0, 260.0
    pipe = _pipe(radius)
    normal = np.array([np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg)), 0.0])

    found = measure_girth(Shell(np.array(pipe.vertices), np.array(pipe.faces)), length, np.array([100.0, 0, 0]), normal)

    angle = np.linspace(0.0, 2.0 * np.pi, 20001)
    oval = np.stack([radius * np.cos(angle) / normal[0], radius + radius * np.sin(angle)], axis=1)
    wall = np.sqrt(radius**2 - (radius - WALL_SHARE * length) ** 2) / normal[0]
    walled = np.concatenate([oval, [[-wall, 0.0], [wall, 0.0]]])
    assert found.value_mm == pytest.approx(ConvexHull(oval).area, abs=0.01)
    low = ConvexHull(oval[oval[:, 1] > NEVER_SEEN_BELOW_MM]).area - MARGIN_MM
    assert found.interval_mm == pytest.approx((low, ConvexHull(walled).area + MARGIN_MM), abs=0.3)


def test_walls_start_where_the_seen_skin_ends():
    radius, rim = 30.0, 24.0
    pipe = _pipe(radius)
    xyz = np.array(pipe.vertices)
    hidden = (xyz[:, 2] < NEVER_SEEN_BELOW_MM) | ((xyz[:, 1] > 0.0) & (xyz[:, 2] < rim))

    found = measure_girth(
        Shell(xyz, np.array(pipe.faces), np.where(hidden, 2, 0).astype(np.uint8)),
        260.0,
        np.array([100.0, 0, 0]),
        ACROSS,
    )

    angle = np.linspace(0.0, 2.0 * np.pi, 20001)
    circle = radius * np.stack([np.cos(angle), 1.0 + np.sin(angle)], axis=1)
    low_wall = np.sqrt(radius**2 - (radius - WALL_SHARE * 260.0) ** 2)
    high_wall = np.sqrt(radius**2 - (radius - rim) ** 2)
    walled = np.concatenate([circle, [[-low_wall, 0.0], [high_wall, 0.0]]])
    assert found.interval_mm[1] > ConvexHull(walled).area + MARGIN_MM - 0.3
    assert found.interval_mm[1] < ConvexHull(walled).area + MARGIN_MM + 2.0
