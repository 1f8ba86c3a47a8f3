"""Control nets through given points: a tube through level curves, and a convex bottom between the feather edges."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.interpolate import BSpline, CubicSpline

from footscan.coordinates import Floats
from footscan.foot.nurbs import DEGREE, SplineTube, clamped_knots, greville, periodic_knots
from footscan.shoelast.patches import ChordDisc, half_knots, ruled_disc

BOTTOM_BREAKS = 13
BOTTOM_POWER = 1.7
"""How a bottom falls from its edges to its middle: 2 a parabola; less leaves the edges flatter and sharper."""


def interpolate_tube(xyz_shoelast: Floats, knots_v: Floats) -> SplineTube:
    """The tube through level curves.

    Args:
        xyz_shoelast: `(n_v, n_u, 3)`: column k at u = k / n_u, row k at the k-th Greville abscissa of `knots_v`.
        knots_v: `(n_v + 4,)` clamped.
    """
    around = np.matmul(_inverse_round(xyz_shoelast.shape[1]), xyz_shoelast)
    up = BSpline.design_matrix(greville(knots_v), knots_v, DEGREE).toarray()
    net = np.linalg.solve(up, around.reshape(len(up), -1)).reshape(around.shape)
    return SplineTube(net, knots_v)


@lru_cache(maxsize=4)
def _inverse_round(count: int) -> Floats:
    """`(count, count)`: control points of a periodic cubic spline from its values at u = k / count."""
    wrapped = np.concatenate([np.eye(count), np.eye(count)[:DEGREE]])
    values = BSpline(periodic_knots(count), wrapped, DEGREE)(np.arange(count) / count)
    inverse = np.linalg.inv(values)
    inverse.setflags(write=False)
    return inverse


def bottom_between(row_mm: Floats, depth_mm: Floats) -> ChordDisc:
    """A convex bottom.

    Args:
        row_mm: `(n_u, 3)` periodic control points of the feather edge.
        depth_mm: `(n_u,)` at u = k / n_u, how far the middle lies below the straight chord (same on both halves).
    """
    breaks = np.linspace(0.0, 1.0, BOTTOM_BREAKS)
    disc = ruled_disc(row_mm, breaks)
    count = len(row_mm)
    half = CubicSpline(np.linspace(0.0, 1.0, count // 2 + 1), depth_mm[: count // 2 + 1], bc_type="clamped")
    depth = _controls(half, half_knots(count))
    depth[[0, -1]] = 0.0
    bulge = _controls(lambda t: 1.0 - np.abs(2.0 * t - 1.0) ** BOTTOM_POWER, clamped_knots(breaks))
    net = disc.net_mm.copy()
    net[:, :, 2] -= depth[:, None] * bulge
    return ChordDisc(net, disc.knots_s, disc.knots_t)


def _controls(function: Callable[[Floats], Floats], knots: Floats) -> Floats:
    """Control values of the clamped cubic spline through a function at its Greville abscissae."""
    places = greville(knots)
    return np.linalg.solve(BSpline.design_matrix(places, knots, DEGREE).toarray(), function(places))
