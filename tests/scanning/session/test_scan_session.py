import itertools
import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from footscan import app
from footscan.config.recording_file import RecordingInfo
from footscan.errors import (
    DeviceError,
    EmergencyStopError,
    EncoderLostError,
    HeadStalledError,
    InterlockError,
    OutputsLostError,
    StoppedError,
)
from footscan.scanning.recording import open_recording
from footscan.scanning.session.plan import plan_scan
from footscan.scanning.session.programs import PRESS, ScanOrder, hold, home, scan
from footscan.scanning.session.states import State
from footscan.workflow.process import ProcessSettings, process_recording
from footscan.workflow.truth import distance_to_surface_mm
from tests.scanning.session.conftest import Bench, opened_bench, small_rig


@pytest.fixture(scope="module")
def scanned(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    """After a whole scan; only looked at."""
    bench = opened_bench(tmp_path_factory.mktemp("scanned"))
    bench.ready()
    bench.start_scan().wait(120)
    yield bench
    bench.session.close()


def test_a_whole_scan_is_recorded_and_every_captured_frame_has_a_name(scanned: Bench) -> None:
    bench = scanned
    snapshot = bench.session.snapshot()
    frames = snapshot.frames
    recording = open_recording(bench.folder)

    assert snapshot.state is State.DONE
    assert frames.captured == frames.kept + sum(frames.rejected.values())
    assert frames.lost == 0
    assert set(frames.rejected) <= {"between the sweeps", "sweep begins or ends", "laser switching"}
    assert len(recording.frames) == frames.kept >= 2 * 90
    assert {(record.sweep, record.laser) for record in recording.frames} == {("ccw", "right"), ("cw", "left")}


def test_the_recording_of_a_session_becomes_the_foot_that_stood_there(scanned: Bench) -> None:
    bench = scanned
    calibration = bench.session.setup.calibration
    assert calibration is not None
    cloud = process_recording(open_recording(bench.folder), calibration, ProcessSettings()).cloud
    body = bench.world.standing.body
    off_mm = distance_to_surface_mm(cloud.xyz_world, body.xyz_world, body.faces)

    assert np.sqrt(np.mean(off_mm**2)) < 0.35  # a pixel of this small camera is 2.6 mm wide


def test_nothing_moves_or_shines_unless_somebody_armed_it(bench: Bench) -> None:
    with pytest.raises(InterlockError, match="armed"):
        bench.session.post(home).wait(30)
    with pytest.raises(InterlockError, match="face"):
        bench.session.post_arm(no_faces_at_beam_height=False).wait(30)

    assert bench.world.off_since_s == bench.world.start_s


def test_after_a_scan_the_machine_must_be_armed_anew(scanned: Bench) -> None:
    assert not scanned.session.snapshot().armed
    assert scanned.world.off_since_s is not None


def test_cancel_switches_off_and_keeps_what_is_there(bench: Bench) -> None:
    bench.ready()
    ticket = bench.start_scan()
    bench.wait_until(lambda: bench.session.snapshot().frames.kept > 20)
    bench.session.post_cancel().wait(30)
    with pytest.raises(StoppedError, match="stopped by the operator"):
        ticket.wait(30)
    bench.wait_until((bench.folder / "manifest.sha256").is_file)
    snapshot = bench.session.snapshot()

    assert snapshot.state is State.STOPPED
    assert bench.world.off_since_s is not None
    assert len(open_recording(bench.folder).frames) == bench.session.snapshot().frames.kept > 20
    assert json.loads((bench.folder / "session.json").read_text())["outcome"].startswith("broken off: stopped by")


def test_a_stopped_machine_scans_again_after_arming(bench: Bench, tmp_path: Path) -> None:
    bench.ready()
    bench.start_scan()
    bench.wait_until(lambda: bench.session.snapshot().frames.kept > 5)
    bench.session.post_cancel().wait(30)
    bench.wait_until((bench.folder / "manifest.sha256").is_file)
    bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    bench.folder = tmp_path / "second"
    bench.start_scan().wait(120)

    assert bench.session.snapshot().state is State.DONE
    assert len(open_recording(bench.folder).frames) > 150


def test_the_button_on_the_machine_stops_a_scan(bench: Bench) -> None:
    bench.ready()
    ticket = bench.start_scan()
    bench.wait_until(lambda: bench.session.snapshot().frames.kept > 5)
    bench.world.press_button(True)
    with pytest.raises(InterlockError, match="button on the machine"):
        ticket.wait(30)

    assert bench.session.snapshot().state is State.STOPPED


def test_the_button_on_the_machine_starts_a_scan_that_waits_for_it_and_stops_it_later(bench: Bench) -> None:
    bench.ready()
    bench.folder.mkdir()
    order = ScanOrder(bench.folder, RecordingInfo("scan", "left", "2026-01-01T00:00:00+00:00"), bench.plan, 0.2, True)
    ticket = bench.session.post(lambda machine: scan(machine, order))
    bench.wait_until(lambda: bench.session.snapshot().message == PRESS)
    waiting = bench.session.snapshot()
    bench.world.press_button(True)
    bench.wait_until(lambda: bench.session.snapshot().state is State.SCANNING)
    bench.world.press_button(False)
    bench.wait_until(lambda: bench.session.snapshot().frames.kept > 5)
    bench.world.press_button(True)

    with pytest.raises(InterlockError, match="stopped by the button on the machine"):
        ticket.wait(60)
    assert waiting.lasers == ()
    assert not waiting.motor_on


def test_a_scan_for_which_nobody_presses_the_button_is_not_made(bench: Bench) -> None:
    bench.ready()
    bench.folder.mkdir()
    order = ScanOrder(bench.folder, RecordingInfo("scan", "left", "2026-01-01T00:00:00+00:00"), bench.plan, 0.2, True)

    with pytest.raises(InterlockError, match="nobody pressed the button on the machine within 120 s"):
        bench.session.post(lambda machine: scan(machine, order)).wait(120)
    assert not any(bench.folder.iterdir())


def test_two_starts_at_once_are_one_scan(bench: Bench) -> None:
    bench.ready()
    first, second = bench.start_scan(), bench.start_scan()
    with pytest.raises(InterlockError, match="busy"):
        second.wait(30)
    first.wait(120)

    assert bench.session.snapshot().state is State.DONE


def test_when_nobody_watches_any_more_the_scan_stops(bench: Bench) -> None:
    bench.ready()
    bench.session.watch(2.0)
    with pytest.raises(InterlockError, match="nobody watches"):
        bench.start_scan().wait(60)

    assert bench.world.off_since_s is not None


@pytest.mark.parametrize(
    ("trouble", "error", "words"),
    [
        ("camera-frozen", DeviceError, "no frame came from the camera"),
        ("encoder-silent", EncoderLostError, "has been silent"),
        ("encoder-jump", EncoderLostError, "jumped by"),
        ("stall", HeadStalledError, "the motor is on but the head turned"),
        ("estop", EmergencyStopError, "emergency stop is open"),
        ("io-silent", OutputsLostError, "does not answer"),
        ("io-reset", OutputsLostError, "power was lost"),
    ],
)
def test_trouble_in_a_scan_switches_everything_off_within_0_3_s(
    bench: Bench, trouble: str, error: type[DeviceError], words: str
) -> None:
    bench.ready()
    ticket = bench.start_scan()
    bench.wait_until(lambda: bench.session.snapshot().frames.kept > 20)
    at_s = bench.session.clock.now_s() + 0.2
    bench.world.inject(trouble, at_s)  # type: ignore[arg-type]
    with pytest.raises(error, match=words):
        ticket.wait(60)
    bench.wait_until(lambda: bench.session.snapshot().state is State.FAULT)
    bench.wait_until(lambda: (bench.folder / "manifest.sha256").is_file() and bench.world.off_since_s is not None)
    off_s, frames = bench.world.off_since_s, bench.session.snapshot().frames

    assert off_s is not None
    assert off_s - at_s < 0.3
    assert words in bench.session.snapshot().message
    assert frames.captured == frames.kept + sum(frames.rejected.values())
    assert len(open_recording(bench.folder).frames) == frames.kept > 20


def test_after_a_fault_is_mended_and_reset_the_machine_works_again(bench: Bench, tmp_path: Path) -> None:
    bench.ready()
    ticket = bench.start_scan()
    bench.wait_until(lambda: bench.session.snapshot().frames.kept > 5)
    bench.world.inject("camera-frozen")
    with pytest.raises(DeviceError):
        ticket.wait(60)
    with pytest.raises(InterlockError, match="fault"):
        bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    bench.world.mend("camera-frozen")
    bench.session.post_reset().wait(30)
    bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    bench.folder = tmp_path / "second"
    bench.start_scan().wait(120)

    assert bench.session.snapshot().state is State.DONE


def test_an_open_emergency_stop_cannot_be_reset_on_the_screen(bench: Bench) -> None:
    bench.ready()
    bench.world.inject("estop")
    bench.wait_until(lambda: bench.session.snapshot().state is State.FAULT)
    with pytest.raises(EmergencyStopError, match="is open"):
        bench.session.post_reset().wait(30)
    bench.world.mend("estop")
    bench.session.post_reset().wait(30)

    assert bench.session.snapshot().state is State.PARKED
    assert not bench.session.snapshot().armed


def test_a_motor_wired_the_wrong_way_is_named(bench: Bench) -> None:
    bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    bench.world.inject("wrong-way")
    with pytest.raises(EncoderLostError, match="swap the motor's wires"):
        bench.session.post(home).wait(60)


def test_a_held_laser_goes_off_when_the_hand_is_taken_away(bench: Bench) -> None:
    bench.ready()
    ticket = bench.session.post(lambda machine: hold(machine, ("right",)))
    bench.wait_until(lambda: bench.world.lasers_at(bench.session.clock.now_s()) == ("right",))
    began_s = bench.session.clock.now_s()
    with pytest.raises(InterlockError, match="shone on the same place"):
        ticket.wait(60)

    assert bench.world.off_since_s is not None
    assert bench.world.off_since_s - began_s < 1.5


def test_an_alternating_scan_has_both_lasers_in_one_turn_and_no_frame_of_two(open_bench: Callable[..., Bench]) -> None:
    rig = small_rig(frames_per_s=50.0)
    bench = open_bench(rig)
    profile = rig.motion.profile[0].model_copy(update={"lasers": "alternating"})
    plan = plan_scan(rig.motion, profile, bench.session.facts, rig.scanner)
    bench.ready()
    bench.start_scan(plan).wait(120)
    frames = bench.session.snapshot().frames
    lasers = [record.laser for record in open_recording(bench.folder).frames]

    assert plan.alternating
    assert frames.captured == frames.kept + sum(frames.rejected.values())
    assert sum(one != two for one, two in itertools.pairwise(lasers)) > 0.9 * len(lasers)
    assert frames.rejected.get("laser switching", 0) <= 0.05 * frames.captured


def test_each_laser_named_in_a_frame_is_the_one_that_shone(open_bench: Callable[..., Bench]) -> None:
    rig = small_rig(frames_per_s=50.0)
    bench = open_bench(rig)
    profile = rig.motion.profile[0].model_copy(update={"lasers": "alternating", "unlit_every": 5})
    bench.ready()
    bench.start_scan(plan_scan(rig.motion, profile, bench.session.facts, rig.scanner)).wait(120)
    calibration = bench.session.setup.calibration
    assert calibration is not None
    records = open_recording(bench.folder).frames
    true = [bench.world.lasers_at(record.time_s - calibration.latency_s) for record in records]

    assert [shone or ("none",) for shone in true] == [(record.laser,) for record in records]
    assert {record.laser for record in records} == {"right", "left", "none"}


def test_in_a_blocked_sector_beams_stay_off(open_bench: Callable[..., Bench]) -> None:
    bench = open_bench(small_rig(blocked_deg=((100.0, 140.0),)))
    bench.ready()
    ticket = bench.start_scan()
    shone: list[float] = []
    while not ticket.done:
        now_s = bench.session.clock.now_s()
        if bench.world.lasers_at(now_s):
            shone.append(float(np.rad2deg(bench.world.theta_at(np.array([now_s]))[0])))
    ticket.wait(60)

    assert len(shone) > 50
    assert not any(103.0 < angle < 137.0 for angle in shone)
    assert bench.session.snapshot().frames.rejected["blocked sector"] > 10


def test_pictures_at_requested_angles_are_the_nearest_ones(open_bench: Callable[..., Bench]) -> None:
    rig = small_rig()
    bench = open_bench(rig)
    plan = replace(bench.plan, at_requested_angles=True, asked_step_rad=float(np.deg2rad(15.0)))
    bench.ready()
    bench.start_scan(plan).wait(120)
    frames = bench.session.snapshot().frames
    calibration = bench.session.setup.calibration
    assert calibration is not None
    recording = open_recording(bench.folder)
    ccw = [record for record in recording.frames if record.sweep == "ccw"]
    exposed_s = np.array([record.time_s for record in ccw]) - calibration.latency_s
    theta_deg = np.rad2deg(np.interp(exposed_s, recording.encoder.time_s, recording.encoder.count)) * (
        2 * np.pi / calibration.encoder.steps_per_rev
    )

    assert np.round(theta_deg / 15.0).tolist() == list(range(25))  # 0 to 360 degrees; the run-up asks for none
    assert np.abs(theta_deg - 15.0 * np.round(theta_deg / 15.0)).max() < 0.6 * np.rad2deg(bench.plan.angle_step_rad)
    assert frames.captured == frames.kept + sum(frames.rejected.values())


def test_no_calibration_means_no_live_view_but_a_named_finding(open_bench: Callable[..., Bench]) -> None:
    from footscan.scanning.session.checkup import CheckOrder, check_before_scan

    bench = open_bench(calibrated=False)
    bench.ready()
    order = CheckOrder(bench.folder, bench.plan, None)
    bench.session.post(lambda machine: check_before_scan(machine, order)).wait(60)

    assert [finding.cause for finding in bench.session.snapshot().findings if finding.blocking] == [
        "calibration missing"
    ]


@pytest.mark.parametrize(
    ("trouble", "cause"),
    [
        ("right-laser-dead", "no stripe of the right laser"),
        ("left-laser-dead", "no stripe of the left laser"),
        ("wrong-way", "motor turns the wrong way"),
        ("stall", "head blocked"),
    ],
)
def test_the_check_before_a_scan_names_the_cause(bench: Bench, trouble: str, cause: str) -> None:
    from footscan.scanning.session.checkup import CheckOrder, check_before_scan

    bench.ready()
    bench.world.inject(trouble)  # type: ignore[arg-type]
    order = CheckOrder(bench.folder, bench.plan, bench.session.setup.tables)
    bench.session.post(lambda machine: check_before_scan(machine, order)).wait(60)

    assert cause in [finding.cause for finding in bench.session.snapshot().findings]


def test_a_sound_machine_passes_the_check(bench: Bench) -> None:
    from footscan.scanning.session.checkup import CheckOrder, check_before_scan

    bench.ready()
    order = CheckOrder(bench.folder, bench.plan, bench.session.setup.tables)
    bench.session.post(lambda machine: check_before_scan(machine, order)).wait(60)

    assert [finding for finding in bench.session.snapshot().findings if finding.blocking] == []
    assert bench.session.snapshot().state is State.PARKED


def test_a_slow_live_view_loses_no_frame_of_the_recording(open_bench: Callable[..., Bench]) -> None:
    bench = open_bench()
    live = bench.session.live
    assert live is not None
    quick = live.thread._work

    def slow(item: object) -> None:
        bench.session.clock.wait(bench.session.clock.now_s() + 0.1)  # 10 a second at 25 frames a second
        quick(item)  # type: ignore[arg-type]

    live.thread._work = slow  # type: ignore[assignment]
    bench.ready()
    bench.start_scan().wait(120)
    frames = bench.session.snapshot().frames
    bench.wait_until(lambda: live.thread.idle)
    shown = live.count()

    assert frames.lost == 0
    assert frames.captured == frames.kept + sum(frames.rejected.values())
    assert shown.given == frames.kept == shown.shown + sum(shown.skipped.values())
    assert shown.skipped == {"live view behind": shown.given - shown.shown}
    assert shown.shown > 64


def test_a_recording_folder_is_never_overwritten(bench: Bench) -> None:
    bench.ready()
    bench.start_scan().wait(120)
    before = (bench.folder / "frames.csv").read_bytes()
    bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    with pytest.raises(Exception, match="already holds a recording"):
        bench.start_scan().wait(60)

    assert (bench.folder / "frames.csv").read_bytes() == before
    assert bench.world.off_since_s is not None


def test_closing_switches_everything_off_in_the_middle_of_a_scan(bench: Bench) -> None:
    bench.ready()
    bench.start_scan()
    bench.wait_until(lambda: bench.session.snapshot().frames.kept > 10)
    bench.session.close()

    assert bench.world.off_since_s is not None
    assert bench.session.snapshot().state is State.CLOSED
    assert len(open_recording(bench.folder).frames) == bench.session.snapshot().frames.kept


def test_the_info_of_a_scan_stays_with_it(scanned: Bench) -> None:
    bench = scanned
    info = open_recording(bench.folder).info

    assert info == RecordingInfo("scan", "left", "2026-01-01T00:00:00+00:00")
    assert app.true_machine(bench.opened.rig).calibration == bench.session.setup.calibration
