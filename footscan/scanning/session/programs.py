"""What the head does, step by step: home, scan, hold a laser on. Each step is one round of the control thread."""

import contextlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from footscan.config import RecordingInfo, scanner_toml
from footscan.coordinates import LaserName
from footscan.devices.interlock import Purpose
from footscan.errors import FootscanError, HeadStalledError, InterlockError, StorageError
from footscan.scanning.recording import FrameSweep
from footscan.scanning.session.home_edge import find_edge
from footscan.scanning.session.machine import Machine, Program
from footscan.scanning.session.picker import RequestedAngles
from footscan.scanning.session.plan import REST_S, ScanPlan, SweepLeg
from footscan.scanning.session.session_file import COMPLETE, save_outcome
from footscan.scanning.session.states import State

COUNTDOWN_S = 3.0
BUTTON_S = 120.0
"""The confirmation that no face is at beam height does not hold longer."""
PRESS = "step on, stand still, and press the button on the machine: the scan begins"
_BEEP_S = 0.15
_WRITING_S = 60.0
HOLD_AT_MOST_S = 60.0
_LEAD_S = 0.03
"""Beams go off this long before a blocked sector: a round, the switching, and the encoder's delay."""


@dataclass(frozen=True)
class ScanOrder:
    """One scan as asked for: where its recording goes, of whom, and how.

    Attributes:
        folder: Of the recording.
        info: What is written about it.
        plan: Sweeps, lasers, speed.
        countdown_s: Between Start and the first beam.
        by_button: Start is a press of the button on the machine.
    """

    folder: Path
    info: RecordingInfo
    plan: ScanPlan
    countdown_s: float = COUNTDOWN_S
    by_button: bool = False


def home(machine: Machine) -> Program:
    """Find the home switch and park: from then on the counter reads what the calibration means."""
    machine.say(State.HOMING)
    carriage = machine.carriage
    carriage.lose_home()
    if not carriage.at_rest:
        yield from machine.come_to_rest()
    edge_counts = yield from find_edge(machine, _search_step(machine))
    carriage.set_home(home_count(machine), edge_counts)
    yield from machine.come_to_rest()
    yield from machine.go_to(machine.park_rad)
    machine.say(State.PARKED)


def home_count(machine: Machine) -> int:
    """What the counter reads where the home switch opens: by the machine's design."""
    drive = machine.carriage.drive
    turns = machine.motion.home_deg / 360.0
    return drive.zero_count + round(drive.direction * turns * drive.steps_per_rev)


def _search_step(machine: Machine) -> int:
    """The fastest speed from which the head stops between home switch and end stop."""
    motion = machine.motion
    room_deg = motion.home_deg - motion.travel_deg[0]
    fits = [step for step, speed in enumerate(motion.speeds_deg_per_s) if motion.stopping_deg(speed) <= room_deg]
    return max(fits, default=0)


def scan(machine: Machine, order: ScanOrder) -> Program:
    """A whole scan: countdown, the sweeps, the way back; whatever ends it, what was captured is kept."""
    plan, keeper = order.plan, machine.keeper
    outcome = "cancelled"
    _refuse_unready(machine)
    machine.say(State.RETURNING)
    yield from machine.until(lambda: keeper.finished, _WRITING_S, _still_writing)
    yield from machine.go_to(machine.park_rad)
    if order.by_button:
        yield from _await_button(machine)
    yield from _countdown(machine, order.countdown_s)
    requested = RequestedAngles(plan.asked_step_rad, plan.sweep_rad) if plan.at_requested_angles else None
    keeper.begin(
        order.folder, order.info, scanner_toml(machine.scanner), machine.timing, plan.unlit_every > 1, requested
    )
    if machine.live is not None:
        machine.live.clear()
    try:
        begun_s = machine.clock.now_s()
        for leg in plan.legs:
            machine.say(State.SCANNING)
            yield from _leg(machine, plan, leg, begun_s)
        outcome = COMPLETE
    except FootscanError as err:
        outcome = f"broken off: {err}"
        raise
    finally:
        machine.take_for(None)
        keeper.end()
        with contextlib.suppress(StorageError):  # a full disk has been told already; the frames matter more
            save_outcome(order.folder, outcome, plan)
    yield from machine.until(lambda: keeper.finished, _WRITING_S, lambda: _not_written(order.folder))
    save_outcome(order.folder, outcome, plan, keeper.count())
    machine.say(State.RETURNING)
    yield from machine.go_to(machine.park_rad)
    machine.interlock.disarm()  # the next person's face is looked for anew
    machine.progress, machine.remaining_s = 1.0, 0.0
    machine.say(State.DONE)


def _refuse_unready(machine: Machine) -> None:
    if not machine.carriage.homed:
        raise InterlockError("the head has not found its home yet; home it before the scan.")
    if not machine.interlock.armed:
        raise InterlockError("lasers and motor are off until the machine is armed; confirm and arm it first.")


def _still_writing() -> FootscanError:
    return StorageError(f"the recording before this one is still not written after {_WRITING_S:g} s; check the disk.")


def _not_written(folder: Path) -> FootscanError:
    return StorageError(f"the last frames of {folder} are still not written after {_WRITING_S:g} s; check the disk.")


