"""`Surface`: a triangle mesh as the simulator sees it, in world millimetres."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from footscan.coordinates import Floats, Ints
from footscan.errors import InputError

if TYPE_CHECKING:
    import trimesh

MM_PER_UNIT = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
LONGEST_EDGE_MM = 12.0
"""Longer edges are halved at loading: a straight edge is bent by the lens, and the depth picture draws it straight."""


@dataclass(frozen=True)
class Surface:
    """A triangle mesh with outward normals.

    Attributes:
        xyz_world: `(n, 3)` vertices, mm.
        faces: `(m, 3)` vertex indices, counter-clockwise seen from outside.
        closed: Whether it bounds a body; an open sheet can be lit and seen from either side.
    """

    xyz_world: Floats
    faces: Ints
    closed: bool = True

    @cached_property
    def normal_world(self) -> Floats:
        """Outward unit normals `(m, 3)` of the faces; zero for a face without area."""
        corner = self.xyz_world[self.faces]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)

    def moved(self, transform: Floats) -> "Surface":
        """The surface after a 4x4 rigid transform of the world."""
        return Surface(self.xyz_world @ transform[:3, :3].T + transform[:3, 3], self.faces, self.closed)


def surface_from_trimesh(mesh: "trimesh.Trimesh", longest_edge_mm: float = LONGEST_EDGE_MM) -> Surface:
    """Take over a mesh in millimetres; edges longer than `longest_edge_mm` are divided without moving the surface."""
    import trimesh

    vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)
    closed = bool(mesh.is_watertight) or _bounds_a_body(mesh)
    divided = trimesh.remesh.subdivide_to_size(vertices, faces, max_edge=longest_edge_mm, max_iter=20)
    xyz_world, faces = divided[:2]
    return Surface(np.ascontiguousarray(xyz_world), np.ascontiguousarray(faces, dtype=np.int64), closed)


def trimesh_from_surface(surface: Surface) -> "trimesh.Trimesh":
    """The mesh for writing to a file or for checks."""
    import trimesh

    return trimesh.Trimesh(surface.xyz_world, surface.faces, process=False)


def load_surface(path: Path, unit: str) -> Surface:
    """Read a mesh file into world millimetres; `unit` is mm, cm or m.

    Raises:
        InputError: No such file, no mesh in it, an unknown unit, or a size that no foot machine can hold.
    """
    import trimesh

    if unit not in MM_PER_UNIT:
        raise InputError(f"the unit of a mesh is mm, cm or m, found {unit!r}; say which with --unit.")
    if not path.is_file():
        raise InputError(f"there is no mesh file {path}; give an STL, PLY or OBJ file.")
    try:
        mesh = trimesh.load(path, force="mesh")
    except (ValueError, OSError, KeyError, IndexError) as err:
        raise InputError(f"{path} cannot be read as a mesh ({err}); give an STL, PLY or OBJ file.") from err
    if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
        raise InputError(f"{path} holds no triangles; give a mesh with faces.")
    mesh.apply_scale(MM_PER_UNIT[unit])
    _check_size(path, unit, mesh)
    return surface_from_trimesh(mesh)


def stand_on_board(surface: Surface) -> Surface:
    """Put the middle of the surface's outline on the axis and its lowest point on the board (z = 0)."""
    low, high = surface.xyz_world.min(axis=0), surface.xyz_world.max(axis=0)
    shift = np.eye(4)
    shift[:3, 3] = -np.array([(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0, low[2]])
    return surface.moved(shift)


def grid_faces(rows: int, columns: int) -> Ints:
    """Two triangles in each mesh of a grid of vertices, rows one after the other."""
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    first = np.stack([corner, corner + columns, corner + columns + 1], axis=1)
    second = np.stack([corner, corner + columns + 1, corner + 1], axis=1)
    return np.concatenate([first, second])


def _check_size(path: Path, unit: str, mesh: "trimesh.Trimesh") -> None:
    vertices = np.asarray(mesh.vertices)
    size_mm = np.ptp(vertices, axis=0) if np.isfinite(vertices).all() else np.full(3, np.nan)
    longest = float(size_mm.max())
    if not 5.0 <= longest <= 600.0:
        raise InputError(
            f"{path} is {longest:.3g} mm long when read in {unit}; the machine holds objects of 5 to 600 mm. "
            "Check --unit."
        )


def _bounds_a_body(mesh: "trimesh.Trimesh") -> bool:
    """Whether nearly every edge has two faces: meshes from scanners are rarely perfect."""
    edges = np.sort(np.asarray(mesh.edges), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    return float(np.mean(uses == 2)) > 0.99
