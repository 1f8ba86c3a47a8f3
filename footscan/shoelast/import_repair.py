"""From what a digitiser leaves to one outward surface: fragments joined, crumbs dropped, windings turned."""

from dataclasses import dataclass, field

import numpy as np
import trimesh

from footscan.coordinates import Floats, Ints
from footscan.errors import MeshError
from footscan.shoelast.crossing_faces import crossing_faces
from footscan.shoelast.mesh_topology import (
    consistent,
    edge_names,
    face_normals,
    pieces,
    rims,
    unique_rows,
)
from footscan.shoelast.seams import with_closed_seams

_WELD_MM, _SEAM_MM = 0.02, 0.05
_SHARED = 0.2
"""A file with more pieces per face shares no vertices at all, as STL: its pieces say nothing."""
_CRUMB_SHARE = 0.004
"""Of the area of the largest piece: less is a crumb, more a body of its own (a stub, a toe centre)."""
_ANOTHER_LAST_SHARE = 0.3
_MOST_CROSSING, _SLIVER_MM = 40, 0.15
"""Narrower faces are not asked whether they cross: noise of the digitiser is enough for that."""


@dataclass(frozen=True)
class RepairedLast:
    """One surface, mostly closed, in the file's heading.

    Attributes:
        xyz: `(n, 3)` mm.
        faces: `(m, 3)` counter-clockwise seen from outside.
        bodies: Other bodies that came with it.
        remarks: What was changed.
    """

    xyz: Floats
    faces: Ints
    bodies: tuple[trimesh.Trimesh, ...] = ()
    remarks: tuple[str, ...] = field(default=())


def repair_last(mesh: trimesh.Trimesh) -> RepairedLast:
    """Join, clean and orient.

    Raises:
        MeshError: Nothing is left, or it holds several lasts.
    """
    remarks: list[str] = []
    xyz, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)
    finite = np.logical_and.reduce(np.isfinite(xyz), axis=1)
    placed = finite[faces].all(axis=1)
    if not placed.all():
        remarks.append(f"{int((~placed).sum())} faces with corners that have no place (NaN) were left out")
    faces = faces[placed]
    if len(faces) < 500:
        raise MeshError(f"{len(faces)} triangles are no digitised last, which has thousands; export it finer.")
    loose = pieces(faces)[0]
    xyz, faces = _exactly_joined(np.where(np.isfinite(xyz), xyz, 0.0), faces)
    faces = _single(faces, remarks)
    before = loose if loose < _SHARED * len(faces) else pieces(faces)[0]
    xyz, faces = with_closed_seams(xyz, faces, _WELD_MM, _SEAM_MM)
    faces = _single(faces, remarks)
    joined = pieces(faces)[0]
    faces = _manifold(xyz, faces, remarks)
    if joined < before:
        remarks.append(f"{before} loose fragments were joined into {joined}")
    faces, bodies = _bodies(xyz, faces, remarks)
    faces, turned = consistent(faces)
    if turned:
        remarks.append(f"{turned} faces that were turned against their neighbours were turned round")
    if _volume(xyz, faces) < 0:
        faces = np.ascontiguousarray(faces[:, ::-1])
        remarks.append("the faces pointed inwards and were turned outwards")
    xyz, faces = _compact(xyz, faces)
    return RepairedLast(xyz, faces, bodies, tuple(remarks))


