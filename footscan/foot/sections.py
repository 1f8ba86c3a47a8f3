"""Cuts of a foot by planes: outlines, areas, perimeters, tape girths, widths and heights, and what of them was
never seen."""

import itertools
from dataclasses import dataclass

import numpy as np
import trimesh

from footscan.coordinates import Bools, Floats, Ints
from footscan.errors import MeshError
from footscan.foot.crossing import chain_segments, convex_hull, find_crossings
from footscan.foot.shell import Shell, shell_from_mesh


@dataclass(frozen=True)
class Cut:
    """The bare crossing of a plane with a shell.

    `xyz` `(k, 2, 3)` segments, `seen` `(k, 2)` whether each end lies on seen skin, `keys` `(k, 2)` names of
    the mesh edges at the ends, equal where segments join. The body is on the left of each segment, seen from
    where the normal points.
    """

    xyz: Floats
    seen: Bools
    keys: Ints


@dataclass(frozen=True)
class Section:
    """One cut, measured. Lengths in mm; `polylines` are `(k, 3)` in the mesh's own coordinates.

    `u` is level and lies in the plane, `v` completes it (upwards unless the plane is level; then u is +x and v is +y):
    `width_mm` is the extent along u, `height_mm` along v. `hull_perimeter_mm` is what a tape reads.
    `unseen_share` is the share of the perimeter on bridged, assumed or cut skin, `hull_unseen_share` that of the tape;
    both None when the origin of the skin is unknown. `closed` is false when the mesh has a hole where it was cut.
    """

    polylines: tuple[Floats, ...]
    closed: bool
    area_mm2: float
    perimeter_mm: float
    hull_perimeter_mm: float
    width_mm: float
    height_mm: float
    centroid: Floats
    unseen_share: float | None
    hull_unseen_share: float | None
    origin: Floats
    normal: Floats


def cut_shell(shell: Shell, origin: Floats, normal: Floats) -> Cut:
    """Cross a shell with the plane through `origin` `(3,)` with unit `normal` `(3,)`."""
    distance = shell.xyz @ normal - float(origin @ normal)
    edges = find_crossings(distance, shell.faces).reshape(-1, 2)
    edges.sort(axis=1)
    low, high = edges[:, 0], edges[:, 1]
    share = distance[low] / (distance[low] - distance[high])
    xyz = shell.xyz[low] + share[:, None] * (shell.xyz[high] - shell.xyz[low])
    seen = shell.seen
    at_end = np.where(share < 0.5, seen[low], seen[high])
    key = low * len(shell.xyz) + high
    return Cut(xyz.reshape(-1, 2, 3), at_end.reshape(-1, 2), key.reshape(-1, 2))


def plane_axes(normal: Floats) -> tuple[Floats, Floats]:
    """Unit u (level) and v of a plane with unit `normal` `(3,)`; u x v = normal up to the sign that points v
    upwards."""
    level = np.array([normal[1], -normal[0], 0.0])
    size = float(np.linalg.norm(level))
    if size < 1e-6:
        return np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    u = level / size
    v = np.cross(normal, u)
    return u, v if v[2] >= 0 else -v


def measure_cut(shell: Shell, origin: Floats, normal: Floats) -> Section:
    """Cut a shell and measure the cut; `normal` is a unit vector.

    Raises:
        MeshError: The plane misses the shell.
    """
    cut = cut_shell(shell, origin, normal)
    if len(cut.xyz) == 0:
        raise MeshError("the plane does not meet the foot: give a point inside it as origin, in mm")
    axes = np.stack(plane_axes(normal), axis=1)
    uv = (cut.xyz - origin) @ axes
    polylines, closed = _polylines(cut)
    area, centre = _area_and_centroid(uv, float(np.linalg.det(np.column_stack([axes, normal]))))
    length = np.linalg.norm(cut.xyz[:, 1] - cut.xyz[:, 0], axis=1)
    around, unseen_around = _tape(uv.reshape(-1, 2), cut.seen.reshape(-1))
    unseen = float((length * (~cut.seen).mean(axis=1)).sum() / max(float(length.sum()), 1e-12))
    size = np.ptp(uv.reshape(-1, 2), axis=0)
    return Section(
        polylines=polylines,
        closed=closed,
        area_mm2=area,
        perimeter_mm=float(length.sum()),
        hull_perimeter_mm=around,
        width_mm=float(size[0]),
        height_mm=float(size[1]),
        centroid=origin + axes @ centre,
        unseen_share=None if shell.origin is None else unseen,
        hull_unseen_share=None if shell.origin is None else unseen_around / max(around, 1e-12),
        origin=np.asarray(origin, dtype=np.float64),
        normal=np.asarray(normal, dtype=np.float64),
    )


