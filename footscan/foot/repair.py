"""Meshes as they come: what can be repaired is repaired and said so, what is no foot is refused."""

import itertools
from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from footscan.coordinates import Floats, Ints
from footscan.errors import MeshError
from footscan.foot.clip import close_rim
from footscan.foot.crossing import chain_segments
from footscan.foot.shell import Shell, area_mm2, compact, mesh_from_shell, shell_from_mesh, volume_mm3
from footscan.foot.skin_origin import Origin

_CRUMB_SHARE = 0.05
"""A loose piece with less than this share of the largest piece's area is dropped; a larger one is another object."""
_MERGE_MM = 1e-4
_LARGEST_HOLE_SHARE = 0.25
"""A hole whose rim is longer than this share of the horizontal extent, and is neither sole nor top, is
reported as large."""
_FLATTEST_SHARE = 0.15
"""An open sole or top has a rim whose heights differ by less than this share of the horizontal extent; a foot sawn
through has not."""
_NAMED_HOLES = 4
"""More holes than this are summed up in one remark."""


@dataclass(frozen=True)
class RepairedMesh:
    """A closed, outward mesh, and in words what was changed to get it."""

    mesh: trimesh.Trimesh
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class RepairedShell:
    """The same as arrays; `bridged` `(k,)` are the vertices in and beside holes that are neither sole nor top."""

    shell: Shell
    remarks: tuple[str, ...]
    bridged: Ints


@dataclass(frozen=True)
class _Hole:
    """An opening: the class of what closes it, its mean height and length of rim (mm), and whether it is large."""

    origin: Origin
    height_mm: float
    round_mm: float
    large: bool


def repair_mesh(mesh: trimesh.Trimesh) -> RepairedMesh:
    """Make one closed, outward surface of a mesh in mm.

    Raises:
        MeshError: Nothing is left, or the mesh holds several objects, such as two feet.
    """
    repaired = repair_shell(shell_from_mesh(mesh))
    return RepairedMesh(mesh_from_shell(repaired.shell), repaired.remarks)


def repair_shell(shell: Shell) -> RepairedShell:
    """`repair_mesh` on plain arrays."""
    bridged = np.empty(0, dtype=np.int64)
    remarks: list[str] = []
    shell = _without_bad_faces(shell, remarks)
    shell = _merged(shell)
    shell = _without_double_faces(shell, remarks)
    shell = _largest_piece(shell, remarks)
    if not _is_sound(shell):
        shell, bridged = _without_holes(_consistent(shell, remarks), remarks)
    return RepairedShell(_outward(shell, remarks), tuple(remarks), bridged)


def _without_bad_faces(shell: Shell, remarks: list[str]) -> Shell:
    finite = np.append(np.isfinite(shell.xyz).all(axis=1), False)
    known = (shell.faces >= 0) & (shell.faces < len(shell.xyz))
    good = np.logical_and.reduce(finite[np.where(known, shell.faces, -1)], axis=1)
    if not good.any():
        raise MeshError("no triangle with finite corners: nothing to measure; export the mesh again")
    bad = int((~good).sum())
    if bad:
        remarks.append(f"{bad} faces with corners that are no numbers were left out")
    return compact(Shell(shell.xyz, shell.faces[good], shell.origin))