def _exactly_joined(xyz: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Vertices at the very same place as one, as STL repeats them for every face."""
    _, first, place = unique_rows(xyz)
    joined = place[faces]
    return xyz[first], joined[(joined != np.roll(joined, 1, axis=1)).all(axis=1)]


def check_crossings(xyz: Floats, faces: Ints) -> tuple[str, ...]:
    """Refuse a mesh that passes through itself; a few crossing faces are told.

    Raises:
        MeshError: More than a few faces cross others.
    """
    edge = np.linalg.norm(xyz[faces] - xyz[np.roll(faces, 1, axis=1)], axis=2).max(axis=1)
    faces = faces[2.0 * face_normals(xyz, faces)[1] > _SLIVER_MM * edge]
    crossing = crossing_faces(xyz, faces)
    count = int(crossing.sum())
    if count > _MOST_CROSSING:
        at = xyz[faces[crossing]].reshape(-1, 3).mean(axis=0)
        raise MeshError(
            f"the surface passes through itself: {count} faces cross others, in the middle about {at[0]:.0f} mm from "
            f"the heel and {at[2]:.0f} mm high; repair it in the program it came from and export it again."
        )
    return (f"{count} faces cross others; they were left as they are",) if count else ()


def _single(faces: Ints, remarks: list[str]) -> Ints:
    low, middle, high = np.sort(faces, axis=1).T
    size = int(faces.max()) + 1
    _, first = np.unique((low * size + middle) * size + high, return_index=True)
    if len(first) < len(faces):
        remarks.append(f"{len(faces) - len(first)} duplicate faces were left out")
    return faces[np.sort(first)]


def _manifold(xyz: Floats, faces: Ints, remarks: list[str]) -> Ints:
    """Drop fins: of the faces on an edge with more than two, those with a free edge, then the smallest."""
    dropped = 0
    for _ in range(20):
        _, name = edge_names(faces)
        count = np.bincount(name)
        crowded = (count[name] > 2).reshape(-1, 3).any(axis=1)
        if not crowded.any():
            break
        free = (count[name] == 1).reshape(-1, 3).any(axis=1)
        bad = crowded & free
        if not bad.any():
            area = face_normals(xyz, faces)[1]
            at = np.repeat(np.arange(len(faces)), 3)
            order = np.lexsort((area[at], name))
            smallest = order[np.concatenate([[True], np.diff(name[order]) > 0])]
            bad = np.zeros(len(faces), dtype=np.bool_)
            bad[at[smallest[count[name[smallest]] > 2]]] = True
        dropped += int(bad.sum())
        faces = faces[~bad]
    if dropped:
        remarks.append(f"{dropped} faces on edges with more than two faces were left out")
    return faces


def _bodies(xyz: Floats, faces: Ints, remarks: list[str]) -> tuple[Ints, tuple[trimesh.Trimesh, ...]]:
    count, label = pieces(faces)
    area = np.bincount(label, weights=face_normals(xyz, faces)[1], minlength=count)
    largest = int(area.argmax())
    share = area / area[largest]
    large = np.flatnonzero(share > _ANOTHER_LAST_SHARE)
    if len(large) > 1:
        raise MeshError(f"{len(large)} large separate bodies: one last at a time; save each as a file of its own.")
    crumbs = share < _CRUMB_SHARE
    if crumbs.any():
        remarks.append(f"{int(crumbs.sum())} loose crumbs ({area[crumbs].sum():.0f} mm2) were left out")
    others = [k for k in np.flatnonzero(~crumbs) if k != largest]
    bodies = tuple(trimesh.Trimesh(*_compact(xyz, faces[label == k]), process=False) for k in others)
    return faces[label == largest], bodies


def _compact(xyz: Floats, faces: Ints) -> tuple[Floats, Ints]:
    used, place = np.unique(faces, return_inverse=True)
    return xyz[used], place.reshape(-1, 3).astype(np.int64)


def _volume(xyz: Floats, faces: Ints) -> float:
    a, b, c = (xyz[faces[:, k]] - xyz.mean(axis=0) for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def without_holes(xyz: Floats, faces: Ints) -> tuple[Floats, Ints, list[Floats]]:
    """Close every rim by a fan; also the rims `(k, 3)`. The vertices of the fans are the last ones, one per rim."""
    found = rims(faces)
    middles = [xyz[rim].mean(axis=0) for rim in found]
    fans = [np.stack([rim, np.roll(rim, -1), np.full(len(rim), len(xyz) + k)], axis=1) for k, rim in enumerate(found)]
    closed = np.vstack([xyz, *[middle[None] for middle in middles]])
    return closed, np.ascontiguousarray(np.vstack([faces, *fans])), [xyz[rim] for rim in found]
