"""Two clouds of the same skin against each other: how far each point lies from the other cloud's smooth surface."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats, Ints
from footscan.geometry.nearest import PointTree

_NEIGHBOURS = 24
_FEWEST = 9
_SPREAD_SHARE = 0.15  # of the farthest neighbour's distance: neighbours on one line fix no surface
_BESIDE_SHARE = 0.4  # of the same: a point outside its neighbours would be judged by extrapolation
_RIDGE = 3e-3
_ROUGHEST_MM = 0.6


@dataclass(frozen=True)
class Facing:
    """Points that face the other cloud's surface.

    Attributes:
        index: `(n,)` which of the asked points.
        other: `(n,)` the nearest point of the other cloud.
        distance_mm: `(n,)` of the point above the other surface, outward positive.
        normal: `(n, 3)` outward unit normals of the other surface there.
        scatter_mm: `(n,)` RMS of the other cloud's points around their own surface.
    """

    index: Ints
    other: Ints
    distance_mm: Floats
    normal: Floats
    scatter_mm: Floats

    def where(self, keep: Bools) -> "Facing":
        """The points for which `keep` `(n,)` holds."""
        return Facing(
            self.index[keep], self.other[keep], self.distance_mm[keep], self.normal[keep], self.scatter_mm[keep]
        )


def find_facing(xyz: Floats, outward: Floats, tree: PointTree, xyz_other: Floats, reach_mm: float) -> Facing:
    """Heights of `(n, 3)` points over the quadratic surfaces through their neighbours in another cloud.

    Args:
        xyz: Points to judge.
        outward: `(n, 3)` directions that point out of the foot there, of any length.
        tree: Search tree over `xyz_other`.
        xyz_other: `(m, 3)` the other cloud.
        reach_mm: Radius of a neighbourhood; it should hold three stripes.
    """
    distance, index = tree.nearest(xyz, min(_NEIGHBOURS, len(xyz_other)), reach_mm)
    enough = np.flatnonzero(np.isfinite(distance).sum(axis=1) >= _FEWEST)
    found = np.isfinite(distance[enough])
    near = xyz_other[np.where(found, index[enough], 0)] - xyz[enough][:, None]
    weight = np.where(found, (1.0 - np.minimum(distance[enough] / reach_mm, 1.0) ** 2) ** 2 + 1e-3, 0.0)
    share = weight / weight.sum(axis=1, keepdims=True)
    farthest = np.where(found, distance[enough], 0.0).max(axis=1)
    height, normal, scatter, good = _over_quadratic(near, share, farthest)
    sign = np.sign(np.einsum("nd,nd->n", normal, outward[enough]) + 1e-12)
    height, normal = height * sign, normal * sign[:, None]
    kept = enough[good]
    return Facing(kept, index[kept, 0], height[good], normal[good], scatter[good])


def _over_quadratic(near: Floats, share: Floats, farthest_mm: Floats) -> tuple[Floats, Floats, Floats, Bools]:
    """Heights of the origin over `(n, k, 3)` neighbours, normals there, scatter, and which to trust."""
    centre = np.einsum("nk,nkd->nd", share, near)
    offset = near - centre[:, None]
    variance, axes = np.linalg.eigh(np.swapaxes(offset * share[..., None], 1, 2) @ offset)
    local = (near @ axes) / farthest_mm[:, None, None]  # (up, across, along), from the origin
    up, s, t = local[..., 0], local[..., 1], local[..., 2]
    terms = np.stack([np.ones_like(s), s, t, s * s, s * t, t * t], axis=-1)
    shared = np.swapaxes(terms * share[..., None], 1, 2)
    matrix = shared @ terms + _RIDGE * np.diag([1e-4, 1e-2, 1e-2, 1.0, 1.0, 1.0])
    solved = np.linalg.solve(matrix, shared @ up[..., None])[..., 0]
    steep = np.sqrt(1.0 + solved[:, 1] ** 2 + solved[:, 2] ** 2)
    height = -farthest_mm * solved[:, 0] / steep
    tilted = np.stack([np.ones_like(steep), -solved[:, 1], -solved[:, 2]], axis=1) / steep[:, None]
    normal = np.einsum("nde,ne->nd", axes, tilted)
    residual = farthest_mm[:, None] * (up - (terms @ solved[..., None])[..., 0])
    scatter = np.sqrt(np.einsum("nk,nk->n", share, residual**2))
    beside = np.linalg.norm(np.einsum("nd,nde->ne", centre, axes)[:, 1:], axis=1)
    spread = np.sqrt(np.maximum(variance[:, 1], 0.0))
    good = (spread > _SPREAD_SHARE * farthest_mm) & (beside < _BESIDE_SHARE * farthest_mm) & (scatter < _ROUGHEST_MM)
    return height, normal, scatter, good
