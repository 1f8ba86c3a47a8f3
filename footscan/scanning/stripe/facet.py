"""Weighted quadratic facets: the kernels that turn a 7x7 neighbourhood into value, slope and curvature.

Haralick's facet model with Gaussian weights: fitting a + b x + c y + d x2/2 + e xy + f y2/2 by weighted least squares
gives each coefficient as a fixed kernel. In the middle of a frame the kernels are products of one-dimensional ones;
at the border, where part of the neighbourhood is missing, they are solved for the part that exists.
"""

from functools import lru_cache

import numpy as np

from footscan.coordinates import Floats, Floats32

RADIUS_PX = 3
WIDTH_PX = 2 * RADIUS_PX + 1


def line_kernels(sigma_px: float) -> Floats32:
    """`(3, 7)` kernels of value, slope and curvature along one line."""
    x = np.arange(-RADIUS_PX, RADIUS_PX + 1.0)
    weight = np.exp(-(x**2) / (2.0 * sigma_px**2))
    weight /= weight.sum()
    second, fourth = (x**2 * weight).sum(), (x**4 * weight).sum()
    slope = x * weight / second
    curvature = 2.0 * (x**2 - second) * weight / (fourth - second**2)
    return np.stack([weight, slope, curvature]).astype(np.float32)


def _cut_kernel(sigma_px: float, missing_u: int, missing_v: int) -> Floats:
    """`(6, 7, 7)`: value, b (u), c (v), d (uu), e (uv), f (vv); `missing` columns and rows count from the low side,
    negative ones from the high side."""
    v, u = np.mgrid[-RADIUS_PX : RADIUS_PX + 1, -RADIUS_PX : RADIUS_PX + 1].astype(float)
    weight = np.exp(-(u**2 + v**2) / (2.0 * sigma_px**2))
    for axis, missing in ((u, missing_u), (v, missing_v)):
        weight[axis < -RADIUS_PX + missing] = 0.0
        weight[axis > RADIUS_PX + missing] = 0.0
    terms = np.stack([np.ones_like(u), u, v, u**2 / 2.0, u * v, v**2 / 2.0]).reshape(6, -1)
    weighted = terms * weight.ravel()
    return np.linalg.solve(weighted @ terms.T, weighted).reshape(6, WIDTH_PX, WIDTH_PX)


@lru_cache(maxsize=8)
def border_kernels(sigma_px: float) -> Floats32:
    """`(7, 7, 6, 7, 7)`: kernels by missing columns and rows, each shifted by `RADIUS_PX` (3, 3 is the full one)."""
    span = range(-RADIUS_PX, RADIUS_PX + 1)
    return np.array([[_cut_kernel(sigma_px, mu, mv) for mv in span] for mu in span], dtype=np.float32)
