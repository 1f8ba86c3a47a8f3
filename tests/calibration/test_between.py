"""Between calibrations: the alignment view, the re-check and the renewal of one part, against the exact machine."""

from dataclasses import replace

import numpy as np
import pytest

from footscan.calibration.alignment import Alignment, SheetAlignment, measure_alignment
from footscan.calibration.estimate import moved_machine, sheet_from_angles, start_estimate
from footscan.calibration.intake import Intake
from footscan.calibration.joint import lowered
from footscan.calibration.one_placement import recheck
from footscan.calibration.picture_figures import stripe_figures
from footscan.calibration.renew import renew
from footscan.calibration.sightings import StripePoints
from footscan.calibration.uncertainty import machine_difference_mm
from footscan.errors import PoorFitError
from footscan.optics import Calibration
from footscan.workflow.calibration_checks import RECHECK_LIMITS, Rechecked, broken_limits
from tests.calibration.conftest import Shared


@pytest.fixture(scope="session")
def one(shared: Shared) -> tuple[Intake, StripePoints]:
    """What the first placement and the bare footboard of the shared recording show."""
    intake, stripes = shared.intake, shared.stripes
    corners = intake.corners.kept(intake.corners.placement == 0)
    few = replace(intake, corners=corners, placement_names=intake.placement_names[:1])
    return few, stripes.kept(stripes.placement <= 0)


def _checked(one: tuple[Intake, StripePoints], machine: Calibration) -> Rechecked:
    found = recheck(*one, machine)
    return Rechecked(found, tuple(broken_limits(found, RECHECK_LIMITS)))


def test_the_alignment_view_finds_both_sheets_from_one_placement(one: tuple[Intake, StripePoints], shared: Shared):
    found = measure_alignment(*one)

    for seen, true in zip(found.sheets, shared.truth.lasers, strict=True):
        assert seen.offset_mm == pytest.approx(true.offset_mm, abs=0.1)
        assert seen.lean_deg == pytest.approx(np.degrees(np.arcsin(true.normal[2])), abs=0.05)
        assert 1.5 < seen.width_px["middle"] < 6.0
    assert 0.4 < found.blur_px < 1.3
    assert found.white_grey > 3.0 * found.black_grey


def _sheet(offset_mm: float = 0.0, lean_deg: float = 0.0, width_px: float = 3.0, peak: float = 80.0) -> SheetAlignment:
    width = {"near": width_px, "middle": width_px, "far": float("nan")}
    return SheetAlignment("right", offset_mm, lean_deg, 0.0, width, width, peak, 0.0)


@pytest.mark.parametrize(
    ("sheet", "words"),
    [
        (_sheet(offset_mm=1.2), "shift it by 1.2 mm to the left"),
        (_sheet(offset_mm=-1.2), "shift it by 1.2 mm to the right"),
        (_sheet(lean_deg=0.4), "0.40 degrees clockwise"),
        (_sheet(lean_deg=-0.4), "0.40 degrees counter-clockwise"),
        (_sheet(width_px=9.0), "focus its line"),
        (_sheet(peak=10.0), "expose longer"),
        (_sheet(peak=255.0), "shorten the exposure"),
    ],
)
def test_the_alignment_view_says_which_way_to_turn(sheet: SheetAlignment, words: str):
    assert any(words in said for said in sheet.advice())
    assert Alignment((_sheet(), _sheet()), 0.8, 100.0, 5.0).advice() == []


def test_a_sheet_to_the_right_of_the_axis_has_a_positive_offset_as_seen_from_its_laser(ideal: Calibration):
    right = np.array(ideal.lasers[0].normal)
    forward = np.array([-right[1], right[0], 0.0])  # from the laser through the axis

    np.testing.assert_allclose(np.cross(forward, [0.0, 0.0, 1.0]), right, atol=1e-12)


def test_the_width_of_a_line_is_measured_in_any_direction():
    row, column = np.mgrid[:200, :200]
    for angle in (0.0, 0.6, 1.3):
        across = (column - 100) * np.cos(angle) + (row - 100) * np.sin(angle)
        frame = (180.0 * np.exp(-(across**2) / (2.0 * 2.0**2))).astype(np.uint8)
        along = np.linspace(-60.0, 60.0, 80)[:, None] * np.array([-np.sin(angle), np.cos(angle)])
        found = stripe_figures(frame, along + 100.0)

        assert np.nanmedian(found.width_px) == pytest.approx(2.355 * 2.0, abs=0.3)


def test_the_true_calibration_holds(one: tuple[Intake, StripePoints], shared: Shared):
    assert _checked(one, shared.truth).broken == ()


@pytest.mark.parametrize(
    ("name", "step", "part"),
    [
        ("focal_length_mm", 0.03, "camera"),
        ("principal_point_y_px", 0.7, "camera"),
        ("principal_point_z_px", 0.7, "footboard"),
        ("right_offset_mm", 0.2, "right laser"),
        ("left_azimuth_rad", 0.004, "left laser"),
    ],
)
def test_a_calibration_that_no_longer_holds_is_found_by_one_placement(
    one: tuple[Intake, StripePoints], shared: Shared, name: str, step: float, part: str
):
    checked = _checked(one, moved_machine(shared.truth, name, step))

    assert not checked.holds
    assert any(said.startswith(part) for said in checked.broken)


def test_a_new_laser_is_estimated_alone(shared: Shared):
    right, left = shared.truth.lasers
    before = replace(shared.truth, lasers=(sheet_from_angles(right, np.deg2rad(43.5), 0.02, 1.5), left))
    made = renew(shared.intake, shared.stripes, before, "right-laser")
    off = machine_difference_mm(made.calibration, shared.truth)

    assert float(np.sqrt(np.mean(off["right"] ** 2))) < 0.03
    assert made.calibration.lasers[1] == left
    assert made.calibration.camera == shared.truth.camera


def test_a_renewal_is_refused_when_more_has_changed(shared: Shared):
    right, left = shared.truth.lasers
    before = replace(shared.truth, lasers=(sheet_from_angles(right, np.deg2rad(43.5), 0.02, 1.5), left))

    with pytest.raises(PoorFitError, match=r"left-laser cannot be renewed alone.*right laser"):
        renew(shared.intake, shared.stripes, before, "left-laser")


def test_a_new_encoder_is_found_with_its_direction(one: tuple[Intake, StripePoints], shared: Shared):
    encoder = shared.truth.encoder
    before = replace(shared.truth, encoder=replace(encoder, direction=-encoder.direction), latency_s=0.1)
    made = renew(*one, before, "encoder").calibration

    assert made.encoder.direction == encoder.direction
    assert made.encoder.zero_count == shared.intake.recording.scanner.encoder.zero_count
    assert made.latency_s == pytest.approx(shared.truth.latency_s, abs=1e-3)


def test_a_new_footboard_is_found_with_its_height(one: tuple[Intake, StripePoints], shared: Shared):
    tilted = moved_machine(shared.truth, "floor_slope_x", 0.004)
    before = lowered(start_estimate(tilted, np.eye(4)[None]), 1.0).machine
    made = renew(*one, before, "footboard").calibration

    off = machine_difference_mm(made, shared.truth)
    assert max(float(d.max()) for d in off.values()) < 0.02
    assert np.degrees(np.arccos(made.floor.normal_array @ shared.truth.floor.normal_array)) < 0.01