def _await_button(machine: Machine) -> Program:
    """Lasers and motor are off meanwhile; whoever stands at the machine decides when it begins."""
    machine.say(State.PARKED, PRESS)
    machine.awaits_button = True
    try:
        yield from machine.until(lambda: not machine.awaits_button, BUTTON_S, _nobody_pressed)
    finally:
        machine.awaits_button = False


def _nobody_pressed() -> FootscanError:
    return InterlockError(f"nobody pressed the button on the machine within {BUTTON_S:g} s; start again.")


def _countdown(machine: Machine, seconds: float) -> Program:
    machine.say(State.COUNTDOWN)
    ends_s = machine.clock.now_s() + seconds
    while machine.clock.now_s() < ends_s:
        left_s = ends_s - machine.clock.now_s()
        machine.remaining_s = left_s
        beeping = (left_s % 1.0) > 1.0 - _BEEP_S
        if beeping != machine.interlock.outputs.buzzer:
            machine.sound(beeping)
        yield
    if machine.interlock.outputs.buzzer:
        machine.sound(False)


def _leg(machine: Machine, plan: ScanPlan, leg: SweepLeg, begun_s: float) -> Program:
    sign = 1.0 if leg.ccw else -1.0
    low, high = plan.sweep_rad
    ends_rad = high if leg.ccw else low
    sweep: FrameSweep = "ccw" if leg.ccw else "cw"
    carriage = machine.carriage
    carriage.turn(leg.ccw, plan.speed_step)
    light = _LightInTurn(machine, plan, leg)
    machine.take_for(sweep)
    gives_up_s = machine.clock.now_s() + 1.5 * np.ptp(plan.sweep_rad) / plan.speed_rad_s + 3.0
    while sign * (ends_rad - carriage.theta_rad) > 0.0:
        light.step()
        _tell_progress(machine, plan, begun_s)
        if machine.clock.now_s() > gives_up_s:
            raise HeadStalledError("the head did not finish its turn in time; check motor and belt.")
        yield
    light.note_blocked(False)
    yield from machine.come_to_rest()
    yield from machine.pause(0.3 * REST_S)


def _tell_progress(machine: Machine, plan: ScanPlan, begun_s: float) -> None:
    since_s = machine.clock.now_s() - begun_s
    machine.remaining_s = max(plan.duration_s - since_s, 0.0)
    machine.progress = min(since_s / plan.duration_s, 1.0)


class _LightInTurn:
    """Which laser shines for the next frame: one, or several in turn, sometimes none, never in a blocked sector.

    Lasers are switched between two exposures, whose moments follow from the last frame's stamp and the latency.
    """

    def __init__(self, machine: Machine, plan: ScanPlan, leg: SweepLeg) -> None:
        self._machine = machine
        self._blocked_rad = plan.blocked_rad
        self._cycle = _cycle(leg.lasers, plan.unlit_every)
        self._turn = 0
        self._due_s = 0.0
        self._blocked = False

    def step(self) -> None:
        """Once per round of the control thread."""
        carriage = self._machine.carriage
        ahead_rad = carriage.theta_rad + carriage.speed_rad_s * _LEAD_S
        self.note_blocked(self._is_blocked(carriage.theta_rad) or self._is_blocked(ahead_rad))
        now_s = self._machine.clock.now_s()
        if self._blocked:
            self._shine(())
        elif len(self._cycle) == 1:
            self._shine(self._cycle[0])
        else:
            self._take_turns(now_s)

    def _is_blocked(self, theta_rad: float) -> bool:
        """Sectors are places around the machine: 361 degrees is where 1 degree is."""
        return any((theta_rad - first) % (2.0 * np.pi) <= last - first for first, last in self._blocked_rad)

    def note_blocked(self, blocked: bool) -> None:
        """Beams stay off here, and frames are named so."""
        if blocked != self._blocked:
            self._blocked = blocked
            self._machine.log.blocked.note(self._machine.clock.now_s(), blocked)

    def _take_turns(self, now_s: float) -> None:
        if now_s >= self._due_s:
            self._shine(self._cycle[self._turn % len(self._cycle)])
            self._turn += 1
            self._due_s = self._machine.gap_after(now_s)
        self._machine.wake_s = self._due_s

    def _shine(self, lasers: tuple[LaserName, ...]) -> None:
        if lasers != self._machine.interlock.outputs.lasers:
            self._machine.shine(lasers)


def _cycle(lasers: tuple[LaserName, ...], unlit_every: int) -> list[tuple[LaserName, ...]]:
    """The light of successive frames, until it repeats."""
    cycle: list[tuple[LaserName, ...]] = []
    lit = len(lasers) * max(unlit_every - 1, 1)
    for number in range(lit):
        if unlit_every > 1 and number % (unlit_every - 1) == 0:
            cycle.append(())
        cycle.append((lasers[number % len(lasers)],))
    return cycle


def hold(machine: Machine, lasers: tuple[LaserName, ...]) -> Program:
    """Lasers on at rest; the interlock ends it a second after the last request, this never renews it."""
    machine.say(State.HOLDING)
    ends_s = machine.clock.now_s() + HOLD_AT_MOST_S
    try:
        machine.shine(lasers, Purpose.HELD)
        while machine.clock.now_s() < ends_s:
            yield
    finally:
        machine.quiet()
    machine.say(State.PARKED if machine.carriage.homed else State.CONNECTED)
