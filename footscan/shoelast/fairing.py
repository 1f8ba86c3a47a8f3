"""Smoothing a customised last on a copy: as fair as it can be within some tenths of a millimetre, conditions kept."""

from typing import Any

import numpy as np
from scipy import sparse as scipy_sparse

from footscan.coordinates import Bools, Floats, Ints
from footscan.shoelast.asked import Asked
from footscan.shoelast.chart import Sparse, bending_matrix
from footscan.shoelast.custom_last import Smoothing
from footscan.shoelast.custom_report import Standard, find_dimensions, find_smoothness, measure_last
from footscan.shoelast.custom_result import Displaced
from footscan.shoelast.fit_case import FitCase
from footscan.shoelast.obstacle import Rows, find_unknowns, solve_smoothest

sparse: Any = scipy_sparse
MOST_SMOOTH_MM = 3.0
_FAIR_SHARE = 0.4
"""Bends shorter than this share of the transition length cost most."""


def faired(case: FitCase, asked: Asked, coefficients: Floats, free: Bools, fine: Ints) -> Floats:
    """The fairest displacement near one that is there.

    Every condition of the one that is there holds for the new one, or is missed no further: what the foot needs, what
    the last may lose, the feather edge, back line and cone edge, and the transition length.

    Args:
        case: Last and foot.
        asked: What is asked of the displacement; its pulls are wishes that smoothing should not undo.
        coefficients: `(n_v, n_u)` the displacement.
        free: `(n_v, n_u)` coefficients that may change.
        fine: Coefficients of the fine net that it makes use of.

    Returns:
        `(n_v, n_u)`; none of them is further than the settings' limit from those that were there.
    """
    limit_mm = case.settings.smooth_mm
    none = np.full(case.chart.shape, -np.inf)
    unknowns = find_unknowns(free, coefficients, none, case.coarse, asked.wanted, fine)
    now = coefficients.ravel()
    kept = [Rows(row.matrix, np.minimum(row.right, row.matrix @ now)) for row in asked.rows]
    moving = np.flatnonzero(np.asarray(abs(unknowns.spread).sum(axis=1)).ravel() > 0.0)
    one: Sparse = sparse.identity(len(now), format="csr")[moving]
    least = np.maximum(now - limit_mm, np.minimum(asked.least.ravel(), now))[moving]
    kept += [Rows(one, least), Rows(-one, -(now + limit_mm)[moving])]
    stiffness = bending_matrix(case.chart.tube, _FAIR_SHARE * case.transition_mm, free)
    found = solve_smoothest(stiffness, unknowns, kept, list(asked.pulls))
    return unknowns.coefficients(found, case.chart.shape)


def smoothing_of(case: FitCase, standard: Standard, plain: Displaced, smooth: Displaced, limit_mm: float) -> Smoothing:
    """What smoothing changed; `standard` is the last that was customised."""
    before, after = measure_last(plain.shoelast), measure_last(smooth.shoelast)
    variation = bending_matrix(case.chart.tube, 1.0) - standard.bending
    first, second = (
        float(state.coefficients.ravel() @ (variation @ state.coefficients.ravel())) for state in (plain, smooth)
    )
    return Smoothing(
        limit_mm=limit_mm,
        most_mm=float(np.linalg.norm(smooth.skin.xyz_shoelast - plain.skin.xyz_shoelast, axis=1).max()),
        variation=(first, second),
        before=find_smoothness(standard, plain.coefficients, before),
        dimensions=find_dimensions(before, after),
        unsmoothed=before.shoelast,
    )
