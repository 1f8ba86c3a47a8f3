"""Where the rows and columns of a skin mesh lie: as far apart as asked for, closer where the skin bends.

A facet between places of a bent surface lies inside it by its chord error, length^2 * curvature / 8. Extremes and tape
girths are read off the facets, so they would be that much too small at toes, heel and ball.
"""

import numpy as np

from footscan.coordinates import Floats
from footscan.foot.nurbs import SplineTube, graded_breaks

_SHARE = 0.9  # of a row or column that keeps the limits; the rest are creases a facet may cut off
_CHORD_PER_FACET = 0.007
_LEAST_AROUND, _LEAST_UP = 24, 12


def grid_places(tube: SplineTube, facet_mm: float) -> tuple[Floats, Floats]:
    """Parameters of the columns `(m,)`, periodic, and of the rows `(k,)`, 0 and 1 among them.

    Args:
        tube: The surface.
        facet_mm: Longest wanted edge; the wanted chord error is a small share of it.
    """
    need_u, need_v = _needed(tube, facet_mm)
    around = max(_LEAST_AROUND, round(float(need_u.mean())))
    up = max(_LEAST_UP, round(float(0.5 * (need_v[1:] + need_v[:-1]).mean())))
    return graded_breaks(np.append(need_u, need_u[0]), around)[:-1], graded_breaks(need_v, up - 1)


def _needed(tube: SplineTube, facet_mm: float) -> tuple[Floats, Floats]:
    """Columns needed per unit of u, at places around, and rows needed per unit of v, at places up."""
    rows, columns = tube.net_mm.shape[:2]
    u, v = np.arange(columns) / columns, np.linspace(0.0, 1.0, 2 * rows)
    along_u, along_v = tube.grid(u, v, 1, 0), tube.grid(u, v, 0, 1)
    normal = np.cross(along_u, along_v)
    normal /= np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-12)
    chord = 8.0 * _CHORD_PER_FACET * facet_mm
    needs = [
        np.maximum(np.linalg.norm(slope, axis=2) / facet_mm, np.sqrt(np.abs((bend * normal).sum(axis=2)) / chord))
        for slope, bend in ((along_u, tube.grid(u, v, 2, 0)), (along_v, tube.grid(u, v, 0, 2)))
    ]
    return np.quantile(needs[0], _SHARE, axis=0), np.quantile(needs[1], _SHARE, axis=1)
