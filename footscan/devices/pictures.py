"""Delivered pictures become upright grey frames."""

from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np

from footscan.config.device_models import PictureModel
from footscan.coordinates import Frame

Channel = Literal["luminance", "red"]
Field = Literal["both", "top", "bottom"]


@dataclass(frozen=True)
class View:
    """What the rig expects of its camera.

    Attributes:
        width_px: Of a frame, as calibrated.
        height_px: Of a frame, as calibrated; one field of interlaced video has half the rows of the picture.
        frames_per_s: Asked for.
        rotation_deg: Turn of the delivered picture that makes it upright: 0 or 180.
    """

    width_px: int
    height_px: int
    frames_per_s: float
    rotation_deg: int = 0

    def delivered(self, model: PictureModel) -> tuple[int, int]:
        """Width and height of the camera's own picture."""
        return self.width_px, self.height_px * model.rows_per_row


def frame_from_picture(picture: "np.ndarray[Any, Any]", model: PictureModel, view: View) -> Frame:
    """The upright grey frame of a delivered picture.

    Args:
        picture: `(h, w)`, `(h, w, 1)`, `(h, w, 2)` YUYV, `(h, w, 3)` BGR, or the same bytes in one row, as OpenCV hands
            them over without colour conversion.
        model: Which field and channel are kept.
        view: The size to be reached.

    Raises:
        ValueError: Another size.
    """
    width, height = view.delivered(model)
    grey = _channel(_rows(picture, width, height), model.channel)
    grey = one_field(grey, model.field)
    return np.ascontiguousarray(grey[::-1, ::-1] if view.rotation_deg == 180 else grey)


def one_field(grey: Frame, field: Field) -> Frame:
    """Every second row of an interlaced picture `(h, w)`: the rows that were exposed at one moment."""
    return grey if field == "both" else grey[0 if field == "top" else 1 :: 2]


def _rows(picture: "np.ndarray[Any, Any]", width: int, height: int) -> "np.ndarray[Any, Any]":
    if picture.dtype != np.uint8:
        raise ValueError(f"the camera delivers {picture.dtype} pixels, allowed are 8 bits; choose another pixel format")
    channels, rest = divmod(picture.size, width * height)
    shape = picture.shape[:2]
    flat = 1 in shape and picture.ndim < 4
    if rest or not 1 <= channels <= 3 or (not flat and shape != (height, width)):
        raise ValueError(
            f"the camera delivers {picture.shape[1] if picture.ndim > 1 else picture.size} x {picture.shape[0]} "
            f"pixels, expected are {width} x {height}"
        )
    return picture.reshape(height, width, channels)


def _channel(picture: "np.ndarray[Any, Any]", channel: Channel) -> Frame:
    """YUYV carries its luminance first; a grey camera's BGR holds the same value three times."""
    if picture.shape[2] < 3:
        return picture[..., 0]
    if channel == "red":
        return picture[..., 2]
    return cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)  # pyright: ignore[reportReturnType]
