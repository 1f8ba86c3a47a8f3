"""Cameras and frame grabbers of the Linux kernel through OpenCV (V4L2), every setting read back."""

import contextlib
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np

from footscan.config.device_models import V4l2CameraModel
from footscan.devices.grabbing import GrabbingCamera, Shot
from footscan.devices.pictures import View, frame_from_picture
from footscan.devices.port_trouble import opening_sentence
from footscan.devices.values import CameraFacts
from footscan.errors import CameraLostError, WrongDeviceError

_SELECT_TIMEOUT_S = "1"
_EXPOSURE_UNIT_S = 1e-4
_AUTOMATIC = 3
_SAME_CLOCK_S = 2.0


class Capture(Protocol):
    """The part of `cv2.VideoCapture` that is used."""

    def isOpened(self) -> bool: ...  # noqa: N802, D102
    def set(self, propId: int, value: float) -> bool: ...  # noqa: N803, D102
    def get(self, propId: int) -> float: ...  # noqa: N803, D102
    def grab(self) -> bool: ...  # noqa: D102
    def retrieve(self) -> "tuple[bool, np.ndarray[Any, Any] | None]": ...  # noqa: D102
    def release(self) -> None: ...  # noqa: D102


OpenCapture = Callable[[str], Capture]


def open_capture(path: str) -> Capture:
    """A V4L2 device by path. OpenCV waits for a frame for 10 s unless told otherwise before its first use.

    Its own warnings about devices that do not open are left out: the driver says it in a sentence.
    """
    os.environ.setdefault("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", _SELECT_TIMEOUT_S)
    log = cv2.utils.logging
    level = log.setLogLevel(log.LOG_LEVEL_ERROR)
    try:
        return cv2.VideoCapture(path, cv2.CAP_V4L2)  # pyright: ignore[reportReturnType]
    finally:
        log.setLogLevel(level)


def open_v4l2_camera(model: V4l2CameraModel, view: View, opener: OpenCapture = open_capture) -> GrabbingCamera:
    """Open a camera; it delivers after `start`.

    Raises:
        CameraLostError: It is not there, not permitted, or used by another program.
        WrongDeviceError: It delivers another size.
    """
    return GrabbingCamera(V4l2Source(model, view, opener))


