"""The loop over the frames of a scan: filter, stripe, table, scan matrix. No trigonometry, no inverse.

Frames are worked on by a few threads (decoding, filter and stripe leave the interpreter lock), each with buffers of
its own, and enter the matrix in their order. Nothing but points outlives a frame.
"""

import threading
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import islice

import numpy as np

from footscan.coordinates import LASER_NAMES, Bools, Floats, Frame, Ints, LaserName
from footscan.errors import EmptyScanError, InputError
from footscan.optics.calibration import Calibration
from footscan.optics.tables import LightTable
from footscan.scanning.angles import FrameAngles, frame_angles, refuse_silent_encoder
from footscan.scanning.filters import FilterSettings, filtered
from footscan.scanning.frames import UnusableFrameError, read_frame
from footscan.scanning.matrix import ScanMatrix
from footscan.scanning.recording import FrameRecord, Recording
from footscan.scanning.stripe import StripeFinder, StripeSettings, brightness_histogram
from footscan.scanning.stripe.find import DEFAULT_SETTINGS
from footscan.scanning.stripe.threshold import threshold_from_histogram

Progress = Callable[[int, int], None]
_THRESHOLD_FRAMES = 48
_AHEAD = 16
_FEWEST_STEPS = 8
_STILL_SHARE = 0.05


@dataclass(frozen=True)
class SweepSettings:
    """How frames become points: threshold (None: automatic, one for the scan), picture filter, stripe rules."""

    threshold: int | None = None
    picture_filter: FilterSettings = field(default_factory=FilterSettings)
    stripe: StripeSettings = DEFAULT_SETTINGS
    threads: int = 2


@dataclass
class Accounting:
    """frames seen = used + rejected by reason; also where stripe points outside the working volume went."""

    seen: int = 0
    used: int = 0
    rejected: Counter[str] = field(default_factory=Counter)
    details: list[str] = field(default_factory=list)
    points_outside_volume: int = 0

    def reject(self, reason: str, detail: str) -> None:
        """Count one frame as rejected; the first few details are kept."""
        self.rejected[reason] += 1
        if len(self.details) < 20:
            self.details.append(detail)


@dataclass(frozen=True)
class SweepResult:
    """The scan matrix, the threshold used, the accounting, and the brightest value of every pixel per laser."""

    matrix: ScanMatrix
    threshold: int
    accounting: Accounting
    brightest: dict[LaserName, Frame]


@dataclass(frozen=True)
class _FramePoints:
    xy_light: Floats
    weight: Floats
    outside: int


class _Worker(threading.local):
    """Buffers of one thread."""

    def __init__(self, shape: tuple[int, int], settings: StripeSettings, kept: list[dict[LaserName, Frame]]) -> None:
        self.finder = StripeFinder(settings)
        self.brightest: dict[LaserName, Frame] = {name: np.zeros(shape, np.uint8) for name in LASER_NAMES}
        kept.append(self.brightest)


def sweep_frames(
    recording: Recording,
    calibration: Calibration,
    tables: dict[LaserName, LightTable],
    settings: SweepSettings,
    progress: Progress = lambda done, total: None,
) -> SweepResult:
    """Turn the lit frames of a scan into a scan matrix.

    Raises:
        RecordingError: A silent or jumping encoder.
        EmptyScanError: No lit frame at all.
        InputError: The unlit filter without unlit frames.
    """
    lit = [record for record in recording.frames if record.laser != "none"]
    if not lit:
        raise EmptyScanError(f"{recording.folder} has no frame with a laser on; check the lasers and scan again.")
    accounting = Accounting(seen=len(recording.frames))
    if len(lit) < len(recording.frames):
        accounting.rejected["unlit"] = len(recording.frames) - len(lit)
    time_s = np.array([record.time_s for record in lit])
    _refuse_silence(lit, time_s, recording, calibration)
    angles = frame_angles(time_s, calibration.latency_s, recording.encoder, calibration.encoder)
    lit_ok = _usable(lit, time_s, angles, accounting)
    jobs = [(lit[i], float(angles.theta_rad[i])) for i in lit_ok]
    unlit = _unlit_frames(recording, settings.picture_filter)
    threshold = (
        settings.threshold if settings.threshold is not None else _common_threshold(jobs, recording, settings, unlit)
    )
    matrix = ScanMatrix(tables["right"].calibration_sha256)
    brightest = _run(jobs, recording, tables, settings, threshold, unlit, matrix, accounting, progress)
    return SweepResult(matrix, threshold, accounting, brightest)


def _refuse_silence(lit: list[FrameRecord], time_s: Floats, recording: Recording, calibration: Calibration) -> None:
    for sweep in ("ccw", "cw"):
        moving = np.array([record.sweep == sweep for record in lit])
        if moving.sum() > 1:
            refuse_silent_encoder(time_s[moving], recording.encoder, calibration.latency_s)


def _usable(lit: list[FrameRecord], time_s: Floats, angles: FrameAngles, accounting: Accounting) -> Ints:
    """Indices of the frames whose angle can be trusted; the others are rejected by name."""
    latest = np.maximum.accumulate(np.where(angles.known, time_s, -np.inf))
    backward, silent = angles.known & (time_s < latest), silent_frames(lit, time_s, angles)
    for i in np.flatnonzero(~angles.known):
        accounting.reject("no encoder sample near", f"frame {lit[i].frame} at {time_s[i]:.3f} s")
    for i in np.flatnonzero(backward):
        accounting.reject("time goes back", f"frame {lit[i].frame}: {time_s[i]:.6f} s after {latest[i]:.6f} s")
    for i in np.flatnonzero(silent & ~backward):
        accounting.reject("encoder silent", f"frame {lit[i].frame}: the count stood still in the middle of a sweep")
    return np.flatnonzero(angles.known & ~backward & ~silent)


