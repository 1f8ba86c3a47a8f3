"""The joint estimate: what it recovers from known sightings, how sure it says it is, and what it does not do."""

from dataclasses import replace

import numpy as np
import pytest

from footscan.calibration.estimate import LENS, MACHINE_MOVES, POSE, SHAPE, moved_boards, moved_machine
from footscan.calibration.joint import consensus_sheet, lowered
from footscan.calibration.misfit import corner_misfit_px, head_angles, stripe_misfit_mm
from footscan.calibration.residuals import CORNERS_GROUPS
from footscan.calibration.solve import fit_estimate
from footscan.calibration.synthetic import Synthetic, SyntheticPlan, make_sightings
from footscan.calibration.uncertainty import covariance, expected_error_mm, machine_difference_mm
from footscan.calibration.unknowns import EVERYTHING, Unknowns
from footscan.config import DEFAULT_BOARD
from footscan.optics import Calibration
from footscan.optics.calibration import theta_from_encoder


def _disturbed(made: Synthetic):
    """The truth with everything a little off, as a first guess is."""
    estimate = made.truth
    machine = estimate.machine
    for name, step in (
        ("focal_length_mm", -0.03),
        ("principal_point_y_px", 3.0),
        ("k1_per_mm2", 5e-4),
        ("phi_rad", 0.004),
        ("t_x_mm", 3.0),
        ("t_y_mm", -1.0),
        ("t_z_mm", 2.0),
        ("right_azimuth_rad", 0.005),
        ("left_offset_mm", 0.5),
        ("latency_s", -0.01),
    ):
        machine = moved_machine(machine, name, step)
    shifted = moved_boards(replace(estimate, machine=machine), "shift_x_mm", np.full(estimate.placements, 1.5))
    return moved_boards(shifted, "turn_z_rad", np.full(estimate.placements, 0.01))


def test_sightings_without_noise_fit_the_machine_that_made_them_to_a_thousandth_of_a_pixel(crooked: Calibration):
    made = make_sightings(crooked, DEFAULT_BOARD, SyntheticPlan(corner_noise_px=0.0, stripe_noise_px=0.0))
    theta_rad = head_angles(made.truth, made.sightings)

    assert np.abs(corner_misfit_px(made.truth, made.sightings.corners, theta_rad)).max() < 1e-6
    assert np.abs(stripe_misfit_mm(made.truth, made.sightings.stripes, theta_rad)).max() < 1e-6


def test_the_joint_estimate_recovers_a_crooked_machine_from_a_bad_first_guess(synthetic: Synthetic):
    fit = fit_estimate(_disturbed(synthetic), synthetic.sightings, EVERYTHING)
    off = machine_difference_mm(fit.estimate.machine, synthetic.truth.machine)

    assert fit.settled
    assert max(np.sqrt(np.mean(d**2)) for d in off.values()) < 0.02
    assert abs(fit.estimate.machine.latency_s - synthetic.truth.machine.latency_s) < 3e-4


def test_residual_scales_are_found_from_the_residuals(synthetic: Synthetic):
    fit = fit_estimate(synthetic.truth, synthetic.sightings, EVERYTHING)

    assert fit.scale_px[CORNERS_GROUPS[0]] == pytest.approx(0.03, rel=0.1)
    assert fit.scale_px[2] == pytest.approx(0.06, rel=0.15)


def test_the_expected_error_is_the_true_one_on_average(crooked: Calibration):
    ratios = []
    for seed in range(5):
        made = make_sightings(crooked, DEFAULT_BOARD, SyntheticPlan(seed=seed, stripe_step_mm=3.0))
        fit = fit_estimate(made.truth, made.sightings, EVERYTHING)
        expected, true = expected_error_mm(fit), machine_difference_mm(fit.estimate.machine, crooked)
        ratios += [np.sqrt(np.mean(true[name] ** 2) / np.mean(expected[name] ** 2)) for name in ("right", "left")]

    assert 0.5 < np.sqrt(np.mean(np.square(ratios))) < 2.0
    assert max(ratios) < 3.0


def test_thirty_percent_of_stripe_places_on_one_side_do_not_move_the_sheets(synthetic: Synthetic):
    rng = np.random.default_rng(2)
    stripes = synthetic.sightings.stripes
    shifted = stripes.yz_pixel.copy()
    bad = rng.random(len(stripes)) < 0.3
    shifted[bad, 1] += rng.uniform(1.0, 8.0, np.count_nonzero(bad))
    sightings = replace(synthetic.sightings, stripes=replace(stripes, yz_pixel=shifted))
    fit = fit_estimate(synthetic.truth, sightings, EVERYTHING)
    off = machine_difference_mm(fit.estimate.machine, synthetic.truth.machine)

    assert max(np.sqrt(np.mean(d**2)) for d in off.values()) < 0.03


