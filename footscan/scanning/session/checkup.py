"""The check before a scan: devices, calibration, disk, light, the foot's place, and the motor's direction."""

import shutil
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from footscan.coordinates import LASER_NAMES, Frame, LaserName
from footscan.devices.interlock import Purpose
from footscan.devices.values import CameraFrame
from footscan.errors import HeadStalledError, WrongWayError
from footscan.optics.tables import LightTable
from footscan.scanning.session.checks import TestFrames, judge_light, judge_place
from footscan.scanning.session.machine import Machine, Program
from footscan.scanning.session.plan import ScanPlan
from footscan.scanning.session.states import Finding, State

_RATE_FRAMES = 8
_RATE_TOLERANCE = 0.2
_JOG_RAD = np.deg2rad(3.0)
_SPARE_BYTES = 200_000_000
_PNG_SHARE = 0.6  # of the raw picture, at most


@dataclass(frozen=True)
class CheckOrder:
    """What the check needs to know: where the recording will go, how large it gets, and the tables if there are any."""

    folder: Path
    plan: ScanPlan
    tables: dict[LaserName, LightTable] | None


def check_before_scan(machine: Machine, order: CheckOrder) -> Program:
    """Look at everything that can spoil a scan; what is found stands in `machine.findings`."""
    machine.say(State.CHECKING)
    machine.findings = ()
    findings = [*_calibration(machine), *_disk(machine, order)]
    findings += yield from _camera(machine)
    if not machine.carriage.homed:
        findings.append(Finding("head not homed", "the head has not found its home yet; home it first."))
    else:
        findings += yield from _look(machine, order)
        findings += yield from _jog(machine)
    machine.findings = tuple(findings)
    blocking = [finding for finding in findings if finding.blocking]
    machine.say(State.PARKED, blocking[0].sentence if blocking else None)


def _calibration(machine: Machine) -> list[Finding]:
    calibration, scanner = machine.calibration, machine.scanner
    if calibration is None:
        return [Finding("calibration missing", "no calibration is in force for this machine; calibrate it first.")]
    if None not in (calibration.machine_id, scanner.machine_id) and calibration.machine_id != scanner.machine_id:
        return [
            Finding(
                "calibration of another machine",
                f"the calibration in force is of machine {calibration.machine_id!r}, this is {scanner.machine_id!r}; "
                "calibrate this machine, or correct machine_id in the rig file.",
            )
        ]
    found = (machine.facts.width_px, machine.facts.height_px)
    wanted = (calibration.camera.width_px, calibration.camera.height_px)
    if found != wanted:
        return [
            Finding(
                "camera size",
                f"the camera delivers {found[0]} x {found[1]} pixels, the calibration is for {wanted[0]} x "
                f"{wanted[1]}; set the camera's size in the rig file, or calibrate again.",
            )
        ]
    return []


def _disk(machine: Machine, order: CheckOrder) -> list[Finding]:
    place = next(parent for parent in (order.folder, *order.folder.parents) if parent.exists())
    free = shutil.disk_usage(place).free
    needed = _SPARE_BYTES + _PNG_SHARE * order.plan.frame_count * machine.facts.width_px * machine.facts.height_px
    if free >= needed:
        return []
    return [
        Finding(
            "disk space",
            f"{free / 1e6:.0f} MB are free at {place}, the scan needs {needed / 1e6:.0f} MB; free space or choose "
            "another data folder.",
        )
    ]


def _camera(machine: Machine) -> Generator[None, None, list[Finding]]:
    frames: list[CameraFrame] = []
    yield from machine.see(_RATE_FRAMES, frames)
    if len(frames) < _RATE_FRAMES:
        return [Finding("camera too slow", f"only {len(frames)} frames came in the time of {_RATE_FRAMES}.")]
    span = frames[-1].number - frames[0].number
    rate = span / max(frames[-1].time_s - frames[0].time_s, 1e-9)
    wanted = machine.motion.frames_per_s
    if abs(rate - wanted) <= _RATE_TOLERANCE * wanted:
        return []
    return [
        Finding(
            "frame rate",
            f"the camera delivers {rate:.1f} frames a second, the rig file says {wanted:g}; correct frames_per_s or "
            "the exposure, which may be longer than a frame.",
        )
    ]


def _look(machine: Machine, order: CheckOrder) -> Generator[None, None, list[Finding]]:
    unlit = yield from _frame(machine, ())
    lit: dict[LaserName, Frame] = {}
    for laser in LASER_NAMES:
        seen = yield from _frame(machine, (laser,))
        if seen is not None:
            lit[laser] = seen
    machine.quiet()
    if unlit is None or len(lit) < len(LASER_NAMES):
        return [Finding("camera too slow", "no frame came while the lasers were tried; check the camera.")]
    frames = TestFrames(machine.carriage.theta_rad, unlit, lit)
    findings = judge_light(frames)
    if order.tables is not None and not any(finding.blocking for finding in findings):
        findings += judge_place(frames, order.tables)
    return findings


def _frame(machine: Machine, lasers: tuple[LaserName, ...]) -> Generator[None, None, Frame | None]:
    machine.shine(lasers, Purpose.MEASURING)
    frames: list[CameraFrame] = []
    yield from machine.see(1, frames)
    return frames[0].frame if frames else None


def _jog(machine: Machine) -> Generator[None, None, list[Finding]]:
    """A few degrees and back: the motor turns, and the right way."""
    carriage = machine.carriage
    try:
        carriage.turn(ccw=True, speed_step=0)
        yield from machine.turned_to(carriage.theta_rad + _JOG_RAD, 1.0, 0)
        yield from machine.come_to_rest()
        yield from machine.go_to(machine.park_rad)
    except WrongWayError as err:
        machine.quiet()
        return [Finding("motor turns the wrong way", str(err))]
    except HeadStalledError as err:
        machine.quiet()
        return [Finding("head blocked", str(err))]
    return []
