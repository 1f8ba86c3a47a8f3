"""The live view: light-plane points of the frames as they come, for the screen only; the result is made from disk."""

import threading
from collections import Counter
from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats32, LaserName
from footscan.devices.clock import Clock
from footscan.devices.values import CameraFrame
from footscan.geometry.rigid import turn_z
from footscan.optics.tables import LightTable
from footscan.scanning.session.angle_track import AngleTrack
from footscan.scanning.session.queue_thread import QueueThread
from footscan.scanning.session.states import LiveCount
from footscan.scanning.stripe import StripeFinder, automatic_threshold

QUEUED_FRAMES = 64
_PATIENCE_S = 0.2


@dataclass(frozen=True)
class LivePoints:
    """Points of one frame: `(n, 3)` world millimetres, and which laser drew them."""

    xyz_world: Floats32
    laser: LaserName


class LiveView:
    """Points of the frames of a scan so far; a frame it has no time for is skipped by name, never waited for.

    Attributes:
        threshold: Given; None to find it on the first frame of each scan.
    """

    def __init__(self, clock: Clock, tables: dict[LaserName, LightTable], track: AngleTrack, latency_s: float) -> None:
        self.threshold: int | None = None
        self._clock, self._tables, self._track, self._latency_s = clock, tables, track, latency_s
        self._finder = StripeFinder()
        self._lock = threading.Lock()
        self._points: list[LivePoints] = []
        self._given = self._scan = 0
        self._found: int | None = None
        self._skipped: Counter[str] = Counter()
        self.thread: QueueThread[tuple[CameraFrame, LaserName, int]] = QueueThread(
            "makes the live view", clock, self._work, QUEUED_FRAMES
        )

    def clear(self) -> None:
        """Forget the points of the last scan."""
        with self._lock:
            self._points, self._given, self._skipped = [], 0, Counter()
            self._scan, self._found = self._scan + 1, None

    def offer(self, frame: CameraFrame, laser: LaserName) -> None:
        """A lit frame."""
        with self._lock:
            self._given += 1
        if not self.thread.offer((frame, laser, self._scan)):
            self._skip("live view behind")

    def points_since(self, index: int) -> list[LivePoints]:
        """Points of all frames after the first `index` shown ones."""
        with self._lock:
            return self._points[index:]

    def count(self) -> LiveCount:
        """How many frames so far."""
        with self._lock:
            return LiveCount(self._given, len(self._points), dict(self._skipped))

    def _work(self, item: tuple[CameraFrame, LaserName, int]) -> None:
        frame, laser, scan = item
        if scan != self._scan:  # of the scan before: its view has been cleared
            return
        exposed_s = frame.time_s - self._latency_s
        if not self._clock.wait(self._clock.now_s() + _PATIENCE_S, lambda: self._track.reaches(exposed_s)):
            self._skip("angle unknown")
            return
        theta_rad = float(self._track.theta_at(np.array([exposed_s]))[0])
        if not np.isfinite(theta_rad):
            self._skip("angle unknown")
            return
        points = self._points_of(frame, laser, theta_rad)
        with self._lock:
            if scan == self._scan:
                self._points.append(points)

    def _points_of(self, frame: CameraFrame, laser: LaserName, theta_rad: float) -> LivePoints:
        threshold = self.threshold
        if threshold is None:
            threshold = self._found = automatic_threshold(frame.frame) if self._found is None else self._found
        stripe = self._finder.find(frame.frame, threshold)
        table = self._tables[laser]
        xy_light = table.lookup(stripe.uv)
        xy_light = xy_light[np.isfinite(xy_light[:, 0])]
        world_from_light = turn_z(theta_rad) @ table.world_from_light
        xyz = xy_light @ world_from_light[:3, :2].T + world_from_light[:3, 3]
        return LivePoints(xyz.astype(np.float32), laser)

    def _skip(self, reason: str) -> None:
        with self._lock:
            self._skipped[reason] += 1