def silent_frames(lit: list[FrameRecord], time_s: Floats, angles: FrameAngles) -> Bools:
    """Which frames lie where the angle stands still in the middle of a moving sweep: the encoder fell silent.

    Rest before the first and after the last motion of a sweep is no fault.
    """
    silent = np.zeros(len(lit), dtype=np.bool_)
    for sweep in ("ccw", "cw"):
        own = np.flatnonzero(angles.known & np.array([record.sweep == sweep for record in lit]))
        own = own[np.argsort(time_s[own], kind="stable")]
        step = np.abs(np.diff(angles.theta_rad[own]))
        if len(step) < _FEWEST_STEPS:
            continue
        moving = step > _STILL_SHARE * float(np.median(step))
        if moving.any():
            first, after = int(np.argmax(moving)), len(moving) - int(np.argmax(moving[::-1]))
            still = np.flatnonzero(~moving[first:after]) + first
            silent[own[still]] = True
            silent[own[still + 1]] = True
    return silent


class _Unlit:
    """The usable unlit frame nearest in time; a few stay in memory."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._records = [record for record in recording.frames if record.laser == "none"]
        self._time_s = np.array([record.time_s for record in self._records])
        self._read = lru_cache(maxsize=4)(self._read_one)
        if not any(self._read(index) is not None for index in range(len(self._records))):
            raise InputError("the filter subtracts an unlit frame, but the recording has none; choose another filter.")

    def _read_one(self, index: int) -> Frame | None:
        try:
            return read_frame(self._recording.path(self._records[index]), self._recording.scanner.camera)
        except UnusableFrameError:
            return None

    def near(self, time_s: float) -> Frame:
        """The nearest one that can be read; the constructor made sure that there is one."""
        order = np.argsort(np.abs(self._time_s - time_s), kind="stable")
        return next(frame for index in order if (frame := self._read(int(index))) is not None)


def _unlit_frames(recording: Recording, settings: FilterSettings) -> _Unlit | None:
    return _Unlit(recording) if settings.kind == "unlit" else None


def _picture(record: FrameRecord, recording: Recording, settings: SweepSettings, unlit: _Unlit | None) -> Frame:
    frame = read_frame(recording.path(record), recording.scanner.camera)
    dark = unlit.near(record.time_s) if unlit is not None else None
    return filtered(frame, settings.picture_filter, dark)


def _common_threshold(
    jobs: list[tuple[FrameRecord, float]], recording: Recording, settings: SweepSettings, unlit: _Unlit | None
) -> int:
    """One automatic threshold for the scan, from frames spread over both sweeps."""
    histogram = np.zeros(256, dtype=np.int64)
    for record, _ in jobs[:: max(1, len(jobs) // _THRESHOLD_FRAMES)]:
        try:
            histogram += brightness_histogram(_picture(record, recording, settings, unlit))
        except UnusableFrameError:
            continue
    return threshold_from_histogram(histogram) if histogram.any() else 255


def _run(
    jobs: list[tuple[FrameRecord, float]],
    recording: Recording,
    tables: dict[LaserName, LightTable],
    settings: SweepSettings,
    threshold: int,
    unlit: _Unlit | None,
    matrix: ScanMatrix,
    accounting: Accounting,
    progress: Progress,
) -> dict[LaserName, Frame]:
    camera = recording.scanner.camera
    kept: list[dict[LaserName, Frame]] = []
    worker = _Worker((camera.height_px, camera.width_px), settings.stripe, kept)

    def work(job: tuple[FrameRecord, float]) -> _FramePoints | UnusableFrameError:
        record, _ = job
        try:
            frame = _picture(record, recording, settings, unlit)
        except UnusableFrameError as reject:
            return reject
        laser = record.laser
        assert laser != "none"
        np.maximum(worker.brightest[laser], frame, out=worker.brightest[laser])
        stripe = worker.finder.find(frame, threshold)
        xy_light = tables[laser].lookup(stripe.uv)
        inside = np.isfinite(xy_light[:, 0])
        return _FramePoints(xy_light[inside], stripe.weight[inside], int(len(inside) - inside.sum()))

    for done, ((record, theta_rad), result) in enumerate(_in_order(work, jobs, settings.threads), start=1):
        if isinstance(result, UnusableFrameError):
            accounting.reject(result.reason, str(result))
        else:
            accounting.used += 1
            accounting.points_outside_volume += result.outside
            laser: LaserName = "right" if record.laser == "right" else "left"
            matrix.append(record.frame, laser, theta_rad, result.xy_light, result.weight)
        progress(done, len(jobs))
    empty = np.zeros((camera.height_px, camera.width_px), np.uint8)
    return {name: np.max([empty, *(part[name] for part in kept)], axis=0) for name in LASER_NAMES}


def _in_order(
    work: Callable[[tuple[FrameRecord, float]], _FramePoints | UnusableFrameError],
    jobs: list[tuple[FrameRecord, float]],
    threads: int,
) -> Iterator[tuple[tuple[FrameRecord, float], _FramePoints | UnusableFrameError]]:
    """Results in the order of the jobs, with only a few frames under way at once."""
    with ThreadPoolExecutor(threads) as pool:
        waiting = iter(jobs)
        under_way = [(job, pool.submit(work, job)) for job in islice(waiting, _AHEAD)]
        while under_way:
            job, future = under_way.pop(0)
            for following in islice(waiting, 1):
                under_way.append((following, pool.submit(work, following)))
            yield job, future.result()
