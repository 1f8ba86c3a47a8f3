"""The patches of a last: a tube between feather edge and cone edge, and two discs of chords that close it exactly.

A disc is spanned between the two halves of a periodic curve that is cut at u = 0 (heel) and u = 1/2 (toe): `s` runs
from heel to toe, `t` from the lateral half (t = 0) to the medial half (t = 1). Both halves are the tube's own boundary,
written exactly on clamped knots, so tube and disc share their edge to rounding. At s = 0 and s = 1 a chord is a single
point: the control points there coincide (a degenerate row, as CAD systems accept it).
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from footscan.coordinates import Floats
from footscan.foot.nurbs import DEGREE, SplineTube, clamped_knots, greville

MEDIAL, LATERAL = (0.0, 0.5), (1.0, 0.5)
"""Halves of a periodic boundary, from heel to toe: y is medial, and u grows from the heel along the medial side."""


@dataclass(frozen=True)
class ChordDisc:
    """A bicubic B-spline disc (NURBS with unit weights) between two halves of a closed curve.

    Attributes:
        net_mm: `(n_s, n_t, 3)` control points; row 0 and the last row hold one point each, repeated.
        knots_s: `(n_s + 4,)` clamped knots from 0 to 1.
        knots_t: `(n_t + 4,)` clamped knots from 0 to 1.
    """

    net_mm: Floats
    knots_s: Floats
    knots_t: Floats

    def grid(self, s: Floats, t: Floats, order_s: int = 0, order_t: int = 0) -> Floats:
        """Evaluate on a grid `(m,)` x `(k,)`, separably.

        Returns:
            `(m, k, 3)` millimetres (per unit of s or t for derivatives).
        """
        along = BSpline(self.knots_s, self.net_mm, DEGREE, axis=0)(s, nu=order_s)
        return BSpline(self.knots_t, along, DEGREE, axis=1)(t, nu=order_t)


def half_knots(count_u: int) -> Floats:
    """Clamped knots on 0..1 of half a uniform periodic curve with `count_u` (even) control points."""
    if count_u % 2:
        raise ValueError(f"a periodic boundary is halved at its knots: even number of control points, not {count_u}")
    return clamped_knots(np.linspace(0.0, 1.0, count_u // 2 + 1))


def boundary_half(row_mm: Floats, half: tuple[float, float]) -> Floats:
    """One half of a uniform periodic cubic curve, exactly, on `half_knots`.

    Args:
        row_mm: `(n_u, 3)` periodic control points.
        half: `MEDIAL` or `LATERAL`.

    Returns:
        `(n_u / 2 + 3, 3)` control points from heel (u = 0 or 1) to toe (u = 1/2).
    """
    half_count = len(half_knots(len(row_mm))) - 2 * DEGREE - 1
    if half == LATERAL:  # the other way round: column 1 acts most at the heel
        row_mm = row_mm[np.mod(2 - np.arange(len(row_mm)), len(row_mm))]
    ring = row_mm[np.mod(np.arange(half_count + 3), len(row_mm))]
    start = [(ring[0] + 4.0 * ring[1] + ring[2]) / 6.0, (2.0 * ring[1] + ring[2]) / 3.0]
    end = [(ring[-3] + 2.0 * ring[-2]) / 3.0, (ring[-3] + 4.0 * ring[-2] + ring[-1]) / 6.0]
    return np.vstack([start, ring[2:-2], end])


def ruled_disc(row_mm: Floats, breaks_t: Floats) -> ChordDisc:
    """The disc of straight chords between the halves of a boundary `(n_u, 3)`; `breaks_t` `(k,)` from 0 to 1."""
    lateral, medial = boundary_half(row_mm, LATERAL), boundary_half(row_mm, MEDIAL)
    knots_t = clamped_knots(breaks_t)
    share = greville(knots_t)[None, :, None]
    net = (1.0 - share) * lateral[:, None] + share * medial[:, None]
    return ChordDisc(net, half_knots(len(row_mm)), knots_t)


def lower_edge(tube: SplineTube) -> Floats:
    """Control points `(n_u, 3)` of the edge at v = 0 (the feather edge of an upper)."""
    return tube.net_mm[0]


def upper_edge(tube: SplineTube) -> Floats:
    """Control points `(n_u, 3)` of the edge at v = 1 (the cone edge of an upper)."""
    return tube.net_mm[-1]


def with_boundary(disc: ChordDisc, row_mm: Floats) -> ChordDisc:
    """The disc moved on to another boundary `(n_u, 3)` of the same size; inside it follows linearly in t."""
    before, after = disc.net_mm, ruled_disc(row_mm, disc.knots_t[DEGREE:-DEGREE])
    old_ruled = _between(before[:, 0], before[:, -1], disc.knots_t)
    return ChordDisc(after.net_mm + (before - old_ruled), disc.knots_s, disc.knots_t)


def _between(lateral: Floats, medial: Floats, knots_t: Floats) -> Floats:
    share = greville(knots_t)[None, :, None]
    return (1.0 - share) * lateral[:, None] + share * medial[:, None]
