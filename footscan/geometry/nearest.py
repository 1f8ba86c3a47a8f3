"""Nearest neighbours: the one door to SciPy's tree, with types."""

from typing import Any

import numpy as np
from scipy import spatial

from footscan.coordinates import Floats, Ints


class PointTree:
    """A search tree over `(n, 3)` (or `(n, 2)`) points."""

    def __init__(self, points: Floats) -> None:
        kd_tree: Any = spatial.KDTree
        self._tree = kd_tree(points)

    def nearest(self, queries: Floats, count: int, reach: float = np.inf) -> tuple[Floats, Ints]:
        """Distances and indices `(m, count)` of the nearest points; beyond reach: infinity and n."""
        distance, index = self._tree.query(queries, k=count, distance_upper_bound=reach, workers=-1)
        shape = (len(queries), count)
        return np.asarray(distance, dtype=np.float64).reshape(shape), np.asarray(index, np.int64).reshape(shape)

    def pairs(self, reach: float) -> Ints:
        """Pairs `(k, 2)` of points nearer to one another than `reach`."""
        return np.asarray(self._tree.query_pairs(reach, output_type="ndarray"), np.int64).reshape(-1, 2)
