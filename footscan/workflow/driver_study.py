"""The driver study: one foot scanned by the pure simulation and over real drivers on emulators; the clouds compared.

Every way begins alike: home, two sweeps, the true calibration. What homing is off by turns a whole cloud about the
axis; it is measured and told apart. Then what the drivers said of time and angle is *replayed*: the pictures that the
machine would have taken had every stamp and count been exact, with the noise of the real ones. The rest between the two
clouds, point by point, is what the drivers' clocks got wrong.
"""

import contextlib
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from footscan.config import RecordingInfo, scanner_toml
from footscan.config.device_models import SimulatedCamera, SimulatedEncoder, SimulatedIo
from footscan.config.io_models import AdamModel, Dialect
from footscan.config.rig_file import Rig
from footscan.coordinates import Frame
from footscan.errors import DeviceError
from footscan.geometry.rigid import turn_z
from footscan.optics.calibration import Calibration
from footscan.scanning.angles import frame_angles
from footscan.scanning.cloud import Cloud, cloud_from_matrix
from footscan.scanning.recorder import RecordingWriter
from footscan.scanning.recording import Recording, open_recording
from footscan.scanning.session.control import Session, SessionSetup
from footscan.scanning.session.plan import plan_scan
from footscan.scanning.session.programs import ScanOrder, home, scan
from footscan.scanning.session.states import FrameCount
from footscan.scanning.sweep import SweepSettings
from footscan.sim.picture import Painter
from footscan.sim.surface import Surface
from footscan.sim.world import World
from footscan.workflow.cloud_comparison import HEIGHTS_MM, points_apart, rms, skins_apart
from footscan.workflow.opened_rig import OpenedRig
from footscan.workflow.process import ProcessSettings, ScanResult, build_tables, process_recording
from footscan.workflow.truth import distance_to_surface_mm

OpenRig = Callable[[Rig], OpenedRig]
DIALECTS: tuple[Dialect, ...] = ("adam4055", "i7050")
BAUDS = (115200, 9600)
SWITCHING_S = {115200: 0.010, 9600: 0.040}
SAME_MM, REPLAYED_MM = 0.05, 0.02
_FARTHEST_TURN_RAD = np.deg2rad(1.0)
_ATTEMPTS = 4
_INFO = RecordingInfo("scan", "left", "2026-01-01T00:00:00+00:00", "driver study")


@dataclass(frozen=True)
class DriverRun:
    """One way of scanning the same foot.

    Attributes:
        name: Devices and speed.
        frames: What became of them.
        truth_mm: RMS distance of the cloud to the true skin, 3 < z < 95 mm.
        turned_mm: The same once the cloud is turned back about the axis.
        home_off_deg: How far.
        same_mm: RMS distance of this cloud's skin to the pure simulation's, each the mean of 12 neighbours; None there.
        replayed_mm: RMS distance of its points to those of the replay; None for the pure simulation.
        paired: Share of its points that have one within 0.5 mm in the same frame of the replay.
    """

    name: str
    frames: FrameCount
    truth_mm: float
    turned_mm: float
    home_off_deg: float
    same_mm: float | None = None
    replayed_mm: float | None = None
    paired: float | None = None

    @property
    def well(self) -> bool:
        """Nothing lost, and both distances within their targets."""
        near = (self.same_mm or 0.0) <= SAME_MM and (self.replayed_mm or 0.0) <= REPLAYED_MM
        return near and self.frames.lost == 0 and self.frames.captured == self.frames.kept + _rejected(self.frames)


def run_driver_study(
    rig: Rig, calibration: Calibration, open_rig: OpenRig, dialects: tuple[Dialect, ...], bauds: tuple[int, ...]
) -> Iterator[DriverRun]:
    """The pure simulation first, then each dialect at each speed.

    Args:
        rig: Of emulators.
        calibration: The truth of its machine.
        open_rig: How it is opened, which only `app` knows.
        dialects: Of the digital I/O module.
        bauds: Of its port.

    Raises:
        DeviceError: A computer too busy for the real time of the emulators broke a scan.
    """
    with tempfile.TemporaryDirectory(prefix="footscan-drivers-") as folder:
        pure = _scanned(_simulated(rig), calibration, open_rig, Path(folder) / "simulated")
        reference = _judged("simulated", pure)
        yield reference
        for dialect in dialects:
            for baud in bauds:
                name = f"{dialect} {baud} baud"
                seen = _scanned(_with_module(rig, dialect, baud), calibration, open_rig, Path(folder) / name)
                replay = _replayed(seen, calibration, Path(folder) / f"{name} replayed")
                distance_mm, paired = points_apart(seen.whole, replay)
                same_mm = skins_apart(seen.result.cloud, pure.result.cloud)
                yield replace(_judged(name, seen), same_mm=same_mm, replayed_mm=distance_mm, paired=paired)


@dataclass(frozen=True)
class _Seen:
    """A recorded scan, what it became, and what its camera was asked for when."""

    recording: Recording
    frames: FrameCount
    result: ScanResult
    whole: Cloud
    world: World
    stamps_s: tuple[float, ...]

    @property
    def body(self) -> Surface:
        """The true foot where it stood."""
        return self.world.standing.body


