from dataclasses import replace

import numpy as np
import pytest

from footscan.foot.nurbs import SplineTube, clamped_knots
from footscan.foot.smoothing import FilterSettings, filter_cloud, smooth_surface, smooth_tube
from footscan.foot.surface import FootSurface, fit_foot_surface
from tests.foot.smooth_foot_cloud import FootCloud, distance_mm, foot_cloud


@pytest.fixture(scope="module")
def noisy() -> FootCloud:
    return foot_cloud(noise_mm=0.3, stripes=160)


@pytest.fixture(scope="module")
def surface(noisy: FootCloud) -> FootSurface:
    return fit_foot_surface(noisy.xyz, noisy.weight, noisy.laser)


def rms(xyz: np.ndarray) -> float:
    return float(np.sqrt((distance_mm(xyz) ** 2).mean()))


def test_filtering_takes_noise_away_and_keeps_the_original(noisy: FootCloud) -> None:
    before = noisy.xyz.copy()

    filtered = filter_cloud(noisy.xyz, FilterSettings(strength=1.0))

    assert rms(filtered.xyz_world) < 0.6 * rms(noisy.xyz)
    np.testing.assert_array_equal(noisy.xyz, before)
    np.testing.assert_array_equal(filtered.original_mm, before)
    assert filtered.largest_move_mm <= 1.0


def test_no_strength_moves_nothing(noisy: FootCloud) -> None:
    filtered = filter_cloud(noisy.xyz, FilterSettings(strength=0.0, drop_mm=None))

    np.testing.assert_array_equal(filtered.xyz_world, noisy.xyz)
    assert filtered.kept.all()


def test_points_that_stand_off_are_dropped(noisy: FootCloud) -> None:
    spoiled = noisy.xyz.copy()
    spoiled[1000, :2] *= 1.15

    filtered = filter_cloud(spoiled, FilterSettings(drop_mm=3.0))

    assert not filtered.kept[1000]
    assert filtered.kept.mean() > 0.999


def test_a_strength_beyond_one_is_refused(noisy: FootCloud) -> None:
    with pytest.raises(ValueError, match="strength of 0 to 1"):
        filter_cloud(noisy.xyz, FilterSettings(strength=1.5))


def test_smoothing_states_volume_extents_and_measurements_before_and_after(surface: FootSurface) -> None:
    smoothed = smooth_surface(surface, 12.0, lambda mesh: {"facets": float(len(mesh.faces))}, facet_mm=4.0)

    assert smoothed.original is surface
    assert {"volume_cm3", "extent_x_mm", "extent_y_mm", "extent_z_mm", "facets"} <= set(smoothed.before)
    assert smoothed.before.keys() == smoothed.after.keys() == smoothed.change.keys()
    assert smoothed.change["extent_z_mm"] == pytest.approx(0.0, abs=1e-9)
    assert 0.0 < abs(smoothed.change["volume_cm3"]) < 0.01 * smoothed.before["volume_cm3"]
    assert smoothed.after["rms_to_points_mm"] > smoothed.before["rms_to_points_mm"]


def test_smoothing_makes_the_skin_less_rough(surface: FootSurface) -> None:
    def roughness(foot: FootSurface) -> float:
        bend = foot.tube.grid(np.linspace(0, 1, 400), np.linspace(0.2, 0.9, 100), order_u=2)
        return float(np.square(bend).sum())

    smoothed = smooth_surface(surface, 12.0, facet_mm=4.0)

    assert roughness(smoothed.surface) < 0.8 * roughness(surface)


@pytest.mark.parametrize(("waves", "kept"), [(20, 1 / 17), (10, 1 / 2), (5, 16 / 17)])
def test_waves_of_the_smoothing_length_lose_half_their_height_however_close_the_columns_are(
    waves: int, kept: float
) -> None:
    share = np.arange(160) / 160
    turn = 2 * np.pi * share + 0.6 * np.sin(2 * np.pi * share)
    circle = np.stack([50 * np.cos(turn), 50 * np.sin(turn), np.zeros(160)], axis=1)
    net = circle + np.arange(0.0, 600.0, 8.0)[:, None, None] * np.array([0.0, 0.0, 1.0])
    tube = SplineTube(net, clamped_knots(np.linspace(0.0, 1.0, len(net) - 2)))
    ripple = np.zeros_like(net)
    ripple[..., 2] = 1e-3 * np.sin(waves * turn)

    left = smooth_tube(replace(tube, net_mm=net + ripple), 10 * np.pi).net_mm - smooth_tube(tube, 10 * np.pi).net_mm

    middle, wave = left[len(net) // 2, :, 2], ripple[0, :, 2]
    for part in (np.abs(turn - np.pi) < 1.0, np.abs(turn - np.pi) > 2.0):
        assert middle[part] @ wave[part] / (wave[part] @ wave[part]) == pytest.approx(kept, abs=0.04)


def test_no_length_changes_nothing(surface: FootSurface) -> None:
    smoothed = smooth_surface(surface, 0.0, facet_mm=4.0)

    np.testing.assert_array_equal(smoothed.surface.tube.net_mm, surface.tube.net_mm)
    assert set(smoothed.change.values()) == {0.0}


def test_a_negative_length_is_refused(surface: FootSurface) -> None:
    with pytest.raises(ValueError, match="cannot be negative"):
        smooth_surface(surface, -1.0)