def section(mesh: trimesh.Trimesh, origin: Floats, normal: Floats) -> Section:
    """Cut a mesh (mm) by the plane through `origin` `(3,)` perpendicular to `normal` `(3,)`, any length but zero.

    Raises:
        MeshError: The plane misses the mesh, or `normal` or `origin` is no direction or point.
    """
    return measure_cut(shell_from_mesh(mesh), *checked_plane(origin, normal))


def checked_plane(origin: Floats, normal: Floats) -> tuple[Floats, Floats]:
    """`origin` and the unit `normal` as arrays `(3,)`.

    Raises:
        MeshError: Wrong shapes, numbers that are not finite, or a normal of length zero.
    """
    point, direction = np.asarray(origin, dtype=np.float64), np.asarray(normal, dtype=np.float64)
    if point.shape != (3,) or direction.shape != (3,):
        raise MeshError(f"a plane is a point and a direction of 3 numbers, found {point.size} and {direction.size}")
    size = float(np.linalg.norm(direction))
    if not (np.isfinite(point).all() and np.isfinite(size) and size > 0):
        raise MeshError("a plane needs finite numbers and a normal longer than zero")
    return point, direction / size


def plane_through_points(xyz: Floats) -> tuple[Floats, Floats]:
    """`origin` and unit `normal` of the plane through three points `(3, 3)`.

    Raises:
        MeshError: The points lie on one line.
    """
    normal = np.cross(xyz[1] - xyz[0], xyz[2] - xyz[0])
    size, scale = float(np.linalg.norm(normal)), float(np.ptp(xyz, axis=0).max())
    if not size > 1e-6 * scale**2:
        raise MeshError("three points on one line fix no plane: move one of them aside")
    return xyz.mean(axis=0), normal / size


def tape_girth_mm(shell: Shell, origin: Floats, normal: Floats) -> float:
    """Convex-hull girth of one cut; 0 when the plane misses the shell."""
    uv = cut_shell(shell, origin, normal).xyz.reshape(-1, 3) @ np.stack(plane_axes(normal), axis=1)
    return _tape(uv, np.ones(len(uv), dtype=np.bool_))[0] if len(uv) else 0.0


def _tape(uv: Floats, seen: Bools) -> tuple[float, float]:
    """Length of the hull of `(n, 2)` points, and how much of it is unseen: half of a side with one seen end."""
    corner = convex_hull(uv)
    side = np.linalg.norm(uv[np.roll(corner, -1)] - uv[corner], axis=1)
    unseen = 1.0 - (seen[corner] + 1.0 * seen[np.roll(corner, -1)]) / 2.0
    return float(side.sum()), float((side * unseen).sum())


def _area_and_centroid(uv: Floats, handedness: float) -> tuple[float, Floats]:
    """Area and centroid of oriented segments `(k, 2, 2)`; no chaining is needed (Green's theorem)."""
    middle = uv.reshape(-1, 2).mean(axis=0)
    a, b = uv[:, 0] - middle, uv[:, 1] - middle
    twice = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) * handedness
    total = float(twice.sum())
    if abs(total) < 1e-9:
        return 0.0, middle
    return total / 2.0, middle + ((a + b) * twice[:, None]).sum(axis=0) / (3.0 * total)


def _polylines(cut: Cut) -> tuple[tuple[Floats, ...], bool]:
    """The chains as points `(k, 3)`; a closed one repeats its first point at the end."""
    order, begins = chain_segments(np.ascontiguousarray(cut.keys[:, 0]), np.ascontiguousarray(cut.keys[:, 1]))
    chains = [order[a:b] for a, b in itertools.pairwise(begins)]
    lines = tuple(np.vstack([cut.xyz[chain, 0], cut.xyz[chain[-1], 1]]) for chain in chains)
    closed = all(cut.keys[chain[0], 0] == cut.keys[chain[-1], 1] for chain in chains)
    return lines, closed
