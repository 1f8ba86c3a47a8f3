"""Where a triangle mesh passes through itself."""

import numpy as np

from footscan.compiled import compiled, compiled_inline
from footscan.coordinates import Bools, Floats, Ints

_MOST_CUBES = 12
_IN_PLANE_MM = 1e-5


def crossing_faces(xyz: Floats, faces: Ints) -> Bools:
    """Which faces `(m,)` are pierced by an edge of another face that shares no vertex with them.

    Faces are sorted into cubes of about two edge lengths; only faces of one cube are compared.
    """
    corner = xyz[faces]
    low, high = corner.min(axis=1), corner.max(axis=1)
    size = 2.0 * float(np.median((high - low).max(axis=1)))
    first = np.floor((low - low.min(axis=0)) / size).astype(np.int64)
    final = np.floor((high - low.min(axis=0)) / size).astype(np.int64)
    final = np.minimum(final, first + _MOST_CUBES)
    count = final.max(axis=0) + 1
    cube, face = _cubes(first, final, count)
    order = np.argsort(cube, kind="stable")
    begins = np.flatnonzero(np.concatenate([[True], np.diff(cube[order]) > 0, [True]]))
    double = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return _pierced(np.ascontiguousarray(corner), double, low, high, faces, face[order], begins)


@compiled_inline
def _volume(a: Floats, b: Floats, c: Floats, d: Floats) -> float:
    """Six times the signed volume of a tetrahedron."""
    x0, y0, z0 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    x1, y1, z1 = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    x2, y2, z2 = d[0] - a[0], d[1] - a[1], d[2] - a[2]
    return x0 * (y1 * z2 - z1 * y2) - y0 * (x1 * z2 - z1 * x2) + z0 * (x1 * y2 - y1 * x2)


@compiled_inline
def _pierces(begin: Floats, end: Floats, triangle: Floats, least: float) -> bool:
    """Whether a piece of line goes through a triangle (signs of tetrahedra); ends nearer than `least` are in its plane.

    In the plane of the triangle signs are chance: the facets of a flat face lie beside each other and cross nowhere.
    """
    one = _volume(begin, triangle[0], triangle[1], triangle[2])
    two = _volume(end, triangle[0], triangle[1], triangle[2])
    if (one > 0.0) == (two > 0.0) or min(abs(one), abs(two)) <= least:
        return False
    a = _volume(begin, end, triangle[0], triangle[1]) > 0.0
    b = _volume(begin, end, triangle[1], triangle[2]) > 0.0
    c = _volume(begin, end, triangle[2], triangle[0]) > 0.0
    return bool(a == b and b == c)


@compiled
def _cubes(first: Ints, final: Ints, count: Ints) -> tuple[Ints, Ints]:
    total = 0
    for f in range(len(first)):
        total += (final[f, 0] - first[f, 0] + 1) * (final[f, 1] - first[f, 1] + 1) * (final[f, 2] - first[f, 2] + 1)
    cube, face = np.empty(total, dtype=np.int64), np.empty(total, dtype=np.int64)
    k = 0
    for f in range(len(first)):
        for x in range(first[f, 0], final[f, 0] + 1):
            for y in range(first[f, 1], final[f, 1] + 1):
                for z in range(first[f, 2], final[f, 2] + 1):
                    cube[k] = (x * count[1] + y) * count[2] + z
                    face[k] = f
                    k += 1
    return cube, face


@compiled
def _pierced(
    corner: Floats, double: Floats, low: Floats, high: Floats, faces: Ints, order: Ints, begins: Ints
) -> Bools:
    found = np.zeros(len(faces), dtype=np.bool_)
    for c in range(len(begins) - 1):
        for p in range(begins[c], begins[c + 1]):
            a = order[p]
            for q in range(p + 1, begins[c + 1]):
                b = order[q]
                if (
                    low[a, 0] > high[b, 0]
                    or low[b, 0] > high[a, 0]
                    or low[a, 1] > high[b, 1]
                    or low[b, 1] > high[a, 1]
                    or low[a, 2] > high[b, 2]
                    or low[b, 2] > high[a, 2]
                ):
                    continue
                shared = False
                for i in range(3):
                    for j in range(3):
                        shared = shared or faces[a, i] == faces[b, j]
                if shared:
                    continue
                hit = False
                for i in range(3):
                    j = (i + 1) % 3
                    hit = hit or _pierces(corner[a, i], corner[a, j], corner[b], _IN_PLANE_MM * float(double[b]))
                    hit = hit or _pierces(corner[b, i], corner[b, j], corner[a], _IN_PLANE_MM * float(double[a]))
                if hit:
                    found[a] = True
                    found[b] = True
    return found
