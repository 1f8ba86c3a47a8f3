"""The guided calibration on the simulated machine: what it asks for, what it leaves out, and that it ends."""

from collections.abc import Generator
from dataclasses import replace

import pytest

from footscan import app
from footscan.config import DEFAULT_BOARD
from footscan.errors import InputError, PoorFitError
from footscan.scanning.recording import open_recording
from footscan.scanning.session.control import Session
from footscan.workflow import guided_calibration
from footscan.workflow.calibration_checks import align_recording, recheck_recording
from footscan.workflow.designs import builtin_rig
from footscan.workflow.guided_calibration import GuidedCalibration, PlacementReport
from footscan.workflow.opened_rig import OpenedRig


@pytest.fixture(scope="module")
def opened() -> Generator[OpenedRig]:
    """The simulated machine in fast time, with few pictures a second, so that few are painted."""
    rig = builtin_rig()
    assert rig.devices.world is not None
    world = rig.devices.world.model_copy(update={"time": "fast"})
    devices = rig.devices.model_copy(update={"world": world})
    motion = rig.motion.model_copy(update={"frames_per_s": 8.0})
    opened = app.open_rig(replace(rig, devices=devices, motion=motion), "left")
    yield opened
    opened.give_back()


@pytest.fixture(scope="module")
def session(opened: OpenedRig) -> Generator[Session]:
    session = app.start_session(opened, None)
    yield session
    session.close()


def _armed(session: Session) -> None:
    session.post_arm(no_faces_at_beam_height=True).wait()


@pytest.fixture(scope="module")
def recorded(opened: OpenedRig, session: Session, tmp_path_factory: pytest.TempPathFactory) -> GuidedCalibration:
    """The bare footboard, a placement without a board, and a good one, which is passed."""
    assert opened.put_calibration_board is not None
    guided = GuidedCalibration(session, tmp_path_factory.mktemp("guided") / "recording", DEFAULT_BOARD, stops=12)
    opened.put_calibration_board(None)
    _armed(session)
    guided.begin("test")
    for act in (guided.record_empty, guided.record_placement):
        _armed(session)
        act()
    with pytest.raises(InputError, match="placement 1 shows no board to pass"):
        guided.record_pass()
    opened.put_calibration_board(guided.next_place)
    for act in (guided.record_placement, guided.record_pass):
        _armed(session)
        act()
    guided.finish()
    return guided


def test_a_placement_without_a_board_is_left_out_and_asked_for_again(recorded: GuidedCalibration):
    none, good = recorded.reports
    setups = {record.setup for record in open_recording(recorded.folder).frames}

    assert "does not count: the board was not found" in none.sentence()
    assert "there again" in none.sentence()
    assert (none.place, good.place, recorded.next_place) == (0, 0, 1)
    assert len(good.angles_rad) >= 3
    assert setups == {"empty", "2"}
    assert (recorded.passed, recorded.needs_pass) == ("2", False)
    assert recorded.expected_error_mm() == (None, "1 good placement so far, at least 4 are needed")


def test_the_recording_of_one_placement_aligns_and_rechecks_the_machine_it_is_of(
    recorded: GuidedCalibration, opened: OpenedRig
):
    truth = app.true_machine(opened.rig).calibration
    found = align_recording(recorded.folder)
    # where theta is 0 depends on the home switch and the disc's eccentricity, not on where the encoder was made
    here = replace(truth, encoder=replace(truth.encoder, zero_count=opened.rig.scanner.encoder.zero_count))

    assert found.advice() == []
    for sheet, true in zip(found.sheets, truth.lasers, strict=True):
        assert sheet.offset_mm == pytest.approx(true.offset_mm, abs=0.1)
    assert recheck_recording(recorded.folder, here).holds


def _with_refusal(
    recorded: GuidedCalibration, monkeypatch: pytest.MonkeyPatch, refusal: PoorFitError
) -> GuidedCalibration:
    """Six good placements, of which a calibration would say something."""
    reports = [PlacementReport(str(k + 1), 12, (0.1, 0.2, 0.3), 60, place=k) for k in range(6)]

    def refuse(*_: object) -> None:
        raise refusal

    monkeypatch.setattr(guided_calibration, "calibrate_recording", refuse)
    return replace(recorded, reports=reports, left_out=set(), passed="3")


def test_a_placement_that_a_refusal_asks_to_repeat_is_left_out_and_its_place_advised_again(
    recorded: GuidedCalibration, monkeypatch: pytest.MonkeyPatch
):
    guided = _with_refusal(recorded, monkeypatch, PoorFitError("the board was moved.", repeat="3"))
    expected = guided.expected_error_mm()

    assert expected == (None, "placement 3 is left out: the board was moved. 5 good placements left")
    assert (guided.left_out, guided.next_place, guided.passed) == ({"3"}, 2, None)
    assert guided.needs_pass


def test_more_placements_are_asked_for_only_where_they_can_help(
    recorded: GuidedCalibration, monkeypatch: pytest.MonkeyPatch
):
    more = _with_refusal(recorded, monkeypatch, PoorFitError("All parallel.", more=True))

    assert more.expected_error_mm() == (None, "not yet: All parallel.")
    with pytest.raises(PoorFitError, match="the lens was knocked"):
        _with_refusal(recorded, monkeypatch, PoorFitError("the lens was knocked")).expected_error_mm()
