"""What a foot asks of a last: at every judged place of its skin, how far the upper has to move out, or may move in."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats, Ints
from footscan.foot.nurbs_fit import evaluate_at
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.geometry.nearest import PointTree
from footscan.shoelast.chart import Chart, project
from footscan.shoelast.skin import LastSkin

_START_V = 0.004
_LEAST_SLOPE = 0.35
_FAR_MM, _DEEP_MM, _EDGE_MM, _MOST_TIMES = 25.0, 8.0, 1.0, 4.0
"""A place further away, or deeper inside, asks nothing of the upper; nor does one whose way along a direction does not
agree with its distance: it has met another part of the surface."""

CELLS = (256, 128)
"""Of the places in one of so many cells around and up the upper, the one that asks most speaks for all."""


@dataclass(frozen=True)
class Room:
    """What is wanted of places of skin, `(n,)` each: least and most clearance, most material the last may lose."""

    least_mm: Floats
    most_mm: Floats
    loss_mm: Floats

    def of(self, mask: Bools | Ints) -> "Room":
        """Some of them."""
        return Room(self.least_mm[mask], self.most_mm[mask], self.loss_mm[mask])


@dataclass(frozen=True)
class Need:
    """Places of skin followed along the chart's directions to the upper, `(n,)` each.

    Attributes:
        u: Where they meet the upper.
        v: Likewise.
        move_mm: Least displacement there, negative where the last could lose as much.
        hold_mm: Displacement at which the clearance is the most wanted; the last should not stand further off.
        loss_mm: Most material the last may lose there.
        known: Whether the place was reached along a direction.
    """

    u: Floats
    v: Floats
    move_mm: Floats
    hold_mm: Floats
    loss_mm: Floats
    known: Bools

    def of(self, which: Bools | Ints) -> "Need":
        """Some of them."""
        return Need(
            self.u[which],
            self.v[which],
            self.move_mm[which],
            self.hold_mm[which],
            self.loss_mm[which],
            self.known[which],
        )


def find_need(chart: Chart, skin: LastSkin, mesh: DistanceMesh, xyz: Floats, room: Room) -> tuple[Need, Floats]:
    """Follow places of skin to the upper of a last.

    Args:
        chart: Of the last as `skin` shows it: its `tube` is the upper that `skin` samples.
        skin: Its mesh.
        mesh: The same, for distances.
        xyz: `(n, 3)` places.
        room: Wanted there.

    Returns:
        The need, as displacements from this upper, and the signed distances `(n,)` (negative inside).
    """
    near = mesh.nearest(xyz)
    u, v = parameters_at(skin, near.face, near.weight, near.xyz)
    u, v, along = project(chart, chart.tube, xyz, u, np.clip(v, _START_V, 1.0 - _START_V))
    here, way = evaluate_at(chart.tube, u, v), evaluate_at(chart.direction, u, v)
    normal = np.cross(here.along_v, here.along_u)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    slope = np.maximum((normal * way.xyz_mm).sum(axis=1), _LEAST_SLOPE)
    same_side = (along > 0.0) == (near.signed > 0.0)
    agreeing = (same_side | (np.abs(along) < _EDGE_MM)) & (np.abs(along) < _MOST_TIMES * np.abs(near.signed) + _EDGE_MM)
    known = np.isfinite(along) & (np.abs(along) < _FAR_MM) & (near.signed > -_DEEP_MM) & agreeing
    along = np.where(known, along, 0.0)
    return Need(u, v, along + room.least_mm / slope, along + room.most_mm / slope, room.loss_mm, known), near.signed


def worst_per_cell(need: Need, shape: tuple[int, int]) -> Need:
    """Of all places in one small cell of the chart, the one that asks most."""
    around, up = CELLS
    cell = np.floor(need.u * around).astype(np.int64) * up + np.floor(np.minimum(need.v, 1.0 - 1e-9) * up).astype(
        np.int64
    )
    order = np.lexsort((-np.where(need.known, need.move_mm, -np.inf), cell))
    first = order[np.concatenate([[True], np.diff(cell[order]) > 0])]
    return need.of(first)


def parameters_at(skin: LastSkin, face: Ints, weight: Floats, xyz: Floats) -> tuple[Floats, Floats]:
    """Parameters (u, v) `(n,)` of places on the mesh; places on bottom or cone top get those of the nearest edge."""
    corner = skin.faces[face]
    on_upper = corner.max(axis=1) < len(skin.uv)
    uv = skin.uv[np.where(on_upper[:, None], corner, 0)]
    u = uv[:, :, 0]
    u = np.where(u.max(axis=1, keepdims=True) - u > 0.5, u + 1.0, u)
    found_u, found_v = (weight * u).sum(axis=1), (weight * uv[:, :, 1]).sum(axis=1)
    if not on_upper.all():
        off = np.flatnonzero(~on_upper)
        found_u[off], found_v[off] = _on_nearest_edge(skin, xyz[off])
    return np.mod(found_u, 1.0), found_v


def _on_nearest_edge(skin: LastSkin, xyz: Floats) -> tuple[Floats, Floats]:
    edge = np.flatnonzero((skin.uv[:, 1] == 0.0) | (skin.uv[:, 1] == 1.0))
    which = PointTree(skin.xyz_shoelast[edge]).nearest(xyz, 1)[1][:, 0]
    return skin.uv[edge[which], 0], skin.uv[edge[which], 1]
