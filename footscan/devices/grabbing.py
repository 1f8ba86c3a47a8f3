"""A camera whose frames are fetched by a thread of its own, which stamps them, notices losses and opens it again."""

import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from footscan.coordinates import Frame
from footscan.devices.values import CameraFacts, CameraFrame
from footscan.errors import CameraLostError, DeviceError

_BUFFERED = 32
_LOST_AFTER_S = 0.9
_LOST_AFTER_FRAMES = 3
_FALSE_READS = 5
_FALSE_READ_PAUSE_S = 0.02
_BACK_OFF_S = (0.5, 1.0, 2.0, 4.0)
_INTERVALS = 25
_FIRST_FRAME_S = 5.0


@dataclass(frozen=True)
class Shot:
    """An upright grey frame and its stamp on CLOCK_MONOTONIC."""

    frame: Frame
    time_s: float


class FrameSource(Protocol):
    """A camera as its driver sees it; only one thread at a time uses it."""

    def open(self) -> CameraFacts:
        """Open it and set it up.

        Raises:
            CameraLostError: It is not there, or not permitted.
            WrongDeviceError: It delivers something else.
        """
        ...

    def next_shot(self) -> Shot | None:
        """The next frame; None if it did not come, after at most about a second.

        Raises:
            CameraLostError: None will ever come.
            WrongDeviceError: It suddenly delivers something else.
        """
        ...

    def close(self) -> None:
        """Give it back; safe to call twice."""
        ...


class GrabbingCamera:
    """The camera the rest of the program sees. A frame that a slow reader leaves too long is a gap in the numbers."""

    def __init__(self, source: FrameSource) -> None:
        """Open it.

        Raises:
            CameraLostError: It is not there.
            WrongDeviceError: It delivers something else.
        """
        self._source, self._facts = source, source.open()
        self._changed = threading.Condition()
        self._frames: deque[CameraFrame] = deque(maxlen=_BUFFERED)
        self._numbers = FrameNumbers(self._facts.frames_per_s)
        self._stopping = threading.Event()
        self._lost: str | None = None
        self._hand: threading.Thread | None = None

    def facts(self) -> CameraFacts:
        """What it really delivers."""
        return self._facts

    def start(self) -> None:
        """Let frames come; returns when the first is there, for a camera may need a second or two to begin.

        Raises:
            CameraLostError: None came in 5 s.
        """
        if self._hand is not None or self._stopping.is_set():
            return
        self._hand = threading.Thread(target=self._grab, name="camera", daemon=True)
        self._hand.start()
        with self._changed:
            begun = self._changed.wait_for(
                lambda: self._frames or self._lost or self._stopping.is_set(), _FIRST_FRAME_S
            )
        if not begun:
            raise self._silence(_FIRST_FRAME_S)

    def read(self, timeout_s: float) -> CameraFrame:
        """The next frame, stamped.

        Raises:
            CameraLostError: None came within `timeout_s`, or the camera is gone.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._frames or self._lost or self._stopping.is_set(), timeout_s)
            if self._frames:
                return self._frames.popleft()
            if self._lost:
                raise CameraLostError(self._lost)
        if self._stopping.is_set() or self._hand is None:
            raise CameraLostError("the camera is not running; start it first.")
        raise self._silence(timeout_s)

    def close(self) -> None:
        """Stop the frames and give the camera back."""
        self._stopping.set()
        with self._changed:
            self._frames.clear()
            self._changed.notify_all()
        if self._hand is not None:
            self._hand.join()
        self._source.close()

    def _silence(self, timeout_s: float) -> CameraLostError:
        return CameraLostError(
            f"no frame came from {self._facts.name} within {timeout_s:g} s; check its cable and supply, then start "
            "again."
        )

    def _grab(self) -> None:
        while not self._stopping.is_set():
            try:
                self._fetch_until_lost()
            except DeviceError as err:
                self._say_lost(str(err))
            self._open_again()

    def _fetch_until_lost(self) -> None:
        heard_s, false_reads = time.monotonic(), 0
        patience_s = max(_LOST_AFTER_S, _LOST_AFTER_FRAMES / self._facts.frames_per_s)
        while not self._stopping.is_set():
            shot = self._source.next_shot()
            if shot is not None:
                heard_s, false_reads = time.monotonic(), 0
                self._keep(shot)
                continue
            false_reads += 1
            silent_s = time.monotonic() - heard_s
            if false_reads >= _FALSE_READS or silent_s > patience_s:
                raise CameraLostError(
                    f"{self._facts.name} has sent nothing for {silent_s:.1f} s (unplugged, frozen or without power); "
                    "check its cable. It is looked for again by itself."
                )
            self._stopping.wait(_FALSE_READ_PAUSE_S)

    def _keep(self, shot: Shot) -> None:
        with self._changed:
            self._lost = None
            self._frames.append(CameraFrame(shot.frame, shot.time_s, self._numbers.next(shot.time_s)))
            self._changed.notify_all()

    def _say_lost(self, sentence: str) -> None:
        with self._changed:
            self._lost = sentence
            self._changed.notify_all()

    def _open_again(self) -> None:
        self._source.close()
        for attempt in range(1_000_000):
            if self._stopping.wait(_BACK_OFF_S[min(attempt, len(_BACK_OFF_S) - 1)]):
                return
            try:
                self._facts = self._source.open()
            except DeviceError as err:
                self._say_lost(str(err))
            else:
                return


class FrameNumbers:
    """Running numbers from stamps: where a frame was lost on the way, a number is left out."""

    def __init__(self, frames_per_s: float) -> None:
        self._intervals_s: deque[float] = deque([1.0 / frames_per_s], maxlen=_INTERVALS)
        self._number, self._time_s = -1, 0.0

    def next(self, time_s: float) -> int:
        """The number of the frame with this stamp; the usual interval is learnt from the stamps."""
        if self._number >= 0:
            interval_s = max(time_s - self._time_s, 0.0)
            self._number += max(round(interval_s / float(np.median(self._intervals_s))), 1) - 1
            self._intervals_s.append(max(interval_s, 1e-4))
        self._number, self._time_s = self._number + 1, time_s
        return self._number

    @property
    def frames_per_s(self) -> float:
        """As measured."""
        return 1.0 / float(np.median(self._intervals_s))
