"""The shared calibration recording, sound and spoilt: fitted within the limits, or refused with the right reason."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footscan.calibration.calibrate import Calibrated
from footscan.calibration.estimate import Estimate
from footscan.calibration.intake import Intake, take_in
from footscan.calibration.joint import fit_corners
from footscan.calibration.misfit import corner_misfit_px, head_angles
from footscan.calibration.sightings import NO_STRIPES, Sightings
from footscan.calibration.uncertainty import expected_error_mm, machine_difference_mm
from footscan.coordinates import Bools, Floats
from footscan.errors import PoorFitError, RecordingError
from footscan.scanning.recording import open_recording
from tests.calibration.conftest import Calibrate, Shared


def _assert_within_limits(result: Calibrated, shared: Shared, rms_mm: float = 0.05) -> None:
    off = machine_difference_mm(result.calibration, shared.truth)
    assert max(float(np.sqrt(np.mean(d**2))) for d in off.values()) < rms_mm
    assert max(float(d.max()) for d in off.values()) < 3.0 * rms_mm
    assert abs(result.calibration.latency_s - shared.truth.latency_s) < 1e-3


@pytest.fixture(scope="session")
def posed(shared: Shared) -> Estimate:
    return fit_corners(shared.intake).estimate


def _with_corners(shared: Shared, where: Bools, shift_px: Floats) -> Intake:
    corners = shared.intake.corners
    moved = corners.yz_pixel + np.where(where[:, None], shift_px, 0.0)
    return replace(shared.intake, corners=replace(corners, yz_pixel=moved))


def _shift_px(shared: Shared, posed: Estimate, changed: Estimate) -> Floats:
    """How far the corners move in the picture when boards are changed."""
    sightings = Sightings(shared.intake.times, shared.intake.corners, NO_STRIPES, shared.intake.placement_names)
    theta_rad = head_angles(posed, sightings)
    before, after = (corner_misfit_px(e, shared.intake.corners, theta_rad) for e in (posed, changed))
    return before - after


def test_the_sound_recording_gives_the_machine_and_an_honest_error(shared: Shared, calibrate_seen: Calibrate):
    result = calibrate_seen()
    _assert_within_limits(result, shared, rms_mm=0.02)
    expected, off = expected_error_mm(result.joint.fit), machine_difference_mm(result.calibration, shared.truth)

    assert all(gate.passed and ": " in gate.finding() for gate in result.gates)
    for name, error in expected.items():
        assert 1.0 / 3.0 < float(np.sqrt(np.mean(off[name] ** 2) / np.mean(error**2))) < 3.0


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_one_sided_outliers_do_no_harm(shared: Shared, calibrate_seen: Calibrate, share: float):
    rng = np.random.default_rng(3)
    places = shared.stripes.yz_pixel.copy()
    bad = rng.random(len(places)) < share
    places[bad, 1] += rng.uniform(0.3, 6.0, np.count_nonzero(bad))
    try:
        result = calibrate_seen(stripes=replace(shared.stripes, yz_pixel=places))
    except PoorFitError as refusal:
        assert "stripe" in str(refusal)
        return

    _assert_within_limits(result, shared)


@pytest.mark.parametrize("longer", [1.001, 1.01])
def test_unequal_scale_of_the_print_is_refused_as_such(shared: Shared, calibrate_seen: Calibrate, longer: float):
    corners = shared.intake.corners
    stretched = replace(corners, xy_board=corners.xy_board * np.array([longer, 1.0]))

    with pytest.raises(PoorFitError, match="print scale unequal"):
        calibrate_seen(replace(shared.intake, corners=stretched))


def test_one_board_of_another_size_is_named(shared: Shared, calibrate_seen: Calibrate):
    corners = shared.intake.corners
    other = np.where((corners.placement == 2)[:, None], 1.003, 1.0)

    with pytest.raises(PoorFitError, match=r"differs in size from the others by a share \(placement 2\)"):
        calibrate_seen(replace(shared.intake, corners=replace(corners, xy_board=corners.xy_board * other)))


def test_a_bent_board_is_refused_as_such(shared: Shared, posed: Estimate, calibrate_seen: Calibrate):
    doubts = posed.doubts.copy()
    doubts[:, 2] = 0.5 / 105.0**2
    every = np.ones(len(shared.intake.corners), dtype=bool)

    with pytest.raises(PoorFitError, match="board is bent"):
        calibrate_seen(_with_corners(shared, every, _shift_px(shared, posed, replace(posed, doubts=doubts))))


@pytest.mark.parametrize("size_mm", [0.5, 20.0])
def test_a_board_moved_between_stops_is_named_with_how_far(
    shared: Shared, posed: Estimate, calibrate_seen: Calibrate, size_mm: float
):
    boards, corners = posed.world_from_board.copy(), shared.intake.corners
    boards[3, :3, 3] += size_mm * np.array([0.6, 0.5, 0.62])
    boards[3, :3, :3] = Rotation.from_rotvec([0.0, 0.0, size_mm / 200.0]).as_matrix() @ boards[3, :3, :3]
    frames = np.unique(corners.frame[corners.placement == 3])
    late = (corners.placement == 3) & (corners.frame >= frames[len(frames) // 2])
    spoilt = _with_corners(shared, late, _shift_px(shared, posed, replace(posed, world_from_board=boards)))

    with pytest.raises(PoorFitError, match="placement 3: the board was moved by") as refusal:
        calibrate_seen(spoilt)
    said_mm = float(str(refusal.value).split("moved by ")[1].split(" mm")[0])
    assert said_mm == pytest.approx(size_mm, rel=0.02, abs=0.1)


def test_frames_exchanged_between_stops_are_refused(shared: Shared, calibrate_seen: Calibrate):
    corners = shared.intake.corners
    frames = np.unique(corners.frame[corners.placement == 4])
    other = corners.frame.copy()
    other[corners.frame == frames[2]], other[corners.frame == frames[5]] = frames[5], frames[2]

    with pytest.raises(PoorFitError, match="placement 4: its frames contradict"):
        calibrate_seen(replace(shared.intake, corners=replace(corners, frame=other)))


@pytest.mark.parametrize("shift_px", [(0.2, 0.0), (0.0, 1.0)])
def test_a_lens_knocked_between_placements_is_refused(
    shared: Shared, calibrate_seen: Calibrate, shift_px: tuple[float, float]
):
    corners, stripes = shared.intake.corners, shared.stripes
    spoilt = _with_corners(shared, (corners.placement >= 3) | corners.moving, np.array(shift_px))
    later = ((stripes.placement >= 3) | (stripes.placement < 0))[:, None]
    places = stripes.yz_pixel + np.where(later, np.array(shift_px), 0.0)

    with pytest.raises(PoorFitError, match=r"knocked|contradict"):
        calibrate_seen(spoilt, replace(stripes, yz_pixel=places))


@pytest.mark.parametrize("where", [None, 0, -1])
def test_mislabelled_lasers_are_refused_as_such(shared: Shared, calibrate_seen: Calibrate, where: int | None):
    stripes = shared.stripes
    wrong = np.ones(len(stripes), dtype=bool) if where is None else stripes.placement == where

    with pytest.raises(PoorFitError, match="lasers are mislabelled"):
        calibrate_seen(stripes=replace(stripes, laser=np.where(wrong, 1 - stripes.laser, stripes.laser)))


def test_an_encoder_that_counts_the_other_way_is_refused_as_such(shared: Shared, calibrate_seen: Calibrate):
    scanner = shared.intake.recording.scanner
    wrong = replace(scanner, encoder=replace(scanner.encoder, direction=-scanner.encoder.direction))

    with pytest.raises(PoorFitError, match="encoder counts the other way"):
        calibrate_seen(replace(shared.intake, recording=replace(shared.intake.recording, scanner=wrong)))


@pytest.mark.parametrize("times", [0.995, 2.0])
def test_an_encoder_with_another_number_of_steps_is_refused_as_such(
    shared: Shared, calibrate_seen: Calibrate, times: float
):
    scanner = shared.intake.recording.scanner
    right = scanner.encoder.steps_per_rev
    wrong = replace(scanner, encoder=replace(scanner.encoder, steps_per_rev=round(right * times)))

    with pytest.raises(PoorFitError, match="counts in these pictures") as refusal:
        calibrate_seen(replace(shared.intake, recording=replace(shared.intake.recording, scanner=wrong)))
    told = int(str(refusal.value).split("about ")[1].split(" ")[0])
    assert told == pytest.approx(right, rel=5e-4)


def test_frames_of_another_machine_are_refused(shared: Shared, calibrate_seen: Calibrate):
    scanner = shared.intake.recording.scanner
    other = replace(scanner, camera=replace(scanner.camera, focal_length_mm=12.0))

    with pytest.raises(PoorFitError, match="belong to another machine"):
        calibrate_seen(replace(shared.intake, recording=replace(shared.intake.recording, scanner=other)))


def test_one_placement_too_few_frames_missing_or_no_board_is_bad_input(shared: Shared):
    recording = open_recording(shared.folder)
    two = tuple(record for record in recording.frames if record.setup in ("0", "1", "empty"))
    unlit = tuple(record for record in recording.frames if record.setup != "empty")

    with pytest.raises(RecordingError, match="holds 2 placements"):
        take_in(replace(recording, frames=two))
    with pytest.raises(RecordingError, match="no frames of the bare footboard"):
        take_in(replace(recording, frames=unlit))


def test_a_wrong_dictionary_is_named(shared: Shared):
    recording = open_recording(shared.folder)
    assert recording.board is not None
    wrong = replace(recording.board, dictionary="DICT_6X6_50")
    some = tuple(r for r in recording.frames if r.setup == "empty" or r.frame % 9 == 0)

    with pytest.raises(RecordingError, match=r"another dictionary \(DICT_4X4_50\)"):
        take_in(replace(recording, frames=some), wrong)


def test_what_moved_between_the_stops_and_the_pass_is_not_blamed_on_the_stops(
    shared: Shared, calibrate_seen: Calibrate
):
    shift_px = np.array([0.0, 0.2])
    corners = shared.intake.corners
    spoilt = _with_corners(shared, (corners.placement >= 2) | corners.moving, shift_px)

    with pytest.raises(PoorFitError, match=r"while the head turned contradict those at its stops.*knocked"):
        calibrate_seen(spoilt)


def test_a_board_moved_by_little_is_not_taken_for_a_knocked_lens(
    shared: Shared, posed: Estimate, calibrate_seen: Calibrate
):
    boards, corners = posed.world_from_board.copy(), shared.intake.corners
    boards[4, :3, 3] += 0.2 * np.array([0.6, 0.5, 0.62])
    frames = np.unique(corners.frame[corners.placement == 4])
    late = (corners.placement == 4) & (corners.frame >= frames[len(frames) // 2])

    with pytest.raises(PoorFitError, match="placement 4: the board was moved by") as refusal:
        calibrate_seen(_with_corners(shared, late, _shift_px(shared, posed, replace(posed, world_from_board=boards))))
    assert refusal.value.repeat == "4"
