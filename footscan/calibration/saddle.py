"""Sub-pixel places of chessboard corners: the saddle of a quadratic fitted around each.

Four squares around a corner look the same after half a turn, whatever light, blur, truncated blacks or foreshortening,
so the saddle is unbiased; a small window keeps the markers inside the white squares out of it.
"""

import cv2
import numpy as np

from footscan.coordinates import Bools, Floats, Frame

_SMOOTHING_PX = 1.2
_REACH = 5
_WEIGHT_SIGMA_PX = 1.5
_ROUNDS = 8
_FARTHEST_PX = 1.5
_SETTLED_PX = 0.02


def refine_corners(frame: Frame, uv: Floats) -> tuple[Floats, Bools]:
    """Refine `(n, 2)` corner places of an upright frame.

    Returns:
        The refined places `(n, 2)`, and `(n,)` whether each is a clear saddle near where it was looked for.
    """
    smooth = cv2.GaussianBlur(frame.astype(np.float64), (0, 0), _SMOOTHING_PX)
    place, good = uv.copy(), np.ones(len(uv), dtype=bool)
    step = np.zeros_like(uv)
    for _ in range(_ROUNDS):
        moved, saddle = _to_saddle(np.asarray(smooth, dtype=np.float64), place)
        good &= saddle
        step = np.where(good[:, None], moved - place, 0.0)
        place = place + step
        good &= np.hypot(*(place - uv).T) < _FARTHEST_PX
        if np.all(np.abs(step) < 1e-4):
            break
    return place, good & (np.hypot(*step.T) < _SETTLED_PX)


def _to_saddle(smooth: Floats, place: Floats) -> tuple[Floats, Bools]:
    """The stationary point of a quadratic around each place, and whether it is a saddle inside the window."""
    height, width = smooth.shape
    middle = np.round(place).astype(np.int64)
    inside = np.all((middle >= _REACH) & (middle < np.array([width, height]) - _REACH), axis=1)
    middle = np.where(inside[:, None], middle, _REACH)
    offset = np.arange(-_REACH, _REACH + 1)
    dv, du = (axis.ravel() for axis in np.meshgrid(offset, offset, indexing="ij"))
    grey = smooth[middle[:, 1, None] + dv, middle[:, 0, None] + du]
    off = place - middle
    distance2 = (du - off[:, 0, None]) ** 2 + (dv - off[:, 1, None]) ** 2
    weight = np.exp(-distance2 / (2.0 * _WEIGHT_SIGMA_PX**2))
    terms = np.stack([du * du, du * dv, dv * dv, du, dv, np.ones_like(du)], axis=-1).astype(np.float64)
    matrix = np.einsum("nk,ki,kj->nij", weight, terms, terms)
    a, b, c, d, e, _ = np.linalg.solve(matrix, np.einsum("nk,nk,ki->ni", weight, grey, terms)[..., None])[..., 0].T
    determinant = 4.0 * a * c - b * b
    saddle = inside & (determinant < 0.0)
    safe = np.where(saddle, determinant, -1.0)
    shift = np.stack([b * e - 2.0 * c * d, b * d - 2.0 * a * e], axis=-1) / safe[:, None]
    saddle &= np.max(np.abs(shift), axis=1) < _REACH
    return np.where(saddle[:, None], middle + shift, place), saddle
