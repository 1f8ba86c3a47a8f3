"""A cubic tensor-product spline tube: periodic around (u), clamped from the sole up to the leg (v).

Columns of the control net go round, rows go up. The parameters run from 0 to 1. Knots around are uniform, knots up may
be spaced freely.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from footscan.coordinates import Floats

DEGREE = 3


@dataclass(frozen=True)
class SplineTube:
    """A cubic B-spline surface (NURBS with unit weights), periodic in u.

    Attributes:
        net_mm: `(n_v, n_u, 3)` control points; column 0 follows column n_u - 1.
        knots_v: `(n_v + 4,)` clamped knots from 0 to 1.
    """

    net_mm: Floats
    knots_v: Floats

    @property
    def count_u(self) -> int:
        """Control points around."""
        return int(self.net_mm.shape[1])

    @property
    def knots_u(self) -> Floats:
        """`(n_u + 7,)` uniform knots of the periodic direction; 0 and 1 are the fourth from either end."""
        return periodic_knots(self.count_u)

    def grid(self, u: Floats, v: Floats, order_u: int = 0, order_v: int = 0) -> Floats:
        """Evaluate on a grid, separably.

        Args:
            u: `(m,)` in 0..1 (periodic).
            v: `(k,)` in 0..1.
            order_u: Derivative in u.
            order_v: Derivative in v.

        Returns:
            `(k, m, 3)` millimetres (per unit of u or v for derivatives).
        """
        wrapped = np.concatenate([self.net_mm, self.net_mm[:, :DEGREE]], axis=1)
        around = BSpline(self.knots_u, wrapped, DEGREE, axis=1)(np.mod(u, 1.0), nu=order_u)
        return BSpline(self.knots_v, around, DEGREE, axis=0)(v, nu=order_v)


def mirrored_tube(tube: SplineTube) -> SplineTube:
    """The tube mirrored in the plane y = 0; u runs the other way, so that the outside stays outside."""
    back = np.mod(2 - np.arange(tube.count_u), tube.count_u)
    return SplineTube(np.ascontiguousarray(tube.net_mm[:, back] * np.array([1.0, -1.0, 1.0])), tube.knots_v)


def periodic_knots(count: int) -> Floats:
    """Uniform knots `(count + 7,)` of a periodic cubic spline with that many control points on 0..1."""
    return np.arange(-DEGREE, count + DEGREE + 1) / count


def clamped_knots(breaks: Floats) -> Floats:
    """Knots of a clamped cubic spline with the given increasing `(k,)` breaks; it has k + 2 control points."""
    return np.concatenate([np.repeat(breaks[0], DEGREE), breaks, np.repeat(breaks[-1], DEGREE)])


def graded_breaks(density: Floats, count: int) -> Floats:
    """Breaks `(count + 1,)` on 0..1 whose spacing is inversely proportional to a density.

    Args:
        density: `(m,)` positive samples of the wanted number of breaks per unit, evenly spread over 0..1.
        count: Number of spans.
    """
    total = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    return np.interp(np.linspace(0.0, total[-1], count + 1), total, np.linspace(0.0, 1.0, len(density)))


def greville(knots: Floats) -> Floats:
    """Greville abscissae: the parameters at which control points act most."""
    return (knots[1:-3] + knots[2:-2] + knots[3:-1]) / 3.0
