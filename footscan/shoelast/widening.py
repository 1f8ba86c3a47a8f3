"""Overhang over the feather edge: within a limit a side stands out above it, beyond it the bottom is widened fairly."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from footscan.coordinates import Floats
from footscan.foot.nurbs_fit import evaluate_at
from footscan.foot.sole_bend import smooth_step
from footscan.geometry.nearest import PointTree
from footscan.shoelast.chart import Chart
from footscan.shoelast.need import Need
from footscan.shoelast.obstacle import BACK_COLUMNS, Rows, smooth_line

STEEPEST_OVERHANG = 1.0
"""An overhang may be at most this many times as wide as it lies high above the feather edge."""
_LEAN = float(np.tan(np.radians(60.0)))
"""No wall leans out by more than 60 degrees from upright, unless it did before: nothing rolls under."""
_UPPER_ROWS, _EDGE_STEPS = 4, 1440
FAIR_MM = 35.0
"""A widening of the bottom may run out over this length beyond what asks for it."""
_WIDENED_MM, _CLOSE_MM = 0.02, 18.0
BACK_FADE_MM = 25.0
"""The back is held: a widening fades out towards it over this length, and an overhang beside it stays one."""


@dataclass(frozen=True)
class Widening:
    """How far the feather edge moves outwards.

    Attributes:
        edge: `(n_u,)` spline coefficients (mm) along its level outward direction.
        places: `(k, 3)` of the edge that move.
    """

    edge: Floats
    places: Floats

    @property
    def most_mm(self) -> float:
        """The largest of them."""
        return float(self.edge.max())


def find_widening(chart: Chart, need: Need, most_overhang_mm: float) -> Widening:
    """The smoothest widening of the bottom that leaves no overhang beyond the limit.

    Args:
        chart: Of the last.
        need: What the foot asks.
        most_overhang_mm: Limit of the profile.
    """
    asking = need.known & (need.move_mm > 0.0)
    wanted = np.zeros(chart.shape[1])
    if asking.any():
        u, v, move = need.u[asking], need.v[asking], need.move_mm[asking]
        here = evaluate_at(chart.tube, u, v)
        beside = _nearest_on_edge(chart, here.xyz_mm)  # parameter lines may lean: not the edge at the same u
        edge = evaluate_at(chart.tube, beside, np.zeros(len(u)))
        outward = evaluate_at(chart.direction, beside, np.zeros(len(u))).xyz_mm
        way = evaluate_at(chart.direction, u, v).xyz_mm
        own = ((here.xyz_mm - edge.xyz_mm) * outward).sum(axis=1)
        height = np.maximum((here.xyz_mm - edge.xyz_mm)[:, 2], 0.0)
        allowed = np.maximum(own, np.minimum(most_overhang_mm, STEEPEST_OVERHANG * height))
        beyond = own + move * (way * outward).sum(axis=1) - allowed
        column = np.mod(np.round(beside * chart.shape[1]).astype(np.int64) + 1, chart.shape[1])
        np.maximum.at(wanted, column, beyond)
    wanted = np.maximum(wanted, 0.0)
    if not wanted.any():
        return Widening(wanted, np.zeros((0, 3)))
    row = chart.tube.net_mm[0]
    spacing = np.linalg.norm(np.roll(row, -1, axis=0) - np.roll(row, 1, axis=0), axis=1) / 2.0
    from_back = np.linalg.norm(row - row[BACK_COLUMNS[1]], axis=1)
    wanted = wanted * smooth_step(from_back / BACK_FADE_MM)
    asking = np.flatnonzero(wanted > 0.0)
    gap = PointTree(np.ascontiguousarray(row[asking])).nearest(row, 1)[0][:, 0]
    free = gap < FAIR_MM
    free[list(BACK_COLUMNS)] = False
    wanted = np.where(free, wanted, 0.0)
    edge = smooth_line(wanted, free, spacing, _CLOSE_MM)
    return Widening(edge, row[edge > _WIDENED_MM])


def _nearest_on_edge(chart: Chart, xyz: Floats) -> Floats:
    """Parameters `(n,)` of the places of the feather edge that are nearest from above."""
    u = np.arange(_EDGE_STEPS, dtype=np.float64) / _EDGE_STEPS
    edge = np.ascontiguousarray(chart.tube.grid(u, np.zeros(1))[0][:, :2])
    return u[PointTree(edge).nearest(np.ascontiguousarray(xyz[:, :2]), 1)[1][:, 0]]


def no_rolling_under(chart: Chart) -> Rows:
    """Conditions on the lowest rows of control points: between any two, no lean beyond 60 degrees or the last's own."""
    rows, columns = chart.shape
    outward = chart.direction.net_mm[0]
    matrix, right = [], []
    for upper in range(1, min(_UPPER_ROWS, rows - 1)):
        step = chart.tube.net_mm[upper] - chart.tube.net_mm[upper - 1]
        out, up = (step * outward).sum(axis=1), step[:, 2]
        lean = np.maximum(_LEAN, np.where(up > 0.1, out / np.maximum(up, 0.1), 20.0))
        for_one = [
            (chart.direction.net_mm[k] * outward).sum(axis=1) - lean * chart.direction.net_mm[k, :, 2]
            for k in (upper, upper - 1)
        ]
        at = np.arange(columns)
        part = sparse.csr_matrix(
            (
                np.concatenate([-for_one[0], for_one[1]]),
                (np.tile(at, 2), np.concatenate([upper * columns + at, (upper - 1) * columns + at])),
            ),
            shape=(columns, rows * columns),
        )
        matrix.append(part)
        right.append(out - lean * up)
    return Rows(sparse.vstack(matrix, format="csr"), np.concatenate(right))
