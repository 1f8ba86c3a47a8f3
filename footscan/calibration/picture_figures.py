"""What pictures say about focus, exposure and the width of the laser line, before anything is calibrated."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial import KDTree

from footscan.coordinates import Floats, Frame

_REACH_PX, _STEP_PX = 9.0, 0.25
_NEIGHBOURS = 9
_EDGE_REACH_PX = 4.0
_LEAST_CONTRAST = 15.0
SATURATED = 254


@dataclass(frozen=True)
class StripeFigures:
    """The laser line at some places: `(n,)` full width at half of the peak (px, NaN where unclear) and peak grey."""

    width_px: Floats
    peak_grey: Floats


def stripe_figures(stripe_only: Frame, uv: Floats) -> StripeFigures:
    """Width and brightness of a stripe at places `(n, 2)` of a frame from which the unlit one is subtracted."""
    if len(uv) < _NEIGHBOURS:
        return StripeFigures(np.full(len(uv), np.nan), np.full(len(uv), np.nan))
    offset = np.arange(-_REACH_PX, _REACH_PX + _STEP_PX, _STEP_PX)
    profile = _profiles(stripe_only, uv, _across(uv), offset)
    middle = profile[:, len(offset) // 2 - 4 : len(offset) // 2 + 5].max(axis=1)
    base = np.median(np.column_stack([profile[:, :6], profile[:, -6:]]), axis=1)
    half = 0.5 * (middle + base)
    width = _STEP_PX * _run_about_middle(profile > half[:, None])
    clear = (middle - base > _LEAST_CONTRAST) & (width < _REACH_PX)
    return StripeFigures(np.where(clear, width, np.nan), middle)


def _run_about_middle(above: np.ndarray) -> Floats:
    """Length `(n,)` of the unbroken run of true values around the middle column."""
    middle = above.shape[1] // 2
    right = np.cumprod(above[:, middle:], axis=1).sum(axis=1)
    left = np.cumprod(above[:, middle::-1], axis=1).sum(axis=1)
    return np.maximum(right + left - 1, 0).astype(np.float64)


def _across(uv: Floats) -> Floats:
    """Unit vectors `(n, 2)` across the line on which each place lies with its neighbours."""
    near = uv[KDTree(uv).query(uv, k=_NEIGHBOURS)[1]]
    off = near - near.mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", off, off))
    return np.asarray(vectors[:, :, 0])


def _profiles(frame: Frame, uv: Floats, direction: Floats, offset: Floats) -> Floats:
    """Grey values `(n, k)` along lines through places `(n, 2)`."""
    place = uv[:, None, :] + offset[None, :, None] * direction[:, None, :]
    u, v = (np.ascontiguousarray(place[:, :, axis], dtype=np.float32) for axis in (0, 1))
    return np.asarray(cv2.remap(frame, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), dtype=np.float64)


@dataclass(frozen=True)
class BoardFigures:
    """The board in one unlit frame.

    Attributes:
        blur_px: Gaussian sigma of its edges; NaN where no clear edge was seen.
        white_grey: Of its white squares.
        black_grey: Of its black squares.
    """

    blur_px: float
    white_grey: float
    black_grey: float


def board_figures(frame: Frame, uv: Floats, number: np.ndarray, columns: int) -> BoardFigures:
    """Focus and exposure from found corners.

    Args:
        frame: Upright, unlit.
        uv: `(n, 2)` corner places.
        number: `(n,)` their numbers, row by row.
        columns: Corners in a row.
    """
    place = dict(zip(number.tolist(), uv, strict=True))
    pairs = [
        (place[k], place[k + step])
        for k in place
        for step in (1, columns)
        if k + step in place and (step != 1 or k % columns != columns - 1)
    ]
    if not pairs:
        return BoardFigures(float("nan"), float("nan"), float("nan"))
    one, two = (np.stack(side) for side in zip(*pairs, strict=True))
    along = two - one
    across = np.stack([-along[:, 1], along[:, 0]], axis=-1) / np.linalg.norm(along, axis=1, keepdims=True)
    offset = np.arange(-_EDGE_REACH_PX, _EDGE_REACH_PX + _STEP_PX, _STEP_PX)
    profile = _profiles(frame, 0.5 * (one + two), across, offset)
    high, low = profile.max(axis=1), profile.min(axis=1)
    slope = np.abs(np.diff(profile, axis=1)).max(axis=1) / _STEP_PX
    clear = high - low > _LEAST_CONTRAST
    # a step blurred by a Gaussian is steepest in its middle: height / (sigma sqrt(2 pi))
    blur = (high - low)[clear] / (np.maximum(slope[clear], 1e-6) * np.sqrt(2.0 * np.pi))
    return BoardFigures(
        float(np.median(blur)) if len(blur) else float("nan"), float(np.median(high)), float(np.median(low))
    )
