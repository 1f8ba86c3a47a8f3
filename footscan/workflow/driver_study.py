"""The driver study: one foot scanned by the pure simulation and over real drivers on emulators; the clouds compared.

Every way begins alike: home, two sweeps, the true calibration. What homing is off by turns a whole cloud about the
axis; it is measured and told apart. Then the counts are *replayed*: the same pictures, with the counts that the counter
really showed at the moments which the driver stamped. What is left between the two clouds, point by point, is what the
drivers' clocks got wrong; the constant part of it is one with the latency that a calibration measures.
"""

import contextlib
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from footscan.config import RecordingInfo
from footscan.config.device_models import SimulatedCamera, SimulatedEncoder, SimulatedIo
from footscan.config.io_models import AdamModel, Dialect
from footscan.config.rig_file import Rig
from footscan.coordinates import Floats, Frame
from footscan.errors import DeviceError
from footscan.geometry.rigid import turn_z
from footscan.optics.calibration import Calibration
from footscan.optics.tables import build_tables
from footscan.scanning.angles import frame_angles
from footscan.scanning.cloud import Cloud, cloud_from_matrix
from footscan.scanning.recording import EncoderTrack, Recording, open_recording
from footscan.scanning.session.assembly import SessionSetup
from footscan.scanning.session.control import Session
from footscan.scanning.session.plan import plan_scan
from footscan.scanning.session.programs import ScanOrder, home, scan
from footscan.scanning.session.states import FrameCount
from footscan.scanning.sweep import SweepSettings
from footscan.sim.motion import count_from_theta
from footscan.sim.surface import Surface
from footscan.sim.world import World
from footscan.workflow.cloud_comparison import HEIGHTS_MM, clouds_apart, rms, rms_apart
from footscan.workflow.opened_rig import OpenedRig
from footscan.workflow.process import ProcessSettings, ScanResult, process_recording
from footscan.workflow.truth import distance_to_surface_mm

OpenRig = Callable[[Rig], OpenedRig]
DIALECTS: tuple[Dialect, ...] = ("adam4055", "i7050")
BAUDS = (115200, 9600)
SWITCHING_S = {115200: 0.010, 9600: 0.040}
SAME_MM, REPLAYED_MM = 0.05, 0.02
_FARTHEST_TURN_RAD = np.deg2rad(1.0)
_ATTEMPTS = 4
_TRUE_STEP_S, _REMEMBERED_S, _RATE_S = 0.001, 0.2, 0.005
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
        same_mm: RMS difference of this cloud to the pure simulation's, each as the mean of 12 neighbours off the true
            skin; None there.
        late_ms: How much too late counts are stamped, against the pictures: part of the latency a calibration finds.
        replayed_mm: RMS distance of its points to those of the replay, with that latency; None for the pure simulation.
        late_replayed_mm: The same with the latency of the true machine.
    """

    name: str
    frames: FrameCount
    truth_mm: float
    turned_mm: float
    home_off_deg: float
    same_mm: float | None = None
    replayed_mm: float | None = None
    late_replayed_mm: float | None = None
    late_ms: float | None = None

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
                same_mm = clouds_apart(seen.result.cloud, pure.result.cloud, seen.body)
                asis_mm, replayed_mm, late_ms = _replayed(seen, calibration)
                judged = replace(_judged(name, seen), same_mm=same_mm, late_ms=late_ms)
                yield replace(judged, replayed_mm=replayed_mm, late_replayed_mm=asis_mm)


@dataclass(frozen=True)
class _Seen:
    """A recorded scan, what it became, and how its head really turned: moments `(n,)` and angles `(n,)`."""

    recording: Recording
    frames: FrameCount
    result: ScanResult
    world: World
    true_time_s: Floats
    true_theta_rad: Floats

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
    way = _watched(opened, opened.world)
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
    true = np.concatenate(way) if way else np.empty((0, 2))
    return _Seen(recording, frames, result, opened.world, true[:, 0], true[:, 1])


def _watched(opened: OpenedRig, world: World) -> list[Floats]:
    """Filled, with each picture of the emulated camera, with how the head has turned since the one before, `(k, 2)`."""
    way: list[Floats] = []
    plug = opened.emulated.camera if opened.emulated is not None else None
    if plug is None:
        return way
    inner = plug.frame_at

    def watching(stamp_s: float) -> Frame:
        now_s = time.monotonic()
        begin_s = max(float(way[-1][-1, 0]) if way else 0.0, now_s - _REMEMBERED_S)
        time_s = np.arange(begin_s, now_s, _TRUE_STEP_S)[1:]
        way.append(np.stack([time_s, world.theta_at(time_s)], axis=1))
        return inner(stamp_s)

    plug.frame_at = watching
    return way


def _replayed(seen: _Seen, calibration: Calibration) -> tuple[float, float, float]:
    """RMS distances (mm) to the cloud of the true counts, as is and with the latency found; how late they are (ms)."""
    recording, late_ms = seen.recording, _late_ms(seen, calibration)
    taken_s = recording.encoder.time_s - 0.001 * late_ms
    known = (taken_s > seen.true_time_s[0]) & (taken_s < seen.true_time_s[-1])
    theta_rad = np.interp(taken_s[known], seen.true_time_s, seen.true_theta_rad)
    true_count = count_from_theta(theta_rad, calibration.encoder)
    home_count = round(float(np.median(recording.encoder.count[known] - true_count)))
    exact = EncoderTrack(taken_s[known], (true_count + home_count).astype(np.float64))
    found = replace(calibration, latency_s=calibration.latency_s - 0.001 * late_ms)
    threshold = seen.result.sweep.threshold
    replay = _points(replace(recording, encoder=exact), calibration, threshold)
    asis, put_right = (_points(recording, given, threshold) for given in (calibration, found))
    return rms_apart(asis, replay), rms_apart(put_right, replay), late_ms


def _points(recording: Recording, calibration: Calibration, threshold: int) -> Cloud:
    """All points of all frames."""
    result = process_recording(recording, calibration, ProcessSettings(sweep=SweepSettings(threshold=threshold)))
    return cloud_from_matrix(result.sweep.matrix, build_tables(calibration))


def _late_ms(seen: _Seen, calibration: Calibration) -> float:
    """From the angles of the frames: what changes its sign with the direction of the head is time."""
    stamps_s = np.array([record.time_s for record in seen.recording.frames])
    told = frame_angles(stamps_s, calibration.latency_s, seen.recording.encoder, calibration.encoder)
    exposed_s = stamps_s - calibration.latency_s
    true_rad = np.interp(exposed_s, seen.true_time_s, seen.true_theta_rad)
    rate = np.interp(exposed_s + _RATE_S, seen.true_time_s, seen.true_theta_rad) - true_rad
    off_rad = np.mod(told.theta_rad - true_rad + np.pi, 2.0 * np.pi) - np.pi
    design = np.stack([rate / _RATE_S, np.ones_like(rate)], axis=1)[told.known]
    return float(-1000.0 * np.linalg.lstsq(design, off_rad[told.known])[0][0])


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
