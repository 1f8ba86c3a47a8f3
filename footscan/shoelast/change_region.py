"""Where the upper may change: within the transition length of what asks for a change, and nowhere else."""

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import Bools, Floats, Ints
from footscan.foot.nurbs import DEGREE
from footscan.foot.nurbs_fit import bases_at
from footscan.geometry.nearest import PointTree
from footscan.shoelast.chart import Chart

_STEPS = 3
"""Places tested per span and direction."""
_LEFT_OVER = 6e-4
"""A coefficient that moves a place outside by less than this share of itself may change."""


class ChangeRegion:
    """The places at which the coefficients of a chart's net act, made ready once for several questions."""

    def __init__(self, chart: Chart) -> None:
        """Take the chart of a last."""
        tube = chart.tube
        u = (np.arange(_STEPS * tube.count_u) + 0.5) / (_STEPS * tube.count_u)
        breaks = tube.knots_v[DEGREE:-DEGREE]
        inner = (np.arange(_STEPS) + 0.5) / _STEPS
        v = (breaks[:-1, None] + np.diff(breaks)[:, None] * inner).ravel()
        self._places = tube.grid(u, v)
        self._around, self._up = bases_at(u, tube.knots_u), bases_at(v, tube.knots_v)
        self._shape = chart.shape

    def near(self, asking_mm: Floats, reach_mm: float) -> Bools:
        """Mark the places nearer than `reach_mm`, measured straight, to one of `(n, 3)` places that ask for a change.

        Returns:
            `(k, m)`; unions of such marks answer for several groups of places.
        """
        shape = self._places.shape[:2]
        if len(asking_mm) == 0:
            return np.zeros(shape, dtype=np.bool_)
        low, high = asking_mm.min(axis=0) - reach_mm, asking_mm.max(axis=0) + reach_mm
        some = np.flatnonzero(((self._places > low) & (self._places < high)).all(axis=2))
        gap = PointTree(asking_mm).nearest(self._places.reshape(-1, 3)[some], 1, reach_mm)[0][:, 0]
        result = np.zeros(shape, dtype=np.bool_)
        result.reshape(-1)[some] = np.isfinite(gap)
        return result

    def free(self, near: Bools) -> Bools:
        """Coefficients `(n_v, n_u)` that move nothing outside the marked places; feather and cone edge left out."""
        moves = np.zeros(self._shape)
        _most_outside(self._around.first, self._around.value, self._up.first, self._up.value, near, moves)
        free = moves < _LEFT_OVER
        free[0] = free[-1] = False
        return free


@compiled
def _most_outside(first_u: Ints, basis_u: Floats, first_v: Ints, basis_v: Floats, inside: Bools, moves: Floats) -> None:
    """The largest share of every coefficient that arrives at a place outside, `(n_v, n_u)`."""
    for k in range(len(first_v)):
        for m in range(len(first_u)):
            if inside[k, m]:
                continue
            for i in range(4):
                for j in range(4):
                    row, column = first_v[k] + j, (first_u[m] + i) % moves.shape[1]
                    moves[row, column] = max(moves[row, column], basis_u[m, i] * basis_v[k, j])
