"""Frames for a calibration: the head at rest at stops, unlit and with each laser, and moving passes of the board."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from footscan.config import RecordingInfo, scanner_toml
from footscan.coordinates import LaserName
from footscan.devices.interlock import Purpose
from footscan.devices.values import CameraFrame
from footscan.errors import CameraLostError
from footscan.scanning.recording import FrameSweep
from footscan.scanning.session.machine import Machine, Program
from footscan.scanning.session.states import State

LIGHTS: tuple[tuple[LaserName, ...], ...] = ((), ("right",), ("left",))
_LATEST_S = 0.1
"""Frames are stamped at most this late: a light must have been on for so long before a frame is believed."""


@dataclass(frozen=True)
class StopsOrder:
    """A board placement (or `empty`) seen from many head angles."""

    setup: str
    angles_rad: tuple[float, ...]


@dataclass(frozen=True)
class PassOrder:
    """A board placement passed by the moving head, there and back, unlit: how late are frames stamped?"""

    setup: str
    low_rad: float
    high_rad: float


def begin_calibration(machine: Machine, folder: Path, info: RecordingInfo) -> None:
    """Open the recording; several programs add to it.

    Raises:
        RecordingError: The folder already holds one.
        StorageError: The place cannot be written.
    """
    machine.keeper.begin(folder, info, scanner_toml(machine.scanner), machine.timing, unlit_wanted=True)


def record_stops(machine: Machine, order: StopsOrder) -> Program:
    """Three frames at each stop; lasers and motor are off and disarmed at the end, however it ends."""
    machine.say(State.CALIBRATING)
    machine.log.setup.note(machine.clock.now_s(), order.setup)
    try:
        for done, angle in enumerate(order.angles_rad):
            yield from machine.go_to(angle)
            for lasers in LIGHTS:
                yield from _static_frame(machine, lasers)
            machine.quiet()
            machine.progress = (done + 1) / len(order.angles_rad)
        yield from machine.go_to(machine.park_rad)
    finally:
        machine.take_for(None)
        machine.interlock.disarm()
    machine.say(State.PARKED)


def record_pass(machine: Machine, order: PassOrder) -> Program:
    """The head turns past the board and back while frames are taken."""
    machine.say(State.CALIBRATING)
    machine.log.setup.note(machine.clock.now_s(), order.setup)
    try:
        yield from machine.go_to(order.low_rad)
        yield from _pass(machine, order.high_rad, "ccw")
        yield from _pass(machine, order.low_rad, "cw")
        yield from machine.go_to(machine.park_rad)
    finally:
        machine.take_for(None)
        machine.interlock.disarm()
    machine.say(State.PARKED)


def _static_frame(machine: Machine, lasers: tuple[LaserName, ...]) -> Program:
    machine.shine(lasers, Purpose.MEASURING)
    yield from machine.pause(_LATEST_S)
    machine.take_for("static")
    frames: list[CameraFrame] = []
    yield from machine.see(1, frames)
    machine.take_for(None)
    if not frames:
        raise CameraLostError("no frame came at a stop; check the camera, then record this placement again.")


def _pass(machine: Machine, to_rad: float, sweep: FrameSweep) -> Program:
    carriage = machine.carriage
    ccw = to_rad > carriage.theta_rad
    carriage.turn(ccw, 0)
    machine.take_for(sweep)
    reach = carriage.drive.stopping_rad(0)
    yield from machine.turned_to(to_rad - (reach if ccw else -reach), 1.0 if ccw else -1.0, 0)
    yield from machine.come_to_rest()


def even_stops(count: int, first_rad: float = float(np.deg2rad(3.0))) -> tuple[float, ...]:
    """Head angles spread evenly over a turn."""
    return tuple(first_rad + k * 2.0 * np.pi / count for k in range(count))
