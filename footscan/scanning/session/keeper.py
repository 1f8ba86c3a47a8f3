"""The keeper: names the light of every frame and writes the recording, in a thread of its own."""

import threading
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from footscan.config import RecordingInfo
from footscan.devices.clock import Clock
from footscan.devices.values import CameraFrame, EncoderSamples, Outputs
from footscan.errors import InterlockError
from footscan.scanning.recorder import RecordingWriter
from footscan.scanning.recording import FrameLaser, FrameSweep
from footscan.scanning.session.angle_track import AngleTrack
from footscan.scanning.session.live import LiveView
from footscan.scanning.session.picker import AnglePicker, RequestedAngles
from footscan.scanning.session.queue_thread import QueueThread
from footscan.scanning.session.states import FrameCount
from footscan.scanning.session.timeline import Timeline

QUEUE_BYTES = 512_000_000
_GUARD_S = 0.001

Phase = FrameSweep | None
"""What frames are taken for now: a sweep, `static` at a stop, or nothing."""


@dataclass(frozen=True)
class ExposureTiming:
    """When a stamped frame saw its light: `latency_s` before the stamp, for `exposure_s`."""

    latency_s: float
    exposure_s: float

    def span_s(self, stamp_s: float) -> tuple[float, float]:
        """Begin and end of the exposure, with a guard of a millisecond."""
        middle, half = stamp_s - self.latency_s, 0.5 * self.exposure_s + _GUARD_S
        return middle - half, middle + half


@dataclass
class LightLog:
    """What shone and what frames were taken for, over time. An unknown light (None) is a laser being switched."""

    light: Timeline[Outputs | None]
    phase: Timeline[Phase]
    blocked: Timeline[bool]
    setup: Timeline[str]

    def name_frame(self, timing: ExposureTiming, stamp_s: float) -> tuple[FrameLaser, FrameSweep] | str:
        """Laser and sweep of a frame, or the name of the reason why it has none."""
        span_s = timing.span_s(stamp_s)
        phases = set(self.phase.during(*span_s))
        if len(phases) > 1:
            return "sweep begins or ends"
        phase = phases.pop()
        if phase is None:
            return "between the sweeps"
        if any(self.blocked.during(*span_s)):
            return "blocked sector"
        lights = {None if outputs is None else outputs.lasers for outputs in self.light.during(*span_s)}
        if len(lights) > 1 or None in lights:
            return "laser switching"
        lasers = lights.pop() or ()
        if len(lasers) > 1:
            return "both lasers on"
        return (lasers[0] if lasers else "none"), phase


@dataclass
class _Recording:
    writer: RecordingWriter
    timing: ExposureTiming
    unlit_wanted: bool
    requested: RequestedAngles | None
    pickers: dict[tuple[FrameLaser, FrameSweep], "AnglePicker[_Named]"]


@dataclass(frozen=True)
class _Named:
    frame: CameraFrame
    laser: FrameLaser
    sweep: FrameSweep


