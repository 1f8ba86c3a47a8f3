"""A video file or a folder of pictures that behaves like a camera: it runs by itself, at the rig's frame rate."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from footscan.config.device_models import FileCameraModel
from footscan.devices.grabbing import GrabbingCamera, Shot
from footscan.devices.pictures import View, frame_from_picture
from footscan.devices.values import CameraFacts
from footscan.errors import CameraLostError, WrongDeviceError

_SUFFIXES = {".png", ".tif", ".tiff", ".bmp", ".pgm", ".jpg", ".jpeg"}
Pictures = Iterator["np.ndarray[Any, Any]"]


def open_file_camera(model: FileCameraModel, view: View) -> GrabbingCamera:
    """Open a file or folder; it plays after `start`.

    Raises:
        CameraLostError: It is not there, or no pictures are in it.
        WrongDeviceError: Its pictures have another size.
    """
    return GrabbingCamera(FileSource(model, view))


class FileSource:
    """Plays the pictures one interval apart; the first is on time when playing begins."""

    def __init__(self, model: FileCameraModel, view: View, sleep: Callable[[float], None] = time.sleep) -> None:
        self._model, self._view, self._sleep = model, view, sleep
        self._pictures: Pictures | None = None
        self._began_s: float | None = None
        self._shown = 0
        self._ended = False

    def open(self) -> CameraFacts:
        """Look at the first picture."""
        if self._ended:
            raise self._end()
        first = next(self._fresh(), None)
        if first is None:
            raise CameraLostError(f"{self._model.path} holds no pictures; give a video file or a folder of pictures.")
        self._frame(first)
        self._pictures, self._began_s, self._shown = self._fresh(), None, 0
        view = self._view
        return CameraFacts(
            self._model.path, view.width_px, view.height_px, view.frames_per_s, self._model.exposure_s, ("file",)
        )

    def next_shot(self) -> Shot | None:
        """The next picture, at its time; those that are late already are not shown."""
        began_s = self._began_s = time.monotonic() if self._began_s is None else self._began_s
        late = int((time.monotonic() - began_s) * self._view.frames_per_s)
        picture = self._step()
        while self._shown <= late:
            picture = self._step()
        due_s = began_s + (self._shown - 1) / self._view.frames_per_s
        self._sleep(max(due_s - time.monotonic(), 0.0))
        return Shot(self._frame(picture), due_s)

    def close(self) -> None:
        """Close the file."""
        self._pictures = None

    def _step(self) -> "np.ndarray[Any, Any]":
        self._shown += 1
        if self._pictures is None:
            raise CameraLostError(f"{self._model.path} was closed; open it again.")
        picture = next(self._pictures, None)
        if picture is None and self._model.repeat:
            self._pictures = self._fresh()
            picture = next(self._pictures, None)
        if picture is None:
            self._ended = True
            raise self._end()
        return picture

    def _end(self) -> CameraLostError:
        return CameraLostError(f"{self._model.path} has ended; let it repeat, or give a longer one.")

    def _frame(self, picture: "np.ndarray[Any, Any]") -> "np.ndarray[Any, np.dtype[np.uint8]]":
        try:
            return frame_from_picture(picture, self._model, self._view)
        except ValueError as err:
            raise WrongDeviceError(f"{self._model.path}: {err}; give pictures of that size.") from None

    def _fresh(self) -> Pictures:
        path = Path(self._model.path)
        return _of_folder(path) if path.is_dir() else _of_video(path)


def _of_folder(folder: Path) -> Pictures:
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() in _SUFFIXES:
            picture = cv2.imread(str(path), cv2.IMREAD_ANYCOLOR)
            if picture is None:
                raise CameraLostError(f"{path} is no picture that can be read; take it out of the folder.")
            yield picture


def _of_video(path: Path) -> Pictures:
    if not path.is_file():
        raise CameraLostError(f"{path} does not exist; give a video file or a folder of pictures.")
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    try:
        while True:
            good, picture = capture.read()
            if not good:
                return
            yield picture
    finally:
        capture.release()
