"""How far measured points lie from a known surface."""

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import Floats, Ints
from footscan.geometry.nearest import PointTree

_CANDIDATES = 16


def distance_to_surface_mm(xyz: Floats, vertices: Floats, faces: Ints) -> Floats:
    """Unsigned distances `(n,)` of `(n, 3)` points to a mesh whose facets are small against its curvature.

    The nearest facet is looked for among the 16 whose middles are nearest, which is exact for facets of similar size.
    """
    corners = np.ascontiguousarray(vertices[faces])
    middles = corners.mean(axis=1)
    _, index = PointTree(middles).nearest(xyz, min(_CANDIDATES, len(middles)))
    result = np.empty(len(xyz))
    _nearest_of(np.ascontiguousarray(xyz), corners, index, result)
    return result


@compiled
def _nearest_of(xyz: Floats, corners: Floats, index: Ints, result: Floats) -> None:
    for i in range(xyz.shape[0]):
        best = np.inf
        for k in range(index.shape[1]):
            best = min(best, _to_triangle(xyz[i], corners[index[i, k]]))
        result[i] = np.sqrt(best)


@compiled
def _to_triangle(point: Floats, triangle: Floats) -> float:
    """Squared distance of a point to a triangle: in barycentric coordinates, or to the nearest of its edges."""
    a, b, c = triangle[0], triangle[1], triangle[2]
    ab, ac, ap = b - a, c - a, point - a
    d00, d01, d11 = (ab * ab).sum(), (ab * ac).sum(), (ac * ac).sum()
    d20, d21 = (ap * ab).sum(), (ap * ac).sum()
    determinant = d00 * d11 - d01 * d01
    if determinant > 1e-18:
        v, w = (d11 * d20 - d01 * d21) / determinant, (d00 * d21 - d01 * d20) / determinant
        if v >= 0.0 and w >= 0.0 and v + w <= 1.0:
            off = ap - v * ab - w * ac
            return (off * off).sum()
    return min(_to_edge(point, a, b), _to_edge(point, b, c), _to_edge(point, c, a))


@compiled
def _to_edge(point: Floats, begin: Floats, end: Floats) -> float:
    edge, off = end - begin, point - begin
    length2 = (edge * edge).sum()
    share = min(max((off * edge).sum() / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
    rest = off - share * edge
    return (rest * rest).sum()
