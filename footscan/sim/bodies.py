"""Bodies with an exact formula: sphere, plate, cylinder."""

import numpy as np

from footscan.coordinates import Floats
from footscan.sim.surface import Surface, grid_faces, surface_from_trimesh


def build_sphere(radius_mm: float, centre_world: Floats, subdivisions: int = 5) -> Surface:
    """A sphere of flat facets whose corners lie on it (5 subdivisions: 20,480 facets, 0.0006 of the radius inside)."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius_mm)
    ball.apply_translation(centre_world)
    return surface_from_trimesh(ball)


def build_plate(
    centre_world: Floats,
    normal: Floats,
    half_mm: float,
    step_mm: float = 5.0,
    along: Floats | None = None,
    half_across_mm: float | None = None,
) -> Surface:
    """A flat plate without thickness, seen from either side.

    Args:
        centre_world: Its middle.
        normal: `(3,)` across it.
        half_mm: From its middle to its ends.
        step_mm: Between its vertices.
        along: `(3,)` unit vector of its long side, square to the normal; any if not given.
        half_across_mm: From its middle to its long sides; a square plate if not given.
    """
    up = normal / np.linalg.norm(normal)
    one, two = _across(up) if along is None else (along, np.cross(up, along))
    halves = half_mm, half_mm if half_across_mm is None else half_across_mm
    rows, columns = (int(np.ceil(2.0 * half / step_mm)) + 1 for half in halves)
    sides = np.linspace(-halves[0], halves[0], rows), np.linspace(-halves[1], halves[1], columns)
    s, t = (axis.ravel() for axis in np.meshgrid(*sides, indexing="ij"))
    xyz_world = centre_world + s[:, None] * one + t[:, None] * two
    return Surface(np.ascontiguousarray(xyz_world), grid_faces(rows, columns), closed=False)


def build_cylinder(radius_mm: float, height_mm: float) -> Surface:
    """An upright cylinder about the axis, standing on the board, with a flat top.

    It has 240 flat staves whose edges lie on it; between them they are up to 0.00009 of the radius inside.
    """
    wall = np.linspace(0.0, height_mm, int(np.ceil(height_mm / 5.0)) + 1)
    rim = np.linspace(0.0, radius_mm, int(np.ceil(radius_mm / 5.0)) + 1)[1:]
    radius = np.concatenate([rim[:-1], np.full(len(wall), radius_mm), rim[-2::-1]])
    height = np.concatenate([np.zeros(len(rim) - 1), wall, np.full(len(rim) - 1, height_mm)])
    return turned_body(radius, height, sections=240)


def turned_body(radius_mm: Floats, height_mm: Floats, sections: int) -> Surface:
    """A body turned on a lathe: rings of these radii and heights from the bottom up, closed by a fan at either end."""
    angle = np.arange(sections) * (2.0 * np.pi / sections)
    x, y = (np.outer(radius_mm, wave).ravel() for wave in (np.cos(angle), np.sin(angle)))
    rings = np.column_stack([x, y, np.repeat(height_mm, sections)])
    ends = np.array([[0.0, 0.0, height_mm[0]], [0.0, 0.0, height_mm[-1]]])
    here, ahead = np.arange(sections), (np.arange(sections) + 1) % sections
    row = (np.arange(len(radius_mm) - 1) * sections)[:, None]
    a, b, c, d = ((row + side).ravel() for side in (here, ahead, ahead + sections, here + sections))
    bottom, top = np.full(sections, len(rings)), np.full(sections, len(rings) + 1)
    last = (len(radius_mm) - 1) * sections
    parts = [(a, b, c), (a, c, d), (bottom, ahead, here), (top, last + here, last + ahead)]
    faces = np.concatenate([np.stack(part, axis=1) for part in parts])
    return Surface(np.concatenate([rings, ends]), np.ascontiguousarray(faces))


def _across(up: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors that make a right-handed system with `up`."""
    x, y, z = up
    one = np.array([z, 0.0, -x]) if abs(y) < 0.9 else np.array([0.0, z, -y])
    one = one / np.sqrt(one @ one)
    two = np.array([y * one[2] - z * one[1], z * one[0] - x * one[2], x * one[1] - y * one[0]])
    return one, two