class V4l2Source:
    """One V4L2 device, opened, set up and read; its notes say what it did with every setting."""

    def __init__(self, model: V4l2CameraModel, view: View, opener: OpenCapture) -> None:
        self._model, self._view, self._opener = model, view, opener
        self._capture: Capture | None = None
        self._driver_stamps: bool | None = None

    def open(self) -> CameraFacts:
        """Open and set up."""
        self.close()
        capture = self._opener(self._model.path)
        if not capture.isOpened():
            capture.release()
            raise CameraLostError(_opening_sentence(Path(self._model.path)))
        self._capture, self._driver_stamps = capture, None
        notes = tuple(self._set_up(capture))
        self._refuse_size(capture)
        view = self._view
        exposure_s = self._exposure_s(capture)
        return CameraFacts(self._model.path, view.width_px, view.height_px, view.frames_per_s, exposure_s, notes)

    def next_shot(self) -> Shot | None:
        """The next frame, stamped by the driver where its clock is this computer's monotonic one."""
        if self._capture is None or not self._capture.grab():
            return None
        stamp_s = self._stamp_s(self._capture, time.monotonic())
        good, picture = self._capture.retrieve()
        if not good or picture is None:
            return None
        try:
            return Shot(frame_from_picture(picture, self._model, self._view), stamp_s)
        except ValueError as err:
            raise WrongDeviceError(f"{self._model.path}: {err}; correct [camera] in the rig file.") from None

    def close(self) -> None:
        """Release the device."""
        if self._capture is not None:
            self._capture.release()
            self._capture = None

    def _set_up(self, capture: Capture) -> Iterator[str]:
        """In this order: pixel format, then width and height, which apply only as a pair, then rate and controls."""
        width, height = self._view.delivered(self._model)
        if self._model.input is not None:
            yield from _set(capture, "input", cv2.CAP_PROP_CHANNEL, self._model.input)
        yield from _set(capture, "pixel format", cv2.CAP_PROP_FOURCC, _fourcc(self._model.fourcc))
        yield from _set(capture, "colour conversion", cv2.CAP_PROP_CONVERT_RGB, float(self._model.convert))
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, width)
        yield from _set(capture, "height", cv2.CAP_PROP_FRAME_HEIGHT, height)
        yield from _set(capture, "width", cv2.CAP_PROP_FRAME_WIDTH, width)
        yield from _set(capture, "frames per second", cv2.CAP_PROP_FPS, round(self._view.frames_per_s))
        yield from self._set_exposure(capture)
        if self._model.gain is not None:
            yield from _set(capture, "gain", cv2.CAP_PROP_GAIN, self._model.gain)

    def _set_exposure(self, capture: Capture) -> Iterator[str]:
        """Some drivers take "manual" only after "automatic"."""
        manual = self._model.manual_exposure
        if capture.get(cv2.CAP_PROP_AUTO_EXPOSURE) != manual:
            capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, manual)
        if capture.get(cv2.CAP_PROP_AUTO_EXPOSURE) != manual:
            capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, _AUTOMATIC)
        yield from _set(capture, "manual exposure", cv2.CAP_PROP_AUTO_EXPOSURE, manual)
        units = max(round(self._model.exposure_s / _EXPOSURE_UNIT_S), 1)
        yield from _set(capture, "exposure (0.1 ms)", cv2.CAP_PROP_EXPOSURE, units)

    def _exposure_s(self, capture: Capture) -> float:
        units = capture.get(cv2.CAP_PROP_EXPOSURE)
        return units * _EXPOSURE_UNIT_S if units > 0 else self._model.exposure_s

    def _refuse_size(self, capture: Capture) -> None:
        wanted = self._view.delivered(self._model)
        shown = (round(capture.get(cv2.CAP_PROP_FRAME_WIDTH)), round(capture.get(cv2.CAP_PROP_FRAME_HEIGHT)))
        if shown != wanted:
            self.close()
            raise WrongDeviceError(
                f"{self._model.path} delivers {shown[0]} x {shown[1]} pixels instead of {wanted[0]} x {wanted[1]}; "
                f"`v4l2-ctl -d {self._model.path} --list-formats-ext` shows what it can do, correct [camera] and "
                "[devices.camera] in the rig file."
            )

    def _stamp_s(self, capture: Capture, now_s: float) -> float:
        driver_s = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0
        if self._driver_stamps is None:
            self._driver_stamps = 0.0 <= now_s - driver_s < _SAME_CLOCK_S
        return driver_s if self._driver_stamps else now_s


def _set(capture: Capture, name: str, prop: int, value: float) -> Iterator[str]:
    """Set a property; yields what became of it."""
    taken = False
    with contextlib.suppress(cv2.error):
        taken = bool(capture.set(prop, value))
    shown = capture.get(prop)
    if taken and shown == value:
        yield f"{name}: {_words(prop, value)}"
    else:
        refused = "" if taken else " refused,"
        yield f"{name}: asked for {_words(prop, value)},{refused} reads back {_words(prop, shown)}"


def _fourcc(name: str) -> int:
    return sum(ord(letter) << 8 * place for place, letter in enumerate(name))


def _words(prop: int, value: float) -> str:
    if prop == cv2.CAP_PROP_FOURCC and value > 0:
        return "".join(chr(int(value) >> 8 * place & 0xFF) for place in range(4))
    return f"{value:g}"


def _opening_sentence(path: Path) -> str:
    try:
        os.close(os.open(path, os.O_RDWR | os.O_NONBLOCK))
    except OSError as err:
        return opening_sentence(path, err)
    return f"{path} is no camera, or another program uses it; `v4l2-ctl --list-devices` shows the cameras."