def _simulated(rig: Rig) -> Rig:
    camera, world = rig.devices.camera, rig.devices.world
    assert world is not None
    devices = rig.devices.model_copy(
        update={
            "camera": SimulatedCamera(kind="simulated", exposure_s=camera.exposure_s),
            "encoder": SimulatedEncoder(kind="simulated"),
            "io": SimulatedIo(kind="simulated"),
            "world": world.model_copy(update={"person": "statue", "time": "fast"}),
        }
    )
    return replace(rig, devices=devices)


def _with_module(rig: Rig, dialect: Dialect, baud: int) -> Rig:
    io, world = rig.devices.io, rig.devices.world
    assert isinstance(io, AdamModel)
    assert world is not None
    update = {
        "io": io.model_copy(update={"dialect": dialect, "baud": baud}),
        "world": world.model_copy(update={"person": "statue"}),
    }
    motion = rig.motion.model_copy(update={"switching_s": SWITCHING_S[baud]})
    return replace(rig, motion=motion, devices=rig.devices.model_copy(update=update))


def _scanned(rig: Rig, calibration: Calibration, open_rig: OpenRig, folder: Path) -> _Seen:
    """Emulators need real time: a scan that a busy computer has broken is begun again.

    Raises:
        DeviceError: It was broken each time.
    """
    for attempt in range(_ATTEMPTS - 1):
        with contextlib.suppress(DeviceError):
            return _scanned_once(rig, calibration, open_rig, folder / str(attempt))
    return _scanned_once(rig, calibration, open_rig, folder / "last")


def _scanned_once(rig: Rig, calibration: Calibration, open_rig: OpenRig, folder: Path) -> _Seen:
    folder.mkdir(parents=True)
    opened = open_rig(rig)
    assert opened.world is not None
    stamps_s = _stamps_asked_for(opened)
    session = Session(opened.devices, SessionSetup(rig.scanner, rig.motion, calibration, build_tables(calibration)))
    session.start()
    try:
        session.post_arm(no_faces_at_beam_height=True).wait()
        session.post(home).wait()
        plan = plan_scan(rig.motion, rig.profile(None), session.facts, rig.scanner)
        session.post(lambda machine: scan(machine, ScanOrder(folder, _INFO, plan, countdown_s=0.2))).wait()
        frames = session.snapshot().frames
    finally:
        session.close()
        opened.give_back()
    recording = open_recording(folder)
    result = process_recording(recording, calibration, ProcessSettings())
    whole = cloud_from_matrix(result.sweep.matrix, build_tables(calibration))
    return _Seen(recording, frames, result, whole, opened.world, tuple(stamps_s))


def _stamps_asked_for(opened: OpenedRig) -> list[float]:
    """Filled with the stamp of each picture that the emulated camera makes, in order: its place numbers the noise."""
    stamps_s: list[float] = []
    plug = opened.emulated.camera if opened.emulated is not None else None
    if plug is not None:
        inner = plug.frame_at

        def noted(stamp_s: float) -> Frame:
            stamps_s.append(stamp_s)
            return inner(stamp_s)

        plug.frame_at = noted
    return stamps_s


def _replayed(seen: _Seen, calibration: Calibration, folder: Path) -> Cloud:
    """The same stamps and counts, with the pictures that belong to them."""
    recording, world = seen.recording, seen.world
    time_s = np.array([record.time_s for record in recording.frames])
    angles = frame_angles(time_s, calibration.latency_s, recording.encoder, calibration.encoder)
    numbers = np.searchsorted(np.array(seen.stamps_s) - 1e-4, time_s, side="right") - 1
    painter = Painter(world.machine.calibration, world.standing.surface, world.settings.picture, world.settings.seed)
    folder.mkdir()
    with RecordingWriter(folder, _INFO, scanner_toml(recording.scanner)) as writer:
        for record, theta_rad, number in zip(recording.frames, angles.theta_rad, numbers, strict=True):
            if not np.isfinite(theta_rad):
                raise DeviceError(f"the angle of frame {record.frame} is unknown; the computer is too busy, run again.")
            laser = None if record.laser == "none" else record.laser
            frame = painter.paint(float(theta_rad), laser, int(number))
            writer.add_frame(frame, record.time_s, record.laser, record.sweep)
        writer.add_counts(recording.encoder.time_s, recording.encoder.count.astype(np.int64))
    settings = ProcessSettings(sweep=SweepSettings(threshold=seen.result.sweep.threshold))
    result = process_recording(open_recording(folder), calibration, settings)
    return cloud_from_matrix(result.sweep.matrix, build_tables(calibration))


def _judged(name: str, seen: _Seen) -> DriverRun:
    z = seen.result.cloud.xyz_world[:, 2]
    xyz = seen.result.cloud.xyz_world[(z > HEIGHTS_MM[0]) & (z < HEIGHTS_MM[1])]

    def off_mm(turn_rad: float, every: int = 1) -> float:
        turned = xyz[::every] @ turn_z(turn_rad)[:3, :3].T
        return rms(distance_to_surface_mm(turned, seen.body.xyz_world, seen.body.faces))

    bounds = (-_FARTHEST_TURN_RAD, _FARTHEST_TURN_RAD)
    best: Any = minimize_scalar(lambda turn: off_mm(float(turn), 7), bounds=bounds, method="bounded")
    return DriverRun(name, seen.frames, off_mm(0.0), off_mm(float(best.x)), float(np.rad2deg(-best.x)))


def _rejected(frames: FrameCount) -> int:
    return sum(frames.rejected.values())
