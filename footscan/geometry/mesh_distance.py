"""Exact signed distance of points to a closed triangle mesh, by a tree of boxes and pseudo-normals."""

from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats, Ints
from footscan.geometry.mesh_distance_loops import (
    LEAF,
    build_boxes,
    corner_normals,
    face_corners,
    faces_across,
    find_nearest,
    find_places,
    halve,
    morton_codes,
    split_by_halves,
)

_CELLS = 1024.0
_AT_ONCE, _MANY = 2, 4000
"""Threads that search at once, for more points than this."""


@dataclass(frozen=True)
class Nearest:
    """Where a mesh is nearest to some points.

    Attributes:
        xyz: `(n, 3)` places on the mesh.
        face: `(n,)` the faces they lie on.
        weight: `(n, 3)` barycentric weights of the faces' corners.
        normal: `(n, 3)` unit pseudo-normals there, outward.
        signed: `(n,)` distances, negative inside.
    """

    xyz: Floats
    face: Ints
    weight: Floats
    normal: Floats
    signed: Floats


class DistanceMesh:
    """A closed, outward mesh made ready for distances.

    The sign is that of the angle-weighted pseudo-normal of the face, side or corner that is nearest, which is exact for
    closed meshes that do not cut themselves (Baerentzen and Aanaes 2005).
    """

    def __init__(self, xyz: Floats, faces: Ints) -> None:
        """Take corners `(n, 3)` and faces `(m, 3)`, counter-clockwise seen from outside."""
        self.xyz = np.ascontiguousarray(xyz, dtype=np.float64)
        self._low = self.xyz.min(axis=0)
        self._cell = max(float(np.ptp(self.xyz, axis=0).max()), 1e-9) / _CELLS
        leaves = 1
        while leaves * LEAF < len(faces):
            leaves *= 2
        self._order = _tree_order(self.xyz[faces].mean(axis=1), leaves)
        self._faces = np.ascontiguousarray(faces[self._order], dtype=np.int64)
        self._leaves = leaves
        self._across = faces_across(self._faces, len(self.xyz))
        self._fit()

    def moved(self, xyz: Floats) -> "DistanceMesh":
        """The same faces with their corners elsewhere: much cheaper than a new tree, good while they stay near."""
        result = copy(self)
        result.xyz = np.ascontiguousarray(xyz, dtype=np.float64)
        result._fit()
        return result

    def _fit(self) -> None:
        """Boxes and normals of the corners as they are now."""
        self._corners, self._unit = np.empty((len(self._faces), 9)), np.empty((len(self._faces), 3))
        with ThreadPoolExecutor(_AT_ONCE) as pool:
            boxes = pool.submit(build_boxes, self.xyz, self._faces, self._leaves)
            face_corners(self.xyz, self._faces, self._corners, self._unit)
            self._at_corner = corner_normals(self.xyz, self._faces, self._unit)
            self._boxes = boxes.result()

    def nearest(self, points: Floats) -> Nearest:
        """The nearest places of the mesh to `(n, 3)` points."""
        order = np.argsort(morton_codes(points, self._low - 64.0 * self._cell, 4.0 * self._cell), kind="stable")
        sorted_points = np.ascontiguousarray(points[order], dtype=np.float64)
        count = len(points)
        face, place, signed = np.empty(count, np.int64), np.empty(count, np.int64), np.empty(count)
        weight, xyz, normal = (np.empty((count, 3)) for _ in range(3))
        parts = np.linspace(0, count, (_AT_ONCE if count > _MANY else 1) + 1).astype(np.int64)
        mesh = (self.xyz, self._faces, self._across, self._unit, self._at_corner)

        def search(part: int) -> None:
            here = slice(parts[part], parts[part + 1])
            found = (face[here], weight[here], place[here])
            find_nearest(sorted_points[here], self._corners, self._boxes, *found)
            find_places(sorted_points[here], mesh, *found, xyz[here], normal[here], signed[here])

        with ThreadPoolExecutor(_AT_ONCE) as pool:
            list(pool.map(search, range(len(parts) - 1)))
        back = np.empty_like(order)
        back[order] = np.arange(count)
        return Nearest(xyz[back], self._order[face[back]], weight[back], normal[back], signed[back])


def _tree_order(middle: Floats, leaves: int) -> Ints:
    """The faces `(m,)` in the order of a balanced tree; both halves are sorted at once."""
    order, width = np.arange(len(middle)), leaves * LEAF
    cut = width // 2
    halve(middle, order, 0, len(order), cut)
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        halves = ((middle[part], order[part], cut) for part in (slice(0, cut), slice(cut, None)))
        list(pool.map(lambda half: split_by_halves(*half), halves))
    return order
