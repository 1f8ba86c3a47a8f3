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
"""Of the places in one of so many cells around and up the upper, the one that lacks most speaks for all."""


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
    """Follow places of skin to the upper of a last: of all in one small cell, the one that lacks most.

    Args:
        chart: Of the last as `skin` shows it: its `tube` is the upper that `skin` samples.
        skin: Its mesh.
        mesh: The same, for distances.
        xyz: `(n, 3)` places.
        room: Wanted there.

    Returns:
        The need, as displacements from this upper, and the signed distances `(n,)` of all places (negative inside).
    """
    near = mesh.nearest(xyz)
    u, v = parameters_at(skin, near.face, near.weight, near.xyz)
    some = _worst_per_cell(u, v, near.signed + room.least_mm)
    start = (u[some], np.clip(v[some], _START_V, 1.0 - _START_V))
    return _followed(chart, xyz[some], start, near.signed[some], room.of(some)), near.signed


def _worst_per_cell(u: Floats, v: Floats, lack_mm: Floats) -> Ints:
    around, up = CELLS
    cell = np.minimum(u * around, around - 1).astype(np.int64) * up + np.minimum(v * up, up - 1).astype(np.int64)
    order = np.lexsort((-lack_mm, cell))
    return order[np.concatenate([[True], np.diff(cell[order]) > 0])]


def _followed(chart: Chart, xyz: Floats, start: tuple[Floats, Floats], signed: Floats, room: Room) -> Need:
    u, v, along = project(chart, chart.tube, xyz, *start)
    here, way = evaluate_at(chart.tube, u, v), evaluate_at(chart.direction, u, v)
    normal = np.cross(here.along_v, here.along_u)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    slope = np.maximum((normal * way.xyz_mm).sum(axis=1), _LEAST_SLOPE)
    same_side = (along > 0.0) == (signed > 0.0)
    agreeing = (same_side | (np.abs(along) < _EDGE_MM)) & (np.abs(along) < _MOST_TIMES * np.abs(signed) + _EDGE_MM)
    known = np.isfinite(along) & (np.abs(along) < _FAR_MM) & (signed > -_DEEP_MM) & agreeing
    along = np.where(known, along, 0.0)
    return Need(u, v, along + room.least_mm / slope, along + room.most_mm / slope, room.loss_mm, known)


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
