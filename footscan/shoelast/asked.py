"""What is asked of a displacement: conditions, wishes and bounds, from what a foot needs of a last."""

from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Floats
from footscan.geometry.nearest import PointTree
from footscan.shoelast.chart import Sparse, greville_places
from footscan.shoelast.fit_case import FitCase
from footscan.shoelast.need import Need
from footscan.shoelast.obstacle import Pull, Rows
from footscan.shoelast.widening import Widening, no_rolling_under

ASKS_MM = 0.01
_LEAST_LOSS_MM, _LOSS_SLACK, _SAFE_MM = 0.1, 1.2, 0.03
"""Room beyond the least that is asked of the smooth surface, for what lies between the places asked."""
_HOLD_MM, _CLOSE_SHARE = 6.0, 0.6
"""Over about this length holding wins against stiffness; and over this share of the transition length the surface
leaves the foot for the sake of smoothness (the d^2 beside l^4 |Hessian|^2 of the functional)."""


@dataclass(frozen=True)
class Asked:
    """What is asked of a displacement.

    Attributes:
        places: `(n, 3)` of the upper that ask for a change.
        wanted: The field at those of them that need room.
        rows: Conditions.
        pulls: Wishes.
        fixed: `(n_v, n_u)` coefficients that are there whatever is found: a widened feather edge.
        least: `(n_v, n_u)` lower bounds.
    """

    places: Floats
    wanted: Sparse
    rows: tuple[Rows, ...]
    pulls: tuple[Pull, ...]
    fixed: Floats
    least: Floats


def ask(case: FitCase, need: Need, widening: Widening, tapes: Floats) -> Asked:
    """What a foot asks of the standard last.

    Args:
        case: Last and foot.
        need: What the foot needs.
        widening: Of the bottom.
        tapes: `(k, 3)` places that tapes of wanted girths touch.
    """
    asking, pull = _asking(case, need)
    return Asked(
        places=np.vstack([case.on_upper(asking), widening.places, tapes]),
        wanted=case.chart.rows(asking.u, asking.v),
        rows=(no_rolling_under(case.chart), _held_out(case, need)),
        pulls=(pull,),
        fixed=np.outer(case.coarse.edge, widening.edge),
        least=_least(case, need),
    )


def with_bridged(case: FitCase, asked: Asked, need: Need) -> Asked:
    """The wish that skin between seen skin gets its room as well, so that no ridge stands between two stripes.

    It is a wish alone: bridged skin sets no condition, has no say in the widening, and is not judged.
    """
    weight = case.cell_area_mm2(need) / (_CLOSE_SHARE * case.transition_mm) ** 4
    pull = Pull(case.chart.rows(need.u, need.v), need.move_mm, weight)
    return replace(asked, places=np.vstack([asked.places, case.on_upper(need)]), pulls=(*asked.pulls, pull))


def with_run_out(case: FitCase, asked: Asked, need: Need) -> Asked:
    """Skin above the top line asks for nothing, but a change may run out beside it instead of ending in a step."""
    return replace(asked, places=np.vstack([asked.places, case.on_upper(need)]))


def _asking(case: FitCase, need: Need) -> tuple[Need, Pull]:
    """Places that ask for a change, and the wish to hold the foot closer."""
    out = need.known & (need.move_mm > ASKS_MM)
    loose = need.known & (need.loss_mm > _LEAST_LOSS_MM) & (need.hold_mm < -_LEAST_LOSS_MM) & case.settings.hold
    asking = need.of(out | loose)
    wish = np.where(loose, -np.minimum(-need.hold_mm, need.loss_mm), np.maximum(need.move_mm, 0.0))[out | loose]
    length = np.where(loose[out | loose], _HOLD_MM, _CLOSE_SHARE * case.transition_mm)
    return asking, Pull(case.chart.rows(asking.u, asking.v), wish, case.cell_area_mm2(asking) / length**4)


def _least(case: FitCase, need: Need) -> Floats:
    """Lower bounds `(n_v, n_u)` of the coefficients: what the last may lose near places that are too roomy."""
    least = np.zeros(case.chart.shape)
    loose = need.known & (need.loss_mm > _LEAST_LOSS_MM) & (need.hold_mm < -_LEAST_LOSS_MM)
    if case.settings.hold and loose.any():
        grid = case.chart.tube.grid(*greville_places(case.chart.tube)).reshape(-1, 3)
        gap, which = PointTree(case.on_upper(need.of(loose))).nearest(grid, 1, case.transition_mm)
        near = np.isfinite(gap[:, 0])
        least.reshape(-1)[near] = -_LOSS_SLACK * need.loss_mm[loose][which[near, 0]]
    return least


def _held_out(case: FitCase, need: Need) -> Rows:
    """The foot stays inside: d(u, v) >= what each cell needs."""
    used = need.known & (need.move_mm > -_LOSS_SLACK * need.loss_mm - ASKS_MM)
    move = need.move_mm[used]
    return Rows(case.chart.rows(need.u[used], need.v[used]), move + _SAFE_MM * (move > 0.0))
