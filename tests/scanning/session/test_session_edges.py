"""What happens at the edges of a scan: wrong order of commands, odd places of the head, answers that get lost."""

import json
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from footscan import app
from footscan.errors import EncoderLostError, FootscanError, InterlockError, OutputsLostError
from footscan.scanning.recording import open_recording
from footscan.scanning.session.assembly import SessionSetup
from footscan.scanning.session.checkup import CheckOrder, check_before_scan
from footscan.scanning.session.control import Session
from footscan.scanning.session.keeper import Keeper
from footscan.scanning.session.machine import Machine
from footscan.scanning.session.programs import home
from footscan.scanning.session.session_file import load_outcome
from footscan.scanning.session.states import FrameCount, State
from footscan.sim.standing import Standing
from footscan.workflow.designs import builtin_rig
from footscan.workflow.scan import find_scans
from tests.scanning.session.conftest import Bench, small_rig


def named(frames: FrameCount) -> int:
    return frames.kept + sum(frames.rejected.values())


def switch_on_at(bench: Bench, theta_deg: float) -> None:
    """The head was left at this angle when the machine was switched on."""
    world = bench.world
    with world._lock:
        world.catch_up()
        shift_rad = float(np.deg2rad(theta_deg)) - world._head.theta_rad
        world._head._theta_rad = world._head._theta_rad + shift_rad
        world._first_count += round(shift_rad * 8000 / (2.0 * np.pi))


def scan_until(bench: Bench, kept: int) -> None:
    bench.start_scan()
    bench.wait_until(lambda: bench.session.snapshot().frames.kept > kept)


@pytest.mark.parametrize("theta_deg", [-24.5, -9.5, 200.0, 384.0])
def test_homing_from_anywhere_stays_between_the_end_stops(open_bench: Callable[..., Bench], theta_deg: float) -> None:
    tight = {"travel_deg": (-25.0, 385.0), "home_deg": -20.0, "speeds_deg_per_s": (18.75, 37.5, 60.0)}
    bench = open_bench(small_rig(**tight, acceleration_deg_per_s2=200.0))
    switch_on_at(bench, theta_deg)
    bench.ready()
    shown_deg, head = bench.session.snapshot().theta_deg, bench.world._head

    assert shown_deg == pytest.approx(np.rad2deg(head.theta_rad), abs=0.5)
    assert np.rad2deg(head._theta_rad.min()) > -25.0


def test_a_scan_before_homing_or_arming_is_refused_and_leaves_no_recording(bench: Bench) -> None:
    bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    with pytest.raises(InterlockError, match="home it"):
        bench.start_scan().wait(30)
    bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    bench.session.post(home).wait(60)
    bench.session.post(lambda machine: machine.interlock.disarm()).wait(30)
    with pytest.raises(InterlockError, match="arm it"):
        bench.start_scan().wait(30)

    assert not any(bench.folder.iterdir())


def test_stop_does_not_clear_a_fault(bench: Bench) -> None:
    bench.ready()
    scan_until(bench, 5)
    bench.world.inject("stall")
    bench.wait_until(lambda: bench.session.snapshot().state is State.FAULT)
    bench.session.post_cancel().wait(30)

    assert bench.session.snapshot().state is State.FAULT
    assert "the motor is on" in bench.session.snapshot().message


def test_a_reset_does_not_touch_a_running_scan(bench: Bench) -> None:
    bench.ready()
    scan_until(bench, 5)
    with pytest.raises(InterlockError, match="no fault"):
        bench.session.post_reset().wait(30)

    assert bench.session.snapshot().state is State.SCANNING


def test_after_a_reset_a_head_that_stands_elsewhere_is_not_called_parked(bench: Bench) -> None:
    bench.ready()
    scan_until(bench, 40)
    bench.world.inject("camera-frozen")
    bench.wait_until(lambda: bench.session.snapshot().state is State.FAULT)
    bench.world.mend("camera-frozen")
    bench.session.post_reset().wait(30)

    assert bench.session.snapshot().state is State.STOPPED
    assert "parks the head first" in bench.session.snapshot().message


def test_while_the_head_returns_to_its_place_it_says_so_and_the_button_stops_it(bench: Bench, tmp_path: Path) -> None:
    bench.ready()
    scan_until(bench, 60)
    bench.session.post_cancel().wait(30)
    bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    bench.folder = tmp_path / "second"
    ticket = bench.start_scan()
    bench.wait_until(lambda: bench.session.snapshot().motor_on)
    state = bench.session.snapshot().state
    bench.world.press_button(True)
    with pytest.raises(InterlockError, match="button"):
        ticket.wait(30)

    assert state is State.RETURNING
    assert bench.world.off_since_s is not None


