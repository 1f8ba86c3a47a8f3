"""Connected bodies of a cloud on a grid of cells: the one door to SciPy's labelling, with types."""

from typing import Any

import numpy as np
from scipy import ndimage

from footscan.coordinates import Floats, Ints

_DIMENSIONS = 3


def label_bodies(xyz: Floats, cell: float) -> tuple[Ints, Floats]:
    """Which connected body each of `(n, 3)` points belongs to, and its distance to the largest one.

    Cells are connected to all 26 neighbours, over gaps of up to two empty cells.

    Returns:
        `(n,)` labels (the largest body is 0) and `(n,)` distances to the largest body, in the unit of `cell`.
    """
    image: Any = ndimage
    at = np.floor((xyz - xyz.min(axis=0)) / cell).astype(np.int64)
    place = (at[:, 0], at[:, 1], at[:, 2])
    grid = np.zeros(at.max(axis=0) + 1, dtype=np.bool_)
    grid[place] = True
    around = image.generate_binary_structure(_DIMENSIONS, _DIMENSIONS)
    bodies, _ = image.label(image.binary_dilation(grid, around), structure=around)
    body = np.asarray(bodies, dtype=np.int64)[place]
    order = np.argsort(-np.bincount(body), kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    if len(np.unique(body)) == 1:
        return np.zeros(len(xyz), dtype=np.int64), np.zeros(len(xyz))
    largest = grid & (np.asarray(bodies) == order[0])
    outside = image.distance_transform_edt(~largest, sampling=cell)
    return rank[body], np.asarray(outside, dtype=np.float64)[place]
