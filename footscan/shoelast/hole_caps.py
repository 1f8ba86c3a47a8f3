"""Caps on the holes of a mesh: as finely meshed as the skin around, and bulged as that skin runs in from all sides.

A flat fan from a hole's rim to its middle has no size in the harmonic chart of the upper, so the surface that is fitted
afterwards would run straight across: at a narrow toe, where a toe centre was cut off, nearly a millimetre too short.
"""

from typing import Any

import numpy as np
from scipy import interpolate as scipy_interpolate
from scipy.spatial import Delaunay

from footscan.coordinates import Floats, Ints
from footscan.geometry.nearest import PointTree
from footscan.shoelast.mesh_topology import rims

interpolate: Any = scipy_interpolate
_LEAST_MM = 4.0
"""Smaller holes get a fan."""
_STEP_MM, _MOST_PLACES = 0.6, 900
_AROUND_MM, _MOST_AROUND = 4.0, 500
_ALIKE_MM = 0.001
_SMOOTHING = 1e-4
_STEEP = 1.0
"""A cap rises at most by so much of its own size above the plane of its rim."""


def with_caps(xyz: Floats, faces: Ints) -> tuple[Floats, Ints, int]:
    """Close every rim of an outward mesh.

    Args:
        xyz: `(n, 3)` mm.
        faces: `(m, 3)`.

    Returns:
        Vertices, the given ones first, faces, and how many vertices were added.
    """
    parts, corners, size = [xyz], [faces], len(xyz)
    used = np.unique(faces)
    for rim in rims(faces):
        inside, cap = _cap(xyz, rim, used)
        parts.append(inside)
        corners.append(np.where(cap < len(rim), rim[np.minimum(cap, len(rim) - 1)], cap - len(rim) + size))
        size += len(inside)
    return np.vstack(parts), np.ascontiguousarray(np.vstack(corners)), size - len(xyz)


def _cap(xyz: Floats, rim: Ints, used: Ints) -> tuple[Floats, Ints]:
    """Places `(k, 3)` inside a rim, and triangles whose numbers count the rim's vertices first."""
    places = xyz[rim]
    if float(np.ptp(places, axis=0).max()) >= _LEAST_MM:
        found = _bulged(places, xyz[used])
        if found is not None:
            return found
    count = len(rim)
    ring = np.arange(count)
    return places.mean(axis=0)[None], np.stack([ring, np.roll(ring, -1), np.full(count, count)], axis=1)


def _bulged(rim: Floats, skin: Floats) -> tuple[Floats, Ints] | None:
    """A finely meshed cap; None where its skin stands too steep.

    It is meshed in the disc whose rim is as long as the hole's, so that every stretch of the rim is an edge of it.
    """
    frame, middle = _frame_of(rim), rim.mean(axis=0)
    flat = (rim - middle) @ frame
    disc, inner = _disc_of(flat)
    corners = _triangles(np.vstack([disc, inner]))
    places = _interpolated(disc, flat[:, :2], inner)
    near = skin[PointTree(rim).nearest(skin, 1, _AROUND_MM)[1][:, 0] < len(rim)]
    around = (near[:: 1 + len(near) // _MOST_AROUND] - middle) @ frame
    known = np.unique((np.vstack([flat, around]) / _ALIKE_MM).astype(np.int64), axis=0).astype(np.float64) * _ALIKE_MM
    height = _interpolated(known[:, :2], known[:, 2], places)
    if np.abs(height).max() > _STEEP * float(np.ptp(flat[:, :2], axis=0).max()):
        return None
    return np.column_stack([places, height]) @ frame.T + middle, corners


def _interpolated(known: Floats, values: Floats, places: Floats) -> Floats:
    """The thin plate through values at known places `(n, 2)`, at other places `(k, 2)`."""
    return np.asarray(interpolate.RBFInterpolator(known, values, smoothing=_SMOOTHING)(places), dtype=np.float64)


def _frame_of(rim: Floats) -> Floats:
    """Columns `(3, 3)`: two axes in the plane of a rim and its normal, round which the rim runs counter-clockwise."""
    centred = rim - rim.mean(axis=0)
    normal = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    normal = normal / np.linalg.norm(normal)
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    first = first / np.linalg.norm(first)
    return np.asarray(np.stack([first, np.cross(normal, first), normal], axis=1), dtype=np.float64)


def _disc_of(rim: Floats) -> tuple[Floats, Floats]:
    """A rim `(n, 3)` rolled into a circle `(n, 2)`, and a triangular grid `(k, 2)` inside it."""
    walked = np.cumsum(np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1))
    radius = walked[-1] / (2.0 * np.pi)
    angle = 2.0 * np.pi * np.concatenate([[0.0], walked[:-1]]) / walked[-1]
    step = max(_STEP_MM, 2.0 * radius / np.sqrt(_MOST_PLACES))
    x, y = (np.arange(-radius, radius, step * factor) for factor in (1.0, np.sqrt(0.75)))
    shift = 0.5 * step * (np.arange(len(y)) % 2)
    grid = np.stack(np.broadcast_arrays(x[None] + shift[:, None], y[:, None]), axis=-1).reshape(-1, 2)
    inside = np.hypot(*grid.T) < radius - 0.6 * step
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1), grid[inside]


def _triangles(xy: Floats) -> Ints:
    """Triangles `(m, 3)` of places on a circle and inside it, counter-clockwise."""
    corners = Delaunay(xy).simplices.astype(np.int64)
    a, b, c = (xy[corners[:, k]] for k in range(3))
    turned = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
    corners[turned] = corners[turned][:, ::-1]
    return corners
