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
    find_nearest,
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
        self._order = np.arange(len(faces))
        split_by_halves(self.xyz[faces].mean(axis=1), self._order, leaves)
        self._faces = np.ascontiguousarray(faces[self._order], dtype=np.int64)
        self._leaves = leaves
        self._across = _neighbours(self._faces, len(self.xyz))
        self._fit()

    def moved(self, xyz: Floats) -> "DistanceMesh":
        """The same faces with their corners elsewhere: much cheaper than a new tree, good while they stay near."""
        result = copy(self)
        result.xyz = np.ascontiguousarray(xyz, dtype=np.float64)
        result._fit()
        return result

    def _fit(self) -> None:
        """Boxes and normals of the corners as they are now."""
        self._boxes = build_boxes(self.xyz, self._faces, self._leaves)
        corner = self.xyz[self._faces]
        self._corners = corner.reshape(-1, 9)
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        self._unit = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        self._at_corner = corner_normals(self.xyz, self._faces, self._unit)

    def nearest(self, points: Floats) -> Nearest:
        """The nearest places of the mesh to `(n, 3)` points."""
        order = np.argsort(morton_codes(points, self._low - 64.0 * self._cell, 4.0 * self._cell), kind="stable")
        sorted_points = np.ascontiguousarray(points[order], dtype=np.float64)
        count = len(points)
        face, weight, place = np.empty(count, np.int64), np.empty((count, 3)), np.empty(count, np.int64)
        parts = np.linspace(0, count, (_AT_ONCE if count > _MANY else 1) + 1).astype(np.int64)

        def search(part: int) -> None:
            here = slice(parts[part], parts[part + 1])
            find_nearest(sorted_points[here], self._corners, self._boxes, face[here], weight[here], place[here])

        with ThreadPoolExecutor(_AT_ONCE) as pool:
            list(pool.map(search, range(len(parts) - 1)))
        xyz = np.einsum("nk,nkc->nc", weight, self.xyz[self._faces[face]])
        normal = self._pseudo_normals(face, place)
        away = sorted_points - xyz
        distance = np.linalg.norm(away, axis=1)
        signed = np.where((away * normal).sum(axis=1) >= 0.0, distance, -distance)
        back = np.empty_like(order)
        back[order] = np.arange(count)
        return Nearest(xyz[back], self._order[face[back]], weight[back], normal[back], signed[back])

    def _pseudo_normals(self, face: Ints, place: Ints) -> Floats:
        normal = self._unit[face].copy()
        for side in range(3):
            here = place == side + 1
            normal[here] += self._unit[self._across[face[here], side]]
            here = place == side + 4
            normal[here] = self._at_corner[self._faces[face[here], side]]
        return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)


def _neighbours(faces: Ints, corners: int) -> Ints:
    """The face `(m, 3)` across each side (01, 12, 20) of each face; a side without one has the face itself."""
    edge = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    low, high = edge.min(axis=1), edge.max(axis=1)
    order = np.argsort(low * corners + high, kind="stable")
    same = (low[order[1:]] == low[order[:-1]]) & (high[order[1:]] == high[order[:-1]])
    across = np.arange(len(edge)) // 3
    first, second = order[:-1][same], order[1:][same]
    across[first], across[second] = second // 3, first // 3
    return across.reshape(-1, 3)