def test_cancel_silences_the_buzzer(bench: Bench) -> None:
    bench.ready()
    beeped: list[bool] = []

    def cancel_at_first_beep(machine: Machine) -> None:
        sound = machine.sound

        def heard(on: bool) -> None:
            sound(on)
            beeped.append(bench.world.outputs().buzzer)
            bench.session.post_cancel()

        machine.sound = heard  # type: ignore[method-assign]

    bench.session.post(cancel_at_first_beep).wait(30)
    with pytest.raises(InterlockError, match="stopped"):
        bench.start_scan(countdown_s=2.0).wait(30)

    assert beeped == [True]
    assert not bench.world.module._outputs.buzzer


def test_cancel_after_a_lost_answer_of_the_module_is_a_fault_with_everything_off(bench: Bench) -> None:
    bench.ready()
    ticket = bench.start_scan()
    bench.wait_until(lambda: bench.session.snapshot().frames.kept > 5)
    io = bench.opened.devices.io
    heard = io.set_outputs

    def lose_one(outputs: object) -> None:
        io.set_outputs = heard  # type: ignore[method-assign]
        raise OutputsLostError("one answer of the module was lost.")

    io.set_outputs = lose_one  # type: ignore[method-assign]
    began_s = bench.session.clock.now_s()
    with pytest.raises(OutputsLostError):
        bench.session.post_cancel().wait(30)
    with pytest.raises(FootscanError):
        ticket.wait(30)
    off_s = bench.world.off_since_s

    assert off_s is not None
    assert off_s - began_s < 0.3
    assert bench.session.snapshot().state is State.FAULT


def test_a_command_that_breaks_ends_the_machine_and_tells_who_asked(bench: Bench) -> None:
    def broken(machine: Machine) -> None:
        raise ValueError("a mistake in the program")

    with pytest.raises(FootscanError, match=r"ended unexpectedly \(ValueError\)"):
        bench.session.post(broken).wait(30)
    with pytest.raises(FootscanError, match="closed"):
        bench.session.post(home).wait(30)


def test_a_command_is_over_only_when_its_outcome_can_be_seen(bench: Bench) -> None:
    bench.ready()
    seen: list[State] = []
    settle = threading.Event.set
    ticket = bench.start_scan()
    ticket._done.set = lambda: (seen.append(bench.session.snapshot().state), settle(ticket._done))  # type: ignore[method-assign]
    ticket.wait(120)

    assert seen == [State.DONE]


def test_a_session_that_was_never_started_can_be_closed() -> None:
    rig = small_rig()
    session = Session(app.open_rig(rig).devices, SessionSetup(rig.scanner, rig.motion, None, None))
    closing = threading.Thread(target=session.close, daemon=True)
    closing.start()
    closing.join(10.0)

    assert not closing.is_alive()
    assert session.snapshot().state is State.CLOSED


def test_requested_angles_and_a_silent_encoder_lose_no_frame_without_a_name(bench: Bench) -> None:
    bench.ready()
    plan = replace(bench.plan, at_requested_angles=True, asked_step_rad=float(np.deg2rad(8.0)))
    ticket = bench.start_scan(plan)
    bench.wait_until(lambda: bench.session.snapshot().frames.kept > 5)
    bench.world.inject("encoder-silent")
    with pytest.raises(EncoderLostError, match="silent"):
        ticket.wait(60)
    bench.wait_until((bench.folder / "manifest.sha256").is_file)
    bench.wait_until(lambda: bench.session.settled)
    frames = bench.session.snapshot().frames

    assert bench.session._machine.keeper.thread.failure is None
    assert "angle unknown" in frames.rejected
    assert frames.captured == named(frames)


def test_a_blocked_sector_is_a_place_and_not_an_angle_counted_from_the_start(open_bench: Callable[..., Bench]) -> None:
    bench = open_bench(small_rig(blocked_deg=((0.0, 5.0), (170.0, 190.0))))
    bench.ready()
    ticket = bench.start_scan()
    shone: list[float] = []
    while not ticket.done:
        now_s = bench.session.clock.now_s()
        if bench.world.lasers_at(now_s):
            shone.append(float(np.rad2deg(bench.world.theta_at(np.array([now_s]))[0])))
    ticket.wait(60)

    assert max(shone) > 365.0
    assert not any(0.1 < angle % 360.0 < 4.9 or 170.1 < angle < 189.9 for angle in shone)


