import numpy as np
import pytest
import trimesh

from footscan.scanning.cloud import Cloud
from footscan.sim.surface import Surface
from footscan.workflow.cloud_comparison import clouds_apart, rms_apart


def wavy(rng: np.random.Generator, points: int, noise_mm: float = 0.0) -> Cloud:
    """A patch of 60 x 60 mm, gently curved, at 50 mm above the board."""
    x, y = rng.uniform(-30.0, 30.0, (2, points))
    z = 50.0 + 4.0 * np.cos(x / 30.0) + noise_mm * rng.standard_normal(points)
    frame = rng.integers(0, 20, points)
    return Cloud(np.stack([x, y, z], axis=1), np.zeros(points, np.int64), np.ones(points, np.float32), frame)


def moved(cloud: Cloud, by_mm: tuple[float, float, float]) -> Cloud:
    return Cloud(cloud.xyz_world + np.array(by_mm), cloud.laser, cloud.weight, cloud.frame)


def test_the_same_points_are_as_far_apart_as_they_were_moved(rng: np.random.Generator):
    cloud = wavy(rng, 2000)

    assert rms_apart(cloud, moved(cloud, (0.0, 0.03, -0.04))) == pytest.approx(0.05, rel=1e-6)


def skin() -> Surface:
    """What `wavy` lies on, closed below."""
    x, y = (part.ravel() for part in np.meshgrid(np.linspace(-40, 40, 161), [-40.0, 40.0]))
    top = np.stack([x, y, 50.0 + 4.0 * np.cos(x / 30.0)], axis=1)
    hull = trimesh.Trimesh(np.concatenate([top, top * [1, 1, 0]])).convex_hull
    return Surface(np.asarray(hull.vertices), np.asarray(hull.faces))


def test_clouds_are_compared_across_the_skin_and_not_along_it_nor_by_their_noise(rng: np.random.Generator):
    one, other = wavy(rng, 40_000, noise_mm=0.05), wavy(rng, 10_000, noise_mm=0.05)

    assert clouds_apart(one, other, skin()) < 0.03
    assert clouds_apart(one, moved(other, (0.0, 1.0, 0.0)), skin()) < 0.03
    assert clouds_apart(one, moved(other, (0.0, 0.0, 0.1)), skin()) == pytest.approx(0.1, abs=0.01)