def _merged(shell: Shell) -> Shell:
    """Join corners at one place, as STL files have them; faces that lose a corner go."""
    grid = np.round(shell.xyz / _MERGE_MM).astype(np.int64)
    grid -= grid.min(axis=0)
    span = grid.max(axis=0) + 1
    _, first, place = np.unique(
        (grid[:, 0] * span[1] + grid[:, 1]) * span[2] + grid[:, 2], return_index=True, return_inverse=True
    )
    if len(first) == len(grid):
        return shell
    faces = place.reshape(-1)[shell.faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return Shell(shell.xyz[first], faces[whole], None if shell.origin is None else shell.origin[first])


def _without_double_faces(shell: Shell, remarks: list[str]) -> Shell:
    corners = np.sort(shell.faces, axis=1)
    order = np.lexsort(corners.T)
    same = np.zeros(len(order), dtype=np.bool_)
    same[1:] = (np.diff(corners[order], axis=0) == 0).all(axis=1)
    if not same.any():
        return shell
    remarks.append(f"{int(same.sum())} duplicate faces were left out")
    return Shell(shell.xyz, shell.faces[np.sort(order[~same])], shell.origin)


def _pairs(shell: Shell) -> tuple[Ints, Ints, Ints]:
    """Directed edges `(3m, 2)`, a name for each undirected edge, and how often that name occurs."""
    edges = shell.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    low = edges.min(axis=1)
    _, name, count = np.unique(low * len(shell.xyz) + edges.sum(axis=1) - low, return_inverse=True, return_counts=True)
    return edges, name.reshape(-1), count


def _largest_piece(shell: Shell, remarks: list[str]) -> Shell:
    edge = shell.faces[:, [0, 1, 1, 2]].reshape(-1, 2)
    size = len(shell.xyz)
    graph = coo_array((np.ones(len(edge), dtype=np.bool_), (edge[:, 0], edge[:, 1])), shape=(size, size))
    count, label = connected_components(graph, directed=False)
    if count == 1:
        return shell
    piece = label[shell.faces[:, 0]]
    area = np.bincount(piece, weights=area_mm2(shell), minlength=count)
    largest = int(np.argmax(area))
    others = np.delete(area, largest)
    if others.max() > _CRUMB_SHARE * area[largest]:
        many = int((area > _CRUMB_SHARE * area[largest]).sum())
        what = "two feet, or a foot and something else" if many == 2 else "several objects"
        raise MeshError(f"{many} separate large pieces ({what}): one foot at a time; save each as a mesh of its own")
    remarks.append(f"{int((others > 0).sum())} loose pieces ({others.sum():.0f} mm2) were left out")
    return compact(Shell(shell.xyz, shell.faces[piece == largest], shell.origin))


def _is_sound(shell: Shell) -> bool:
    """Whether every edge is run along once in each direction: closed, and all faces turned alike."""
    edges = shell.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    size = len(shell.xyz)
    there = np.sort(edges[:, 0] * size + edges[:, 1])
    back = np.sort(edges[:, 1] * size + edges[:, 0])
    return bool(np.array_equal(there, back)) and bool((there[1:] != there[:-1]).all())


def _consistent(shell: Shell, remarks: list[str]) -> Shell:
    """Turn faces that run against their neighbours."""
    edges, name, count = _pairs(shell)
    forward = np.bincount(name, weights=edges[:, 0] < edges[:, 1], minlength=len(count))
    if not ((count == 2) & (forward != 1)).any():
        return shell
    mesh = trimesh.Trimesh(shell.xyz, shell.faces, process=False)
    trimesh.repair.fix_winding(mesh)
    remarks.append("faces that were turned against their neighbours were turned round")
    return Shell(shell.xyz, np.ascontiguousarray(mesh.faces, dtype=np.int64), shell.origin)


def _without_holes(shell: Shell, remarks: list[str]) -> tuple[Shell, Ints]:
    """Close all holes; also the vertices in and beside the bridged ones."""
    edges, name, count = _pairs(shell)
    rim = edges[count[name] == 1][:, ::-1]
    order, begins = chain_segments(np.ascontiguousarray(rim[:, 0]), np.ascontiguousarray(rim[:, 1]))
    holes: list[_Hole] = []
    bridged = np.zeros(len(shell.xyz) + len(begins) - 1, dtype=np.bool_)
    for a, b in itertools.pairwise(begins):
        loop = rim[order[a:b]]
        hole = _kind_of_hole(shell, shell.xyz[loop[:, 0]])
        shell = close_rim(shell, loop, hole.origin)
        holes.append(hole)
        if hole.origin == Origin.BRIDGED:
            bridged[loop.ravel()] = True
    remarks += _hole_remarks(holes)
    beside = bridged[shell.faces].any(axis=1)
    return shell, np.unique(shell.faces[beside])


def _kind_of_hole(shell: Shell, xyz_rim: Floats) -> _Hole:
    bottom, top = float(shell.xyz[:, 2].min()), float(shell.xyz[:, 2].max())
    around = float(np.linalg.norm(np.diff(xyz_rim, axis=0, append=xyz_rim[:1]), axis=1).sum())
    extent = float(np.ptp(shell.xyz[:, :2], axis=0).max())
    middle = float(xyz_rim[:, 2].mean())
    large = around > _LARGEST_HOLE_SHARE * extent
    flat = float(np.ptp(xyz_rim[:, 2])) < _FLATTEST_SHARE * extent
    origin = Origin.BRIDGED
    if flat and around > extent and middle < bottom + 0.35 * (top - bottom):
        origin = Origin.ASSUMED_SOLE
    elif flat and large and middle > bottom + 0.8 * (top - bottom):
        origin = Origin.CUT
    return _Hole(origin, middle, around, large)


def _hole_remarks(holes: list[_Hole]) -> list[str]:
    kinds = {hole.origin for hole in holes}
    words = ["the open sole was closed flat: the sole is assumed"] if Origin.ASSUMED_SOLE in kinds else []
    words += ["the open top was closed flat"] if Origin.CUT in kinds else []
    bridged = sorted((hole for hole in holes if hole.origin == Origin.BRIDGED), key=lambda hole: -hole.round_mm)
    named = bridged if len(bridged) <= _NAMED_HOLES else bridged[:1]
    where = [f"at height {hole.height_mm:.0f} mm, {hole.round_mm:.0f} mm round" for hole in named]
    if len(bridged) > _NAMED_HOLES:
        many = int(sum(hole.large for hole in bridged))
        return [*words, f"{len(bridged)} holes ({many} of them large) were closed flat, the largest {where[0]}"]
    sizes = ["a large hole" if hole.large else "a hole" for hole in named]
    return words + [f"{size} {place}, was closed flat" for size, place in zip(sizes, where, strict=True)]


def _outward(shell: Shell, remarks: list[str]) -> Shell:
    if volume_mm3(shell, shell.xyz.mean(axis=0)) >= 0:
        return shell
    remarks.append("the faces pointed inwards and were turned outwards")
    return Shell(shell.xyz, np.ascontiguousarray(shell.faces[:, ::-1]), shell.origin)
