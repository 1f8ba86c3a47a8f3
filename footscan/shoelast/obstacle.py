"""The smoothest displacement that keeps an obstacle inside: a convex quadratic programme, solved by Clarabel.

Unknown are the coefficients of a scalar field on a chart (`chart.py`). Some are fixed; those on the back line are tied,
so that the field is zero along it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import clarabel
import numpy as np
from scipy import sparse as scipy_sparse

from footscan.coordinates import Bools, Floats, Ints
from footscan.errors import QualityError
from footscan.shoelast.chart import Sparse
from footscan.shoelast.nets import Coarse

sparse: Any = scipy_sparse

BACK_COLUMNS = (0, 1, 2)
"""Control columns that reach the back line (u = 0); a field is zero on it when c_1 = -(c_0 + c_2) / 4."""


@dataclass(frozen=True)
class Unknowns:
    """Which coefficients may change.

    Attributes:
        spread: Sparse `(n_v * n_u, n)`: all coefficients from the unknown ones.
        fixed: `(n_v * n_u,)` the rest of them.
        least: `(n,)` lower bounds.
        fine: Coefficients of the fine net that are unknown by themselves, beside those of the coarse one.
    """

    spread: Sparse
    fixed: Floats
    least: Floats
    fine: Ints

    def coefficients(self, unknown: Floats, shape: tuple[int, int]) -> Floats:
        """All coefficients `(n_v, n_u)`."""
        return (self.spread @ unknown + self.fixed).reshape(shape)


def find_unknowns(
    free: Bools, fixed: Floats, least: Floats, coarse: Coarse, wanted: Sparse, also: Ints | None = None
) -> Unknowns:
    """Sort coefficients into unknown, fixed and tied ones.

    Args:
        free: `(n_v, n_u)` which may change.
        fixed: `(n_v, n_u)` what is there whatever the unknowns are.
        least: `(n_v, n_u)` lower bounds.
        coarse: The coarser net whose fields are looked for: those of its coefficients that move only free ones.
        wanted: Sparse `(n, n_v * n_u)`, the field at places that ask for a change. Where the coarse net has little say
            (a spot by itself, smaller than the net's spans) free coefficients of the fine net are added.
        also: Coefficients of the fine net that are added in any case.
    """
    touches = (coarse.spread != 0).astype(np.float64)
    blocked = touches.T @ (~free).ravel().astype(np.float64)
    bound = np.full(coarse.shape, -np.inf).ravel()
    inner = coarse.spread.tocoo()
    np.maximum.at(bound, inner.col, np.where(inner.data >= _MAIN, least.ravel()[inner.row], -np.inf))
    alone = _tied_unknowns((blocked == 0.0).reshape(coarse.shape), bound.reshape(coarse.shape))
    spread = (coarse.spread @ alone[0]).tocsc()
    more = _for_lonely_places(spread, free, wanted)
    more = more if also is None else np.union1d(more, also[free.ravel()[also]])
    eye = sparse.identity(free.size, format="csc")[:, more]
    bounds = np.concatenate([alone[1], least.ravel()[more]])
    return Unknowns(sparse.hstack([spread, eye], format="csc"), fixed.ravel(), bounds, more)


_LITTLE_SAY, _ACTS, _COVERED = 0.6, 0.02, 0.9


def _for_lonely_places(spread: Sparse, free: Bools, wanted: Sparse) -> Ints:
    """Free coefficients that act where the unknowns have little say, back line left out."""
    say = np.asarray((wanted @ abs(spread)).sum(axis=1)).ravel()
    lonely = wanted[np.flatnonzero(say < _LITTLE_SAY)]
    acts = np.asarray(lonely.max(axis=0).todense()).ravel() > _ACTS if lonely.shape[0] else np.zeros(free.size, bool)
    alone = free.copy()
    alone[:, list(BACK_COLUMNS)] = False
    covered = np.asarray(abs(spread).sum(axis=1)).ravel()
    return np.flatnonzero(alone.ravel() & acts & (covered < _COVERED))


_MAIN = 0.4
"""A fine coefficient that takes this much from a coarse one bounds it."""


def _tied_unknowns(free: Bools, least: Floats) -> tuple[Sparse, Floats]:
    """Spread from unknowns to the coefficients of one net, the back line tied, and their lower bounds."""
    rows, columns = free.shape
    before, on, after = BACK_COLUMNS
    free = free.copy()
    free[:, on] &= free[:, before] & free[:, after]
    free[:, [before, after]] &= free[:, [on]]
    alone = free.copy()
    alone[:, on] = False
    number = np.cumsum(alone.ravel()) - 1
    place = np.flatnonzero(alone.ravel())
    tied = np.flatnonzero(free[:, on])
    row = np.concatenate([place, tied * columns + on, tied * columns + on])
    column = np.concatenate([number[place], number[tied * columns + before], number[tied * columns + after]])
    value = np.concatenate([np.ones(len(place)), np.full(2 * len(tied), -0.25)])
    spread = sparse.csc_matrix((value, (row, column)), shape=(rows * columns, len(place)))
    return spread, least.ravel()[place]


@dataclass(frozen=True)
class Rows:
    """Linear conditions `matrix @ c >= right` on all coefficients."""

    matrix: Sparse
    right: Floats


@dataclass(frozen=True)
class Pull:
    """Places that should come to a value: adds sum(weight * (matrix @ c - value)^2)."""

    matrix: Sparse
    value: Floats
    weight: Floats


Watch = Callable[[], None]
"""Called often by what takes long; what it raises ends the work."""


def unwatched() -> None:
    """Nobody wants to end it."""


def solve_smoothest(
    energy: Sparse, unknowns: Unknowns, rows: list[Rows], pulls: list[Pull], watch: Watch = unwatched
) -> Floats:
    """Minimise c' K c and the pulls under the rows and bounds.

    Args:
        energy: K, `(n_v * n_u, n_v * n_u)`.
        unknowns: Which coefficients may change.
        rows: Conditions.
        pulls: Wishes.
        watch: Called in every iteration.

    Returns:
        The unknown coefficients `(n,)`.

    Raises:
        QualityError: The conditions contradict each other.
    """
    spread, fixed = unknowns.spread, unknowns.fixed
    if spread.shape[1] == 0:
        return np.zeros(0)
    quadratic = spread.T @ energy @ spread
    linear = spread.T @ (energy @ fixed)
    for pull in pulls:
        on_unknown = pull.matrix @ spread
        weighted = on_unknown.T.multiply(pull.weight).tocsr()
        quadratic = quadratic + weighted @ on_unknown
        linear = linear + weighted @ (pull.matrix @ fixed - pull.value)
    left = [-(row.matrix @ spread) for row in rows]
    right = [row.matrix @ fixed - row.right for row in rows]
    bounded = np.flatnonzero(np.isfinite(unknowns.least))
    left.append(-sparse.identity(spread.shape[1], format="csr")[bounded])
    right.append(-unknowns.least[bounded])
    return _clarabel(quadratic, linear, sparse.vstack(left, format="csc"), np.concatenate(right), watch)


def _clarabel(quadratic: Sparse, linear: Floats, left: Sparse, right: Floats, watch: Watch = unwatched) -> Floats:
    """Minimise 1/2 x' P x + q' x subject to A x <= b."""
    solver: Any = clarabel
    settings = solver.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = 1e-4
    settings.tol_feas = 1e-6
    settings.iterative_refinement_enable = False  # the worst condition is met to 1e-5 mm without it, a quarter faster
    settings.max_iter = 60
    settings.direct_solve_method = "qdldl"  # what it chooses by itself is now and then six times slower here
    scale = 1.0 / max(float(abs(quadratic).max()), 1e-300)
    upper = sparse.triu(quadratic * scale, format="csc")
    cones = [solver.NonnegativeConeT(left.shape[0])]
    programme = solver.DefaultSolver(upper, linear * scale, left, right, cones, settings)
    ended: list[BaseException] = []

    def asked_to_end(_: Any) -> bool:
        try:
            watch()
        except BaseException as err:  # noqa: BLE001 - it cannot pass through the solver, and is raised behind it
            ended.append(err)
        return bool(ended)

    programme.set_termination_callback(asked_to_end)
    found = programme.solve()
    if ended:
        raise ended[0]
    status = str(found.status)
    if status not in ("Solved", "AlmostSolved"):
        raise QualityError(
            f"no displacement meets all that is asked ({status.lower()}): lower the allowances or pins, allow a longer "
            "transition, or take a larger last."
        )
    return np.asarray(found.x)


_MOST_OVER = 1.5
"""No coefficient of a closed curve is more than this many times the largest need: beside a held end it would swing."""


def smooth_line(need: Floats, free: Bools, spacing: Floats, length_mm: float) -> Floats:
    """A smooth closed curve close over a need: periodic spline coefficients, zero where they may not change.

    It is the least of bending plus the squared distance above the need over `length_mm`^4.

    Args:
        need: `(n,)` least values, at the middle of each coefficient.
        free: `(n,)` coefficients that may change.
        spacing: `(n,)` distance (mm) between neighbouring coefficients.
        length_mm: Over about this length the curve leaves the need for the sake of smoothness.
    """
    count = len(need)
    eye = sparse.identity(count, format="csr")
    ahead, behind = (sparse.csr_matrix(np.roll(eye.toarray(), k, axis=1)) for k in (1, -1))
    bend = sparse.diags(1.0 / spacing**1.5) @ (ahead - 2.0 * eye + behind)
    values = (ahead + 4.0 * eye + behind) / 6.0
    place = np.flatnonzero(free)
    if len(place) == 0:
        return np.zeros(count)
    spread = eye.tocsc()[:, place]
    active = np.flatnonzero(need > 0.0)
    eye_left = sparse.identity(len(place))
    left = sparse.vstack([-(values[active] @ spread), -eye_left, eye_left], format="csc")
    right = np.concatenate([-need[active], np.zeros(len(place)), np.full(len(place), _MOST_OVER * need.max())])
    weigh = sparse.diags(spacing / length_mm**4)
    quadratic = spread.T @ (bend.T @ bend + values.T @ weigh @ values) @ spread
    found = _clarabel(quadratic.tocsc(), -(spread.T @ (values.T @ (weigh @ need))), left, right)
    result = np.zeros(count)
    result[place] = np.maximum(found, 0.0)
    return result


def reach_of(indices: Ints, count: int) -> Bools:
    """Mark `(count,)` some places of a closed line."""
    result = np.zeros(count, dtype=np.bool_)
    result[np.mod(indices, count)] = True
    return result
