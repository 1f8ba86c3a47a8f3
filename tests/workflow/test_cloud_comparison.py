import numpy as np
import pytest

from footscan.scanning.cloud import Cloud
from footscan.workflow.cloud_comparison import points_apart, skins_apart


def wavy(rng: np.random.Generator, points: int, noise_mm: float = 0.0) -> Cloud:
    """A patch of 60 x 60 mm, gently curved, at 50 mm above the board."""
    x, y = rng.uniform(-30.0, 30.0, (2, points))
    z = 50.0 + 4.0 * np.cos(x / 30.0) + noise_mm * rng.standard_normal(points)
    frame = rng.integers(0, 20, points)
    return Cloud(np.stack([x, y, z], axis=1), np.zeros(points, np.int64), np.ones(points, np.float32), frame)


def moved(cloud: Cloud, by_mm: tuple[float, float, float]) -> Cloud:
    return Cloud(cloud.xyz_world + np.array(by_mm), cloud.laser, cloud.weight, cloud.frame)


def test_points_of_the_same_frames_are_as_far_apart_as_they_were_moved(rng: np.random.Generator):
    cloud = wavy(rng, 2000)
    apart_mm, share = points_apart(cloud, moved(cloud, (0.0, 0.03, -0.04)))

    assert apart_mm == pytest.approx(0.05, rel=1e-6)
    assert share == 1.0


def test_points_of_other_frames_are_no_partners(rng: np.random.Generator):
    cloud = wavy(rng, 2000)
    later = Cloud(cloud.xyz_world, cloud.laser, cloud.weight, cloud.frame + 100)

    assert points_apart(cloud, later)[1] == 0.0


def test_skins_are_compared_across_and_not_along_and_through_their_noise(rng: np.random.Generator):
    one, other = wavy(rng, 40_000, noise_mm=0.05), wavy(rng, 40_000, noise_mm=0.05)

    assert skins_apart(one, other) < 0.03
    assert skins_apart(one, moved(other, (0.0, 1.0, 0.0))) < 0.03
    assert skins_apart(one, moved(other, (0.0, 0.0, 0.1))) == pytest.approx(0.1, abs=0.01)