class Keeper:
    """Takes frames from the grab thread without making it wait, and counts every one: kept, or rejected by name."""

    def __init__(
        self,
        clock: Clock,
        frame_bytes: int,
        log: LightLog,
        track: AngleTrack,
        live: LiveView | None,
    ) -> None:
        self._clock, self._log, self._track, self._live = clock, log, track, live
        capacity = max(QUEUE_BYTES // max(frame_bytes, 1), 8)
        self.thread: QueueThread[CameraFrame | EncoderSamples | None] = QueueThread(
            "writes the recording", clock, self._work, capacity
        )
        self._lock = threading.Lock()
        self._recording: _Recording | None = None
        self._accepting = False
        self._captured = self._kept = self._lost = 0
        self._rejected: Counter[str] = Counter()
        self._last_number: int | None = None

    def begin(
        self,
        folder: Path,
        info: RecordingInfo,
        scanner_toml: bytes,
        timing: ExposureTiming,
        unlit_wanted: bool = False,
        requested: RequestedAngles | None = None,
    ) -> None:
        """Open a recording; frames that arrive from now on belong to it.

        Raises:
            InterlockError: The last frames of the recording before it are not yet written.
            RecordingError: The folder already holds one.
            StorageError: The place cannot be written.
        """
        if not self.finished:
            raise InterlockError("the recording before this one is still being written; wait a moment, start again.")
        writer = RecordingWriter(folder, info, scanner_toml)
        with self._lock:
            self._captured = self._kept = self._lost = 0
            self._rejected, self._last_number = Counter(), None
            self._recording = _Recording(writer, timing, unlit_wanted, requested, {})
            self._accepting = True

    def end(self) -> None:
        """No further frames; those in the queue are still written, then the recording is closed."""
        with self._lock:
            closing, self._accepting = self._accepting, False
            if closing:  # under the lock: no frame may come behind the end
                self.thread.offer(None, however_full=True)

    @property
    def finished(self) -> bool:
        """The recording is closed and complete."""
        return self._recording is None

    def outdated(self, live: LiveView | None) -> bool:
        """The live view it feeds has been replaced."""
        return self._live is not live

    def offer(self, frame: CameraFrame) -> None:
        """A frame from the camera; never waits."""
        with self._lock:
            if not self._accepting:
                return
            self._captured += 1
            if self._last_number is not None:
                self._lost += max(frame.number - self._last_number - 1, 0)
            self._last_number = frame.number
            if not self.thread.offer(frame):
                self._rejected["recorder behind"] += 1

    def add_counts(self, samples: EncoderSamples) -> None:
        """What the encoder said since last time."""
        if self._accepting and len(samples):
            self.thread.offer(samples, however_full=True)

    def count(self) -> FrameCount:
        """How many frames so far."""
        with self._lock:
            return FrameCount(self._captured, self._kept, dict(self._rejected), self._lost)

    def abandon(self) -> None:
        """The thread has failed: close what is written so that it can be read; the rest of the queue is named."""
        with self._lock:
            recording, self._recording, self._accepting = self._recording, None, False
            left = self._captured - self._kept - self._rejected.total()
            if recording is not None and left:
                self._rejected["not written"] += left
        if recording is not None:
            recording.writer.break_off()

    def _work(self, item: CameraFrame | EncoderSamples | None) -> None:
        recording = self._recording
        if recording is None:
            return
        if item is None:
            self._close(recording)
        elif isinstance(item, EncoderSamples):
            recording.writer.add_counts(item.time_s, item.count)
        else:
            self._keep(recording, item)

    def _keep(self, recording: _Recording, frame: CameraFrame) -> None:
        named = self._log.name_frame(recording.timing, frame.time_s)
        if isinstance(named, str):
            self._reject(named)
            return
        laser, sweep = named
        if laser == "none" and not recording.unlit_wanted:
            self._reject("laser off")
            return
        if laser != "none" and sweep != "static" and self._live is not None:  # stops look at boards, not at a foot
            self._live.offer(frame, laser)
        for picked in self._picked(recording, _Named(frame, laser, sweep)):
            self._write(recording, picked)

    def _picked(self, recording: _Recording, named: _Named) -> list[_Named]:
        if recording.requested is None or named.sweep == "static":
            return [named]
        exposed_s = named.frame.time_s - recording.timing.latency_s
        self._clock.wait(self._clock.now_s() + 0.1, lambda: self._track.reaches(exposed_s))
        theta_rad = self._track.theta_at(np.array([exposed_s]))[0]
        if not np.isfinite(theta_rad):
            self._reject("angle unknown")
            return []
        key = (named.laser, named.sweep)
        picker = recording.pickers.setdefault(key, AnglePicker(recording.requested))
        before = picker.passed_over
        picked = picker.offer(float(theta_rad), named)
        for _ in range(picker.passed_over - before):
            self._reject("between the requested angles")
        return picked

    def _write(self, recording: _Recording, named: _Named) -> None:
        frame = named.frame
        setup = self._log.setup.at(frame.time_s - recording.timing.latency_s)
        recording.writer.add_frame(frame.frame, frame.time_s, named.laser, named.sweep, setup)
        with self._lock:
            self._kept += 1

    def _close(self, recording: _Recording) -> None:
        for picker in recording.pickers.values():
            for named in picker.rest():
                self._write(recording, named)
        recording.writer.close()
        self._recording = None

    def _reject(self, reason: str) -> None:
        with self._lock:
            self._rejected[reason] += 1
