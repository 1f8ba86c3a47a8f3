"""What the camera panel shows of a frame: grey, binary, stripe, overlay; brightness counted, a row drawn."""

from dataclasses import dataclass
from typing import Literal, get_args

import cv2
import numpy as np
import numpy.typing as npt

from footscan.coordinates import Floats, Frame
from footscan.scanning.stripe import StripeFinder, automatic_threshold, brightness_histogram

Kind = Literal["Grey", "Binary", "Stripe", "Overlay"]
Rgb = npt.NDArray[np.uint8]
KINDS: tuple[Kind, ...] = get_args(Kind)
_STRIPE_RGB = np.array([255, 70, 40], np.uint8)
_MARK_RGB = (60, 160, 255)
_WIDEST_PX = 800


@dataclass(frozen=True)
class LivePicture:
    """A picture to be shown.

    Attributes:
        rgb: `(rows, columns, 3)`.
        automatic: The threshold this frame alone would get.
        points: Stripe points in it.
    """

    rgb: Rgb
    automatic: int
    points: int


def draw_live(frame: Frame, kind: Kind, threshold: int | None, finder: StripeFinder, row: int | None) -> LivePicture:
    """Draw a frame.

    Args:
        frame: Upright, grey.
        kind: What to show.
        threshold: None for the automatic one of this frame.
        finder: With buffers of this thread.
        row: A row to be marked, if any.
    """
    automatic = automatic_threshold(frame)
    used = automatic if threshold is None else threshold
    stripe = finder.find(frame, used)
    grey = _ground(frame, kind, used)
    rgb = cv2.cvtColor(grey, cv2.COLOR_GRAY2RGB)
    if kind in ("Stripe", "Overlay"):
        _dot(rgb, stripe.uv)
    if row is not None:
        cv2.line(rgb, (0, row), (frame.shape[1] - 1, row), _MARK_RGB, 1)
    return LivePicture(_fitting(rgb.astype(np.uint8)), automatic, len(stripe))


def _ground(frame: Frame, kind: Kind, threshold: int) -> Frame:
    if kind == "Binary":
        return np.where(frame > threshold, 255, 0).astype(np.uint8)
    return np.zeros_like(frame) if kind == "Stripe" else frame


def _dot(rgb: cv2.typing.MatLike, uv: Floats) -> None:
    columns, rows = np.rint(uv).astype(np.int64).T
    inside = (columns >= 0) & (columns < rgb.shape[1]) & (rows >= 0) & (rows < rgb.shape[0])
    rgb[rows[inside], columns[inside]] = _STRIPE_RGB


def _fitting(rgb: Rgb) -> Rgb:
    """A large camera's picture as small as the panel shows it anyway."""
    times = rgb.shape[1] / _WIDEST_PX
    if times <= 1.0:
        return rgb
    size = (_WIDEST_PX, round(rgb.shape[0] / times))
    return cv2.resize(rgb, size, interpolation=cv2.INTER_AREA).astype(np.uint8)


def brightness_curve(frame: Frame) -> tuple[Floats, Floats]:
    """Grey values `(128,)` and log10 of one plus how many pixels have them."""
    counts = brightness_histogram(frame).reshape(-1, 2).sum(axis=1)
    return np.arange(0.0, 256.0, 2.0), np.log10(1.0 + counts)


def row_curve(frame: Frame, row: int) -> tuple[Floats, Floats]:
    """Columns and grey values along a row."""
    return np.arange(frame.shape[1], dtype=np.float64), frame[row].astype(np.float64)