def test_eccentricity_of_the_encoder_is_recovered_when_it_is_free(crooked: Calibration):
    turned = replace(crooked, encoder=replace(crooked.encoder, eccentricity_rad=3e-4, eccentricity_phase_rad=1.0))
    made = make_sightings(turned, DEFAULT_BOARD, SyntheticPlan(seed=1, stripe_step_mm=3.0))
    start = replace(made.truth, machine=replace(made.truth.machine, encoder=crooked.encoder))
    free = Unknowns((*EVERYTHING.machine, "eccentricity_cos_rad", "eccentricity_sin_rad"))
    encoder = fit_estimate(start, made.sightings, free).estimate.machine.encoder
    theta = np.linspace(-np.pi, np.pi, 50) * encoder.steps_per_rev / (2.0 * np.pi)

    assert np.ptp(theta_from_encoder(theta, encoder) - theta_from_encoder(theta, turned.encoder)) < 1e-4


def test_the_covariance_is_symmetric_and_knows_every_unknown(synthetic: Synthetic):
    fit = fit_estimate(synthetic.truth, synthetic.sightings, EVERYTHING)
    spread = covariance(fit)

    assert spread.shape[0] == len(fit.unknowns.names(fit.estimate.placements))
    np.testing.assert_allclose(spread, spread.T, atol=1e-12)
    assert np.all(np.diag(spread) > 0.0)


@pytest.mark.parametrize("name", sorted(MACHINE_MOVES))
def test_a_step_of_the_machine_and_its_opposite_cancel(crooked: Calibration, name: str):
    step = 1e-3 if name.endswith(("mm", "px")) else 1e-6
    turned = replace(crooked, encoder=replace(crooked.encoder, eccentricity_rad=1e-3, eccentricity_phase_rad=0.4))
    back = moved_machine(moved_machine(turned, name, step), name, -step)

    np.testing.assert_allclose(back.lasers[0].normal, turned.lasers[0].normal, atol=1e-12)
    np.testing.assert_allclose(back.pose.translation_mm, turned.pose.translation_mm, atol=1e-9)
    assert back.camera.focal_length_mm == pytest.approx(turned.camera.focal_length_mm, abs=1e-12)
    assert back.encoder.eccentricity_phase_rad == pytest.approx(turned.encoder.eccentricity_phase_rad, abs=1e-9)
    assert moved_machine(turned, name, step) != turned


@pytest.mark.parametrize("name", [*POSE, *SHAPE, *LENS])
def test_a_step_of_the_boards_and_its_opposite_cancel(synthetic: Synthetic, name: str):
    step = np.linspace(1e-3, 2e-3, synthetic.truth.placements)
    back = moved_boards(moved_boards(synthetic.truth, name, step), name, -step)

    np.testing.assert_allclose(back.world_from_board, synthetic.truth.world_from_board, atol=1e-9)
    np.testing.assert_allclose(back.doubts, 0.0, atol=1e-15)


def test_lowering_the_origin_changes_no_picture(synthetic: Synthetic):
    low = lowered(synthetic.truth, 7.5)
    theta_rad = head_angles(low, synthetic.sightings)
    corners = synthetic.sightings.corners
    on_boards = synthetic.sightings.stripes.kept(synthetic.sightings.stripes.placement >= 0)

    np.testing.assert_allclose(
        corner_misfit_px(low, corners, theta_rad), corner_misfit_px(synthetic.truth, corners, theta_rad), atol=1e-8
    )
    np.testing.assert_allclose(
        stripe_misfit_mm(low, on_boards, theta_rad), stripe_misfit_mm(synthetic.truth, on_boards, theta_rad), atol=1e-8
    )


def test_a_sheet_is_found_among_forty_percent_of_places_that_are_elsewhere(crooked: Calibration):
    rng = np.random.default_rng(4)
    sheet = crooked.lasers[0]
    normal = np.array(sheet.normal)
    xyz = rng.uniform(-80.0, 80.0, (500, 3))
    xyz -= ((xyz @ normal) - sheet.offset_mm)[:, None] * normal
    xyz[:200] += rng.uniform(1.0, 20.0, (200, 1)) * normal
    found = consensus_sheet(sheet, xyz)

    assert np.degrees(np.arccos(np.dot(found.normal, normal))) < 0.01
    assert found.offset_mm == pytest.approx(sheet.offset_mm, abs=0.01)
