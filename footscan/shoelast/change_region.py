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


def find_free(chart: Chart, asking_mm: Floats, transition_mm: float) -> Bools:
    """Coefficients that move nothing beyond the transition length.

    Args:
        chart: Of the last.
        asking_mm: `(n, 3)` places of the upper that ask for a change.
        transition_mm: How far the change may reach along the skin, measured straight.

    Returns:
        `(n_v, n_u)`, the feather edge and the cone edge left out.
    """
    tube = chart.tube
    if len(asking_mm) == 0:
        return np.zeros(chart.shape, dtype=np.bool_)
    u = (np.arange(_STEPS * tube.count_u) + 0.5) / (_STEPS * tube.count_u)
    breaks = tube.knots_v[DEGREE:-DEGREE]
    inner = (np.arange(_STEPS) + 0.5) / _STEPS
    v = (breaks[:-1, None] + np.diff(breaks)[:, None] * inner).ravel()
    places = tube.grid(u, v)
    gap = PointTree(asking_mm).nearest(places.reshape(-1, 3), 1, transition_mm)[0][:, 0].reshape(len(v), len(u))
    around, up = bases_at(u, tube.knots_u), bases_at(v, tube.knots_v)
    moves = np.zeros(chart.shape)
    _most_outside(around.first, around.value, up.first, up.value, np.isfinite(gap), moves)
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
