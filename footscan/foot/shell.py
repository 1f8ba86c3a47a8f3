"""The foot as plain arrays: what sections and measurements work on."""

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from footscan.coordinates import Bools, Bytes, Floats, Ints
from footscan.foot.skin_origin import Origin

NEVER_SEEN_BELOW_MM = 8.0
"""Without a known origin, skin lower than this is taken as not seen (ray-cast: 35 % seen at 4-6 mm, 70 % at
8-10 mm)."""


@dataclass(frozen=True)
class Shell:
    """Triangles with the origin of their skin.

    `xyz` is `(n, 3)` in mm, `faces` `(m, 3)` counter-clockwise seen from outside, `origin` `(n,)` (values of
    `Origin`) or None when unknown.
    """

    xyz: Floats
    faces: Ints
    origin: Bytes | None = None

    @property
    def seen(self) -> Bools:
        """`(n,)`: skin that was seen; without a known origin, skin above `NEVER_SEEN_BELOW_MM`."""
        return self.xyz[:, 2] > NEVER_SEEN_BELOW_MM if self.origin is None else self.origin == Origin.SEEN


def shell_from_mesh(mesh: trimesh.Trimesh) -> Shell:
    """The arrays of a mesh; the attribute `origin` is taken over where it fits the vertices."""
    xyz = np.ascontiguousarray(mesh.vertices, dtype=np.float64)
    faces = np.ascontiguousarray(mesh.faces, dtype=np.int64)
    origin = mesh.vertex_attributes.get("origin")
    if origin is None or np.size(origin) != len(xyz):
        return Shell(xyz, faces)
    return Shell(xyz, faces, np.ascontiguousarray(origin, dtype=np.uint8).reshape(-1))


def mesh_from_shell(shell: Shell) -> trimesh.Trimesh:
    """A trimesh of the arrays, with the attribute `origin` where it is known."""
    attributes: dict[str, ArrayLike] = {} if shell.origin is None else {"origin": shell.origin}
    return trimesh.Trimesh(shell.xyz, shell.faces, process=False, vertex_attributes=attributes)


def moved(shell: Shell, transform: Floats) -> Shell:
    """The shell under a 4x4 with rotation, reflection and shift; a reflection turns the faces to stay outward."""
    xyz = shell.xyz @ transform[:3, :3].T + transform[:3, 3]
    faces = shell.faces if np.linalg.det(transform[:3, :3]) > 0 else np.ascontiguousarray(shell.faces[:, ::-1])
    return Shell(xyz, faces, shell.origin)


def compact(shell: Shell) -> Shell:
    """The shell without vertices that no face uses."""
    used = np.zeros(len(shell.xyz), dtype=np.bool_)
    used[shell.faces.ravel()] = True
    if used.all():
        return shell
    number = np.cumsum(used) - 1
    return Shell(shell.xyz[used], number[shell.faces], None if shell.origin is None else shell.origin[used])


def area_mm2(shell: Shell) -> Floats:
    """`(m,)` area of every face."""
    a, b, c = (shell.xyz[shell.faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    return 0.5 * np.sqrt(np.einsum("ij,ij->i", across, across))


def volume_mm3(shell: Shell, apex: Floats) -> float:
    """Signed volume between the faces and `apex` `(3,)`; an opening in a plane through the apex adds nothing."""
    a, b, c = (shell.xyz[shell.faces[:, k]] - apex for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
