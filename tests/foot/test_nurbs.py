import numpy as np
import pytest
from geomdl import exchange

from footscan.foot.nurbs import SplineTube, clamped_knots, graded_breaks, greville
from footscan.foot.nurbs_fit import distance_mm, evaluate_at, fit_tube, nearer_parameters
from footscan.foot.surface_files import geomdl_surface, save_surface_json


@pytest.fixture
def tube() -> SplineTube:
    rng = np.random.default_rng(3)
    knots = clamped_knots(np.array([0.0, 0.1, 0.3, 0.5, 0.75, 1.0]))
    turn = 2.0 * np.pi * np.arange(16) / 16
    rise = 100.0 * greville(knots)[:, None]
    net = np.stack(np.broadcast_arrays(40 * np.cos(turn), 30 * np.sin(turn), rise), axis=2)
    return SplineTube(net + rng.normal(0.0, 2.0, net.shape), knots)


def test_scattered_evaluation_agrees_with_the_grid(tube: SplineTube) -> None:
    u, v = np.array([0.0, 0.13, 0.5, 0.97]), np.array([0.0, 0.3, 0.61, 1.0 - 1e-12])

    along_u = np.diagonal(tube.grid(u, v, order_u=1)).T
    along_v = np.diagonal(tube.grid(u, v, order_v=1)).T
    found = evaluate_at(tube, u, v)

    np.testing.assert_allclose(found.xyz_mm, np.diagonal(tube.grid(u, v)).T, atol=1e-9)
    np.testing.assert_allclose(found.along_u, along_u, atol=1e-6)
    np.testing.assert_allclose(found.along_v, along_v, atol=1e-6)


def test_the_tube_closes_smoothly_around(tube: SplineTube) -> None:
    v = np.linspace(0.0, 1.0, 9)
    for order in (0, 1, 2):
        before = tube.grid(np.array([1.0 - 1e-10]), v, order_u=order)
        after = tube.grid(np.array([0.0]), v, order_u=order)

        np.testing.assert_allclose(before, after, atol=1e-2 * 16**order * 1e-3)


def test_a_fit_without_stiffness_gives_back_the_tube_that_was_sampled(tube: SplineTube) -> None:
    rng = np.random.default_rng(5)
    u, v = rng.random(4000), rng.random(4000)
    xyz = evaluate_at(tube, u, v).xyz_mm

    fitted = fit_tube(
        u, v, xyz, rng.uniform(0.1, 1.0, 4000), tube.count_u, tube.knots_v, np.zeros(tube.net_mm.shape[:2])
    )

    np.testing.assert_allclose(fitted.net_mm, tube.net_mm, atol=1e-5)


def test_stiffness_bridges_a_gap_without_points_smoothly() -> None:
    rng = np.random.default_rng(6)
    knots = clamped_knots(np.linspace(0.0, 1.0, 15))
    u, v = rng.random(6000), rng.random(6000)
    kept = ~((np.abs(u - 0.5) < 0.08) & (np.abs(v - 0.5) < 0.12))
    u, v = u[kept], v[kept]
    xyz = np.stack([40 * np.cos(2 * np.pi * u), 40 * np.sin(2 * np.pi * u), 100 * v], axis=1)

    fitted = fit_tube(u, v, xyz, np.ones(len(u)), 40, knots, np.full((len(knots) - 4, 40), 0.01))
    radius = np.hypot(*fitted.grid(np.linspace(0.4, 0.6, 15), np.linspace(0.3, 0.7, 15))[..., :2].T)

    assert np.abs(radius - 40.0).max() < 0.5


def test_corrected_parameters_bring_points_to_their_feet(tube: SplineTube) -> None:
    u, v = np.linspace(0.05, 0.95, 40), np.linspace(0.1, 0.9, 40)
    here = evaluate_at(tube, u, v)
    normal = np.cross(here.along_u, here.along_v)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    points = here.xyz_mm + 0.5 * normal

    near_u, near_v = u + 0.004, v - 0.004
    for _ in range(12):
        near_u, near_v = nearer_parameters(tube, near_u, near_v, points, (0.01, 0.01))

    np.testing.assert_allclose(near_u, u, atol=1e-4)
    np.testing.assert_allclose(near_v, v, atol=1e-4)
    np.testing.assert_allclose(distance_mm(tube, near_u, near_v, points), 0.5, atol=1e-4)


def test_graded_breaks_are_dense_where_density_is_high() -> None:
    breaks = graded_breaks(np.array([3.0, 3.0, 3.0, 1.0, 1.0, 1.0]), 12)

    assert breaks[0] == 0.0
    assert breaks[-1] == pytest.approx(1.0)
    assert np.all(np.diff(breaks) > 0)
    assert np.diff(breaks)[-1] / np.diff(breaks)[0] == pytest.approx(3.0, rel=0.01)


def test_geomdl_evaluates_to_the_same_surface(tube: SplineTube) -> None:
    shape = geomdl_surface(tube)
    for u, v in [(0.0, 0.0), (1.0, 1.0), (0.37, 0.62), (0.999, 0.001), (0.04, 0.96)]:
        ours = tube.grid(np.array([u]), np.array([v]))[0, 0]

        np.testing.assert_allclose(shape.evaluate_single([u, v]), ours, atol=1e-9)


def test_geomdl_reads_the_json_as_the_same_surface(tube: SplineTube, tmp_path) -> None:
    save_surface_json(tube, tmp_path / "surface.json")

    (shape,) = exchange.import_json(str(tmp_path / "surface.json"))

    for u, v in np.random.default_rng(1).random((25, 2)):
        ours = tube.grid(np.array([u]), np.array([v]))[0, 0]

        np.testing.assert_allclose(shape.evaluate_single([u, v]), ours, atol=1e-6)
