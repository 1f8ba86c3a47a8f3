"""The lowest seen skin around the foot, and points of the assumed skin below it."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter, minimum_filter1d

from footscan.coordinates import Floats
from footscan.foot.bare_board import find_bare_reach
from footscan.foot.closure import ClosureRule, closing_arcs, edge_shape
from footscan.foot.nurbs import SplineTube
from footscan.foot.nurbs_fit import evaluate_at
from footscan.foot.surface_chart import SlantedAxis

_COLUMNS = 240
_RISES = (0.02, 0.045)  # v above the lowest seen skin of the rows that show its lean and bend
_ENOUGH = 3  # points below a height before it counts as seen


@dataclass(frozen=True)
class AssumedSkin:
    """Points of the assumed skin.

    Attributes:
        u: `(m,)`.
        v: `(m,)`.
        xyz_mm: `(m, 3)`.
        lowest_u: `(A,)` columns around the foot.
        lowest_v: `(A,)` v of the lowest seen skin in each.
        board_known: Whether the bare board bounds it.
    """

    u: Floats
    v: Floats
    xyz_mm: Floats
    lowest_u: Floats
    lowest_v: Floats
    board_known: bool


def lowest_seen_v(u: Floats, v: Floats, columns: int) -> Floats:
    """Parameters v `(columns,)` of the lowest seen skin in columns of equal width in u, steadied around the foot."""
    which = np.floor(u * columns).astype(np.int64) % columns
    order = np.lexsort((v, which))
    starts = np.searchsorted(which[order], np.arange(columns + 1))
    third = order[np.minimum(starts[:-1] + _ENOUGH - 1, len(order) - 1)]
    found = np.flatnonzero(np.diff(starts) >= _ENOUGH)
    lowest = np.interp(np.arange(columns), found, v[third[found]], period=columns)
    lowest = minimum_filter1d(median_filter(lowest, 3, mode="wrap"), 3, mode="wrap")
    return gaussian_filter1d(lowest, 1.0, mode="wrap")


def assume_bottom(
    tube: SplineTube, u: Floats, v: Floats, axis: SlantedAxis, rule: ClosureRule, xy_board: Floats
) -> AssumedSkin:
    """Points of the assumed skin under a first fit of the seen skin.

    Args:
        tube: A fit whose seen part is right.
        u: `(n,)` parameters of the seen points.
        v: Same.
        axis: The chart's axis, towards which the sole lies.
        rule: The closure.
        xy_board: `(n, 2)` places where the bare board was seen.
    """
    columns = (np.arange(_COLUMNS) + 0.5) / _COLUMNS
    lowest = np.maximum(lowest_seen_v(u, v, _COLUMNS), 1e-3)
    ring = evaluate_at(tube, columns, lowest).xyz_mm
    ring[:, 2] = np.maximum(ring[:, 2], 0.5)
    rows = [ring, *(evaluate_at(tube, columns, lowest + rise).xyz_mm for rise in _RISES)]
    away = ring[:, :2] - np.array(axis.low_mm)
    room = np.linalg.norm(away, axis=1)
    inwards = -away / np.maximum(room, 1e-9)[:, None]
    bare = room - find_bare_reach(xy_board, axis.low_mm, ring[:, :2], axis.heading_rad)
    points, along = closing_arcs(ring, inwards, edge_shape(np.stack(rows), inwards), room, bare, rule)
    count = points.shape[1]
    return AssumedSkin(
        np.repeat(columns, count),
        (along * lowest[:, None]).ravel(),
        points.reshape(-1, 3),
        columns,
        lowest,
        bool(np.isfinite(bare).any()),
    )
