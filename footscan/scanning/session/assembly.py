"""How a machine is put together from opened devices: interlock, carriage, and the threads that take and keep frames."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from footscan.config.rig_file import MotionModel
from footscan.coordinates import LaserName
from footscan.devices.carriage import Carriage, Drive
from footscan.devices.clock import Clock
from footscan.devices.interlock import Interlock, InterlockLimits
from footscan.devices.protocols import Camera, DigitalIo, Encoder
from footscan.devices.values import CameraFrame
from footscan.optics.calibration import Calibration
from footscan.optics.scanner import Scanner
from footscan.optics.tables import LightTable
from footscan.scanning.session.angle_track import AngleTrack
from footscan.scanning.session.grabber import Grabber
from footscan.scanning.session.keeper import Keeper, LightLog
from footscan.scanning.session.live import LiveView
from footscan.scanning.session.machine import Machine
from footscan.scanning.session.timeline import Timeline


@dataclass(frozen=True)
class RigDevices:
    """The opened devices and the time they share."""

    camera: Camera
    encoder: Encoder
    io: DigitalIo
    clock: Clock


@dataclass(frozen=True)
class SessionSetup:
    """What a session is about: the machine's design and motion, its calibration and tables if there are any."""

    scanner: Scanner
    motion: MotionModel
    calibration: Calibration | None
    tables: dict[LaserName, LightTable] | None


def drive_of(scanner: Scanner, motion: MotionModel) -> Drive:
    """The head's drive by its rig file."""
    low, high = np.deg2rad(motion.travel_deg)
    encoder = scanner.encoder
    return Drive(
        tuple(float(speed) for speed in np.deg2rad(motion.speeds_deg_per_s)),
        float(np.deg2rad(motion.acceleration_deg_per_s2)),
        (float(low), float(high)),
        encoder.steps_per_rev,
        encoder.zero_count,
        encoder.direction,
    )


class Assembly:
    """Puts the parts of one machine together, and makes those again whose threads have ended."""

    def __init__(self, devices: RigDevices, setup: SessionSetup) -> None:
        """Take opened devices and what the session is about."""
        self._devices, self._setup = devices, setup
        self._log = LightLog(Timeline(None), Timeline(None), Timeline(False), Timeline(""))
        encoder = setup.scanner.encoder if setup.calibration is None else setup.calibration.encoder
        self.track = AngleTrack(encoder)

    def machine(self, hand_on: Callable[[CameraFrame], None]) -> Machine:
        """The whole machine, its threads not started; every frame that arrives goes to `hand_on`."""
        devices, setup = self._devices, self._setup
        limits = InterlockLimits(setup.motion.watchdog_s, setup.motion.max_on_s)
        interlock = Interlock(devices.io, devices.clock, limits, self._log.light.note)
        live = self.live()
        return Machine(
            devices.clock,
            interlock,
            Carriage(devices.encoder, interlock, drive_of(setup.scanner, setup.motion), devices.clock),
            setup.motion,
            setup.scanner,
            devices.camera.facts(),
            self.grabber(hand_on),
            self.keeper(live),
            live,
            self._log,
            setup.calibration,
            devices.io.read_inputs(),
        )

    def live(self) -> LiveView | None:
        """The live view, None without a calibration."""
        calibration, tables = self._setup.calibration, self._setup.tables
        if calibration is None or tables is None:
            return None
        return LiveView(self._devices.clock, tables, self.track, calibration.latency_s)

    def keeper(self, live: LiveView | None) -> Keeper:
        """Who writes the frames."""
        facts = self._devices.camera.facts()
        return Keeper(self._devices.clock, facts.width_px * facts.height_px, self._log, self.track, live)

    def grabber(self, hand_on: Callable[[CameraFrame], None]) -> Grabber:
        """Who takes the frames."""
        return Grabber(self._devices.camera, self._devices.clock, hand_on)
