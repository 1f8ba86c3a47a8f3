"""Fits of spheres and planes and the figures of an acceptance test, on points whose answer is known."""

import numpy as np
import pytest

from footscan.calibration.artefact import find_plane, find_sphere, fit_sphere, plane_figures, sphere_figures
from footscan.calibration.monoview import fit_monoview
from footscan.coordinates import Floats
from footscan.errors import EmptyScanError
from footscan.optics import Calibration

_CENTRE = np.array([10.0, -20.0, 60.0])


def _cap(rng: np.random.Generator, count: int, radius_mm: float, half_angle_deg: float, noise_mm: float) -> Floats:
    """Points evenly over a cap that opens upwards."""
    z = rng.uniform(np.cos(np.deg2rad(half_angle_deg)), 1.0, count)
    turn = rng.uniform(0.0, 2.0 * np.pi, count)
    ring = np.sqrt(1.0 - z**2)
    unit = np.column_stack([ring * np.cos(turn), ring * np.sin(turn), z])
    return _CENTRE + unit * (radius_mm + noise_mm * rng.standard_normal((count, 1)))


def test_a_sphere_without_noise_is_fitted_exactly(rng: np.random.Generator):
    sphere = fit_sphere(_cap(rng, 500, 30.0, 70.0, 0.0), _CENTRE + 3.0)

    np.testing.assert_allclose(sphere.centre, _CENTRE, atol=1e-9)
    assert sphere.diameter_mm == pytest.approx(60.0, abs=1e-9)


@pytest.mark.parametrize(("half_angle_deg", "sd_mm"), [(60.0, 0.040), (90.0, 0.015)])
def test_the_diameter_scatters_as_a_partial_sphere_must(half_angle_deg: float, sd_mm: float):
    rng = np.random.default_rng(1)
    caps = [_cap(rng, 3000, 30.0, half_angle_deg, 0.2) for _ in range(40)]
    off = [fit_sphere(cap, _CENTRE).diameter_mm - 60.0 for cap in caps]

    assert 0.6 * sd_mm < float(np.std(off)) < 1.5 * sd_mm


def test_the_figures_of_gaussian_noise_are_those_of_its_theory(rng: np.random.Generator):
    _, figures = sphere_figures(_cap(rng, 20000, 30.0, 120.0, 0.2), 60.1, _CENTRE)

    assert figures.sigma_mm == pytest.approx(0.2, rel=0.03)
    assert figures.d95_mm == pytest.approx(3.92 * 0.2, rel=0.04)
    assert 5.0 < figures.form_mm / 0.2 < 8.1
    assert figures.size_error_mm == pytest.approx(-0.1, abs=0.02)
    assert figures.coverage_deg == pytest.approx(119.0, abs=1.5)


def test_both_balls_of_a_bar_are_found_among_other_things(rng: np.random.Generator):
    one, two = _cap(rng, 2000, 25.0, 120.0, 0.05), _cap(rng, 1500, 25.0, 120.0, 0.05) + np.array([200.0, 0.0, 0.0])
    clutter = rng.uniform(-150.0, 250.0, (600, 3))
    everything = np.vstack([one, two, clutter])
    first, on = find_sphere(everything, 50.0)
    second, _ = find_sphere(everything[~on], 50.0)

    assert np.linalg.norm(second.centre - first.centre) == pytest.approx(200.0, abs=0.05)


def test_a_sphere_of_another_size_is_not_taken_for_this_one(rng: np.random.Generator):
    with pytest.raises(EmptyScanError, match="on a sphere of 80 mm"):
        find_sphere(_cap(rng, 2000, 25.0, 120.0, 0.05), 80.0)


def test_the_flatness_of_a_plane_is_found_beside_clutter(rng: np.random.Generator):
    flat = np.column_stack([rng.uniform(-90, 90, (4000, 2)), 100.0 + 0.05 * rng.standard_normal(4000)])
    everything = np.vstack([flat, rng.uniform(-90.0, 200.0, (500, 3))])
    on = find_plane(everything)
    figures = plane_figures(everything[on])

    assert np.mean(on[:4000]) == 1.0
    assert figures.d95_mm == pytest.approx(3.92 * 0.05, rel=0.25)
    assert np.isnan(figures.size_error_mm)


def test_three_control_points_are_too_few_for_one_view(ideal: Calibration):
    with pytest.raises(ValueError, match="at least 4"):
        fit_monoview(ideal, np.zeros((3, 2)), np.zeros((3, 2)))