def test_a_scan_waits_until_the_one_before_is_written(bench: Bench, tmp_path: Path) -> None:
    bench.ready()
    keeper = bench.session._machine.keeper
    keep = keeper._keep

    def slow(*frame: object) -> None:
        bench.session.clock.wait(bench.session.clock.now_s() + 0.08)
        keep(*frame)  # type: ignore[arg-type]

    keeper._keep = slow  # type: ignore[method-assign]
    bench.start_scan()
    bench.wait_until(lambda: bench.session.snapshot().frames.captured > 60)
    bench.session.post_cancel().wait(30)
    bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    first, bench.folder = bench.folder, tmp_path / "second"
    bench.start_scan().wait(120)
    frames = bench.session.snapshot().frames
    times_first = [record.time_s for record in open_recording(first).frames]
    times_second = [record.time_s for record in open_recording(bench.folder).frames]

    assert frames.captured == named(frames)
    assert len(times_second) == frames.kept
    assert len(times_first) > 50
    assert max(times_first) < min(times_second)


def test_no_frame_comes_behind_the_end_of_its_recording(bench: Bench) -> None:
    """The grab thread is held up between counting a frame and queueing it, while the recording is ended."""
    keeper: Keeper = bench.session._machine.keeper
    offer, order = keeper.thread.offer, []

    def late(item: object, however_full: bool = False) -> bool:
        if item is not None:
            time.sleep(0.05)
        order.append(item is None)
        return offer(item, however_full)  # type: ignore[arg-type]

    keeper._accepting = True
    keeper.thread.offer = late  # type: ignore[method-assign]
    frame = bench.session.grabber.latest
    bench.wait_until(lambda: bench.session.grabber.latest is not None)
    frame = bench.session.grabber.latest
    assert frame is not None
    grabbing = threading.Thread(target=keeper.offer, args=(frame,))
    grabbing.start()
    bench.wait_until(lambda: keeper.count().captured > 0 or keeper._lock.locked())
    keeper.end()
    grabbing.join()

    assert order[-1]
    assert order.count(True) == 1


def test_a_cancelled_scan_is_listed_as_broken_off(bench: Bench, tmp_path: Path) -> None:
    bench.ready()
    bench.folder = tmp_path / "scans/one/recording"
    scan_until(bench, 20)
    bench.session.post_cancel().wait(30)
    bench.wait_until((bench.folder / "manifest.sha256").is_file)
    (stored,) = find_scans(tmp_path / "scans")

    assert not stored.finished
    assert not stored.processed
    assert stored.frames > 20
    outcome = load_outcome(bench.folder)
    assert outcome is not None
    assert outcome == json.loads((bench.folder / "session.json").read_text())["outcome"]


def test_a_calibration_for_another_camera_is_named(open_bench: Callable[..., Bench]) -> None:
    bench = open_bench(calibration=app.true_machine(builtin_rig()).calibration)
    bench.ready()
    order = CheckOrder(bench.folder, bench.plan, bench.session.setup.tables)
    bench.session.post(lambda machine: check_before_scan(machine, order)).wait(60)

    assert "camera size" in [finding.cause for finding in bench.session.snapshot().findings]


@pytest.mark.parametrize(("aside_mm", "side"), [(60.0, "right"), (-60.0, "left"), (0.0, None)])
def test_a_foot_beside_the_middle_is_said(bench: Bench, aside_mm: float, side: str | None) -> None:
    bench.ready()
    moved = np.eye(4)
    moved[1, 3] = aside_mm
    bench.world.put(Standing(bench.world.standing.body.moved(moved), bench.world.machine))
    order = CheckOrder(bench.folder, bench.plan, bench.session.setup.tables)
    bench.session.post(lambda machine: check_before_scan(machine, order)).wait(60)
    said = [finding.sentence for finding in bench.session.snapshot().findings if finding.cause == "foot off centre"]

    assert len(said) == (side is not None)
    assert all(f"to the {side}" in sentence for sentence in said)


def test_a_motor_that_runs_on_after_stop_is_a_fault_and_not_called_off(bench: Bench) -> None:
    bench.ready()
    scan_until(bench, 5)
    speed_rad_s = float(np.deg2rad(30.0))
    bench.world._asked_rad_s = lambda time_s: speed_rad_s  # type: ignore[method-assign]  # a welded relay
    bench.session.post_cancel().wait(30)
    bench.wait_until(lambda: bench.session.snapshot().state is State.FAULT)

    assert "main switch" in bench.session.snapshot().message
