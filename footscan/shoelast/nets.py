"""Finer and coarser control nets of a last: exact refinement, and the coarse fields that a displacement is made of."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline
from scipy.sparse import linalg as splinalg

from footscan.coordinates import Floats
from footscan.foot.nurbs import DEGREE, SplineTube, greville
from footscan.shoelast.chart import Sparse
from footscan.shoelast.model import Shoelast
from footscan.shoelast.patches import ChordDisc, half_knots

_LOCAL_SPAN = 0.36
"""The support of a cubic reaches 2.8 spans from any place of the span it is nearest to, corners included."""
_ROUNDING = 1e-12


def fine_enough(shoelast: Shoelast, transition_mm: float) -> Shoelast:
    """The same last on a net so fine that a change at any single place ends within the transition length."""
    longest_mm = _LOCAL_SPAN * transition_mm
    tube = shoelast.upper
    breaks = tube.knots_v[DEGREE:-DEGREE]
    grid = tube.grid(np.arange(2 * tube.count_u) / (2 * tube.count_u), breaks)
    around = np.linalg.norm(np.diff(grid, axis=1), axis=2).sum(axis=1).max() / tube.count_u
    times = 1
    while around / times > longest_mm:
        times *= 2
    parts = np.ceil(np.linalg.norm(np.diff(grid, axis=0), axis=2).max(axis=1) / longest_mm).astype(np.int64)
    extra = [
        low + np.arange(1, count) / count * (high - low)
        for low, high, count in zip(breaks[:-1], breaks[1:], parts, strict=True)
    ]
    inner = np.concatenate(extra)
    return refined(shoelast, times, inner) if times > 1 or len(inner) else shoelast


def refined(shoelast: Shoelast, times_round: int, extra_v: Floats) -> Shoelast:
    """The same last, to rounding, with a finer control net.

    Args:
        shoelast: Any last.
        times_round: How many columns for one, a power of two; 1 leaves them.
        extra_v: Knots to insert up the upper, each once, inside 0..1 and none of them a knot already.
    """
    tube = shoelast.upper
    knots_v = np.sort(np.concatenate([tube.knots_v, extra_v]))
    net = np.einsum("ij,juk->iuk", _inserted(tube.knots_v, knots_v), tube.net_mm, optimize=True)
    while net.shape[1] < tube.count_u * times_round:
        net = np.einsum("ij,vjk->vik", _subdivision(net.shape[1]), net, optimize=True)
    upper = SplineTube(net, knots_v)
    bottom, top = (_refined_disc(disc, upper.count_u) for disc in (shoelast.bottom, shoelast.cone_top))
    return replace(shoelast, upper=upper, bottom=bottom, cone_top=top)


def _inserted(knots: Floats, finer: Floats) -> Floats:
    """Coefficients on the finer knots from those on the coarser ones among them."""
    places = greville(finer)
    solve: Any = splinalg
    fine = BSpline.design_matrix(places, finer, DEGREE).tocsc()
    result = np.asarray(solve.splu(fine).solve(BSpline.design_matrix(places, knots, DEGREE).toarray()))
    result[np.abs(result) < _ROUNDING] = 0.0
    return result


@dataclass(frozen=True)
class Coarse:
    """A coarser net whose fields are fields of the chart's net.

    Attributes:
        spread: Sparse `(n_v * n_u, m_v * m_u)`: the chart's coefficients from the coarse ones.
        shape: (m_v, m_u).
        edge: `(n_v,)` the chart's rows that the coarse row of the feather edge consists of.
    """

    spread: Sparse
    shape: tuple[int, int]
    edge: Floats


def coarse_space(tube: SplineTube, longest_mm: float) -> Coarse:
    """Leave out every other knot, both ways and repeatedly, while spans stay shorter than a length."""
    around, up = np.eye(tube.count_u), np.eye(len(tube.knots_v) - DEGREE - 1)
    breaks = tube.knots_v[DEGREE:-DEGREE]
    grid = tube.grid(np.arange(tube.count_u) / tube.count_u, breaks)
    span_u = np.linalg.norm(np.roll(grid, -1, axis=1) - grid, axis=2).mean(axis=1).max()
    while 2.0 * span_u < longest_mm and len(around.T) % 2 == 0:
        around, span_u = around @ _subdivision(len(around.T) // 2), 2.0 * span_u
    lengths = np.percentile(np.linalg.norm(np.diff(grid, axis=0), axis=2), 90, axis=1)
    kept = _thinned(breaks, lengths, longest_mm)
    if len(kept) < len(breaks):
        knots = np.concatenate([tube.knots_v[:DEGREE], kept, tube.knots_v[-DEGREE:]])
        up = _inserted(knots, tube.knots_v)
    spread = sparse.kron(sparse.csr_matrix(up), sparse.csr_matrix(around), format="csc")
    return Coarse(spread, (up.shape[1], around.shape[1]), up[:, 0].copy())


def _subdivision(count: int) -> Floats:
    """`(2 * count, count)`: a periodic cubic spline on twice as many columns; column i acts most at (i - 1) / count."""
    result = np.zeros((2 * count, count))
    column = np.arange(count)
    for shift, share in ((-1, 0.125), (0, 0.75), (1, 0.125)):
        result[(2 * column - 1) % (2 * count), (column + shift) % count] += share
    for shift in (0, 1):
        result[2 * column, (column + shift) % count] += 0.5
    return result


def _thinned(breaks: Floats, lengths: Floats, longest_mm: float) -> Floats:
    """Breaks without those that join two spans into one that is still short enough."""
    kept, run = [0], 0.0
    for k in range(1, len(breaks) - 1):
        run += lengths[k - 1]
        if run + lengths[k] > longest_mm:
            kept.append(k)
            run = 0.0
    return breaks[[*kept, len(breaks) - 1]]


def _refined_disc(disc: ChordDisc, count_u: int) -> ChordDisc:
    knots = half_knots(count_u)
    net = np.einsum("ij,jtk->itk", _inserted(disc.knots_s, knots), disc.net_mm, optimize=True)
    return ChordDisc(net, knots, disc.knots_t)
