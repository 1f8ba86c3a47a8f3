"""An emulated `cv2.VideoCapture` on a V4L2 device with the quirks of OpenCV's backend, driven by a function of time."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from footscan.coordinates import Frame

FrameAt = Callable[[float], Frame]
"""The picture exposed at a moment of the monotonic clock, `(h, w)` uint8, as the sensor is mounted; empty: none."""

SELECT_TIMEOUT_S = 1.0
_GREY = sum(ord(letter) << 8 * place for place, letter in enumerate("GREY"))
_YUYV = sum(ord(letter) << 8 * place for place, letter in enumerate("YUYV"))


@dataclass(frozen=True)
class Abilities:
    """What the emulated camera can do.

    Attributes:
        sizes: Widths and heights; another size becomes the nearest.
        rates: Frames per second; another rate becomes the nearest.
        fourccs: Pixel formats by number.
        manual_exposure: It has the control.
        needs_automatic_first: "Manual" is taken only after "automatic".
        monotonic: It stamps on the computer's monotonic clock; otherwise on one of its own.
    """

    sizes: tuple[tuple[int, int], ...]
    rates: tuple[float, ...] = (25.0, 30.0)
    fourccs: tuple[int, ...] = (_GREY, _YUYV)
    manual_exposure: bool = True
    needs_automatic_first: bool = False
    monotonic: bool = True


class EmulatedCameraPlug:
    """A camera on its cable. `open` is what the driver calls; it can be pulled, frozen and plugged in again."""

    def __init__(self, frame_at: FrameAt, abilities: Abilities) -> None:
        self.frame_at, self.abilities = frame_at, abilities
        self.plugged = threading.Event()
        self.plugged.set()
        self.frozen = threading.Event()
        self.opened = 0

    def open(self, path: str) -> "EmulatedCapture":
        """Open the device."""
        self.opened += 1
        return EmulatedCapture(self)

    def unplug(self) -> None:
        """Pull the cable."""
        self.plugged.clear()

    def plug(self) -> None:
        """Plug it in again."""
        self.plugged.set()


class EmulatedCapture:
    """One opened device. An unplugged one still says that it is open, and reads fail at once."""

    def __init__(self, plug: EmulatedCameraPlug) -> None:
        self._plug, self._able = plug, plug.abilities
        self._opened = plug.plugged.is_set()
        width, height = self._able.sizes[0]
        self._values: dict[int, float] = {
            cv2.CAP_PROP_FRAME_WIDTH: width,
            cv2.CAP_PROP_FRAME_HEIGHT: height,
            cv2.CAP_PROP_FPS: min(self._able.rates, key=lambda rate: abs(rate - 30.0)),
            cv2.CAP_PROP_FOURCC: self._able.fourccs[0],
            cv2.CAP_PROP_CONVERT_RGB: 1,
            cv2.CAP_PROP_AUTO_EXPOSURE: 3 if self._able.manual_exposure else -1,
            cv2.CAP_PROP_EXPOSURE: 157 if self._able.manual_exposure else -1,
            cv2.CAP_PROP_GAIN: 0,
        }
        self._asked_width: float | None = None
        self._exposed_s = time.monotonic()
        self._automatic_was_set = not self._able.needs_automatic_first

    def isOpened(self) -> bool:  # noqa: N802
        """Whether opening succeeded; stays True when unplugged."""
        return self._opened

    def set(self, propId: int, value: float) -> bool:  # noqa: N803
        """Set a property, as far as the camera can; width and height apply as a pair."""
        if propId == cv2.CAP_PROP_FRAME_WIDTH:
            self._asked_width = value
            return True
        if propId == cv2.CAP_PROP_FRAME_HEIGHT:
            return self._set_size(self._asked_width or self._values[cv2.CAP_PROP_FRAME_WIDTH], value)
        if propId == cv2.CAP_PROP_FPS:
            self._values[propId] = min(self._able.rates, key=lambda rate: abs(rate - value))
            return True
        return self._set_control(propId, value)

    def get(self, propId: int) -> float:  # noqa: N803
        """A property; -1 if the camera has none."""
        if propId == cv2.CAP_PROP_POS_MSEC:
            return (self._exposed_s + (0.0 if self._able.monotonic else 1.7e9)) * 1000.0
        return self._values.get(propId, -1.0)

    def grab(self) -> bool:
        """Wait for the next frame: at most the select time-out."""
        if not self._plug.plugged.is_set() or not self._opened:
            return False
        due_s = max(self._exposed_s + 1.0 / self._values[cv2.CAP_PROP_FPS], time.monotonic() - 0.1)
        end_s = time.monotonic() + SELECT_TIMEOUT_S
        while time.monotonic() < due_s or self._plug.frozen.is_set():
            if not self._plug.plugged.is_set() or time.monotonic() > end_s:
                return False
            time.sleep(min(0.01, max(due_s - time.monotonic(), 0.001)))
        self._exposed_s = due_s
        return True

    def retrieve(self) -> "tuple[bool, np.ndarray[Any, Any] | None]":
        """The grabbed picture as OpenCV gives it: BGR, or a flat row of bytes without conversion."""
        frame = self._plug.frame_at(self._exposed_s)
        if frame.size == 0:
            return False, None
        size = int(self._values[cv2.CAP_PROP_FRAME_WIDTH]), int(self._values[cv2.CAP_PROP_FRAME_HEIGHT])
        if frame.shape[::-1] != size:
            frame = cv2.resize(frame, size)
        if self._values[cv2.CAP_PROP_CONVERT_RGB]:
            return True, cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR)
        if self._values[cv2.CAP_PROP_FOURCC] == _YUYV:
            frame = np.stack([frame, np.full_like(frame, 128)], axis=-1)
        return True, frame.reshape(1, -1)

    def release(self) -> None:
        """Close the device."""
        self._opened = False

    def _set_size(self, width: float, height: float) -> bool:
        nearest = min(self._able.sizes, key=lambda size: abs(size[0] - width) + abs(size[1] - height))
        self._values[cv2.CAP_PROP_FRAME_WIDTH], self._values[cv2.CAP_PROP_FRAME_HEIGHT] = nearest
        return True

    def _set_control(self, prop: int, value: float) -> bool:
        if prop == cv2.CAP_PROP_AUTO_EXPOSURE:
            self._automatic_was_set |= value == 3 and self._values[prop] != 1
            if value == 1 and not self._automatic_was_set:
                return False
        refused = prop not in self._values or self._values[prop] == -1
        if refused or (prop == cv2.CAP_PROP_FOURCC and value not in self._able.fourccs):
            return False
        self._values[prop] = value
        return True
