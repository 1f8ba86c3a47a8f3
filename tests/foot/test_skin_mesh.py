import numpy as np
import pytest
import trimesh
from scipy.spatial import KDTree

from footscan.errors import MeshError
from footscan.foot.nurbs import SplineTube, clamped_knots
from footscan.foot.skin_grid import grid_places
from footscan.foot.skin_mesh import fill_outline, inside_outline
from footscan.foot.skin_origin import Origin, classify, find_covered


def kidney(count: int = 200) -> np.ndarray:
    t = 2.0 * np.pi * np.arange(count) / count
    return np.column_stack(
        [60.0 * np.cos(t), 25.0 * np.sin(t) - 20.0 * np.exp(-((np.cos(t) / 0.3) ** 2)) * (np.sin(t) > 0)]
    )


def area(xy: np.ndarray) -> float:
    ahead = np.roll(xy, -1, axis=0)
    return 0.5 * float((xy[:, 0] * ahead[:, 1] - ahead[:, 0] * xy[:, 1]).sum())


def test_a_hollow_outline_is_filled_without_overlap() -> None:
    xy = kidney()

    inner, facets = fill_outline(xy, 3.0, "sole")
    points = np.column_stack([np.concatenate([xy, inner]), np.zeros(len(xy) + len(inner))])
    sheet = trimesh.Trimesh(points, facets, process=False)

    assert sheet.area == pytest.approx(area(xy), rel=1e-9)
    assert np.all(sheet.face_normals[:, 2] > 0)
    assert len(inner) > 50


def test_long_edges_of_an_outline_leave_inner_points_too() -> None:
    xy = kidney(60)  # edges up to four times the facet

    inner, facets = fill_outline(xy, 1.6, "sole")

    assert np.linalg.norm(np.roll(xy, -1, axis=0) - xy, axis=1).max() > 4.0
    assert len(inner) > 1000
    assert len(facets) == 2 * len(inner) + len(xy) - 2


def test_an_outline_that_crosses_itself_is_refused() -> None:
    t = 2.0 * np.pi * np.arange(100) / 100
    eight = np.column_stack([50.0 * np.sin(t), 20.0 * np.sin(2.0 * t)])

    with pytest.raises(MeshError, match="outline of the cut crosses itself"):
        fill_outline(eight, 3.0, "cut")


def test_inside_agrees_with_a_circle() -> None:
    t = 2.0 * np.pi * np.arange(400) / 400
    points = np.random.default_rng(2).uniform(-1.2, 1.2, (500, 2))
    radius = np.hypot(points[:, 0], points[:, 1])
    clear = np.abs(radius - 1.0) > 1e-3

    inside = inside_outline(points, np.column_stack([np.cos(t), np.sin(t)]))

    np.testing.assert_array_equal(inside[clear], radius[clear] < 1.0)


def test_gaps_between_stripes_close_and_the_border_stays() -> None:
    x, y = np.meshgrid(np.arange(0.0, 60.0, 3.6), np.arange(0.0, 30.0, 0.7))
    tree = KDTree(np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]))
    gx, gy = np.meshgrid(np.arange(10.0, 50.0, 0.5), np.arange(-10.0, 25.0, 0.5))
    places = np.column_stack([gx.ravel(), gy.ravel(), np.zeros(gx.size)])

    covered = find_covered(places, tree, np.full(len(places), 2.9), 0.5)

    assert covered[places[:, 1] > 1.0].all()
    assert not covered[places[:, 1] < -1.0].any()


def test_unseen_skin_is_assumed_sole_only_below_the_lowest_seen_skin() -> None:
    covered = np.array([True, False, False, True])

    classes = classify(covered, np.array([0.05, 0.05, 0.5, 0.5]), np.full(4, 0.1))

    assert classes.tolist() == [Origin.SEEN, Origin.ASSUMED_SOLE, Origin.BRIDGED, Origin.SEEN]


def test_columns_lie_closer_where_a_tube_bends_and_nowhere_further_apart_than_asked() -> None:
    turn = 2.0 * np.pi * np.arange(120) / 120
    ring = np.column_stack([100.0 * np.cos(turn), 25.0 * np.sin(turn)])
    knots = clamped_knots(np.linspace(0.0, 1.0, 11))
    height = np.linspace(0.0, 60.0, len(knots) - 4)
    net = np.concatenate([np.tile(ring, (len(height), 1, 1)), np.repeat(height, 120).reshape(-1, 120, 1)], axis=2)
    tube = SplineTube(net, knots)

    u, v = grid_places(tube, 2.0)
    places = tube.grid(u, np.array([0.5]))[0]
    step = np.linalg.norm(np.roll(places, -1, axis=0) - places, axis=1)
    at_ends = np.abs(places[:, 0]) > 99.0

    assert step.max() < 2.05
    assert step[at_ends].max() < 1.1
    assert np.diff(v).max() * 60.0 < 4.0
    assert u[0] == v[0] == 0.0
    assert v[-1] == 1.0
    assert u[-1] < 1.0
