"""Things to put on the board: the built-in foot, artefacts with an exact formula, and meshes from files."""

from pathlib import Path

import numpy as np
import trimesh

from footscan.coordinates import WORKING_RADIUS_MM, Floats, Side
from footscan.errors import InputError
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import Surface, grid_faces, load_surface, stand_on_board, surface_from_trimesh

OBJECT_NAMES = ("foot", "sphere", "ball-bar", "plane", "cylinder")


def build_object(name: str, unit: str = "mm", side: Side = "left", size: float = 1.0) -> Surface:
    """A named object, or a mesh file put on the board with the middle of its outline on the axis.

    Args:
        name: One of `OBJECT_NAMES`, or the path of a mesh file.
        unit: Of the file: mm, cm or m.
        side: Of the built-in foot.
        size: Of the built-in foot.

    Raises:
        InputError: No such object or file, or a size or unit that does not fit.
    """
    match name:
        case "foot":
            return build_foot(FootShape(side, size))
        case "sphere":
            return build_sphere(30.0, np.array([0.0, 0.0, 60.0]))
        case "ball-bar":
            return build_ball_bar(20.0, 150.0)
        case "plane":
            return build_plate(np.array([0.0, 0.0, 100.0]), np.array([0.5, 0.2, 0.842]), 90.0)
        case "cylinder":
            return build_cylinder(40.0, 120.0)
        case _:
            return _within_reach(stand_on_board(load_surface(Path(name), unit)), name)


def _within_reach(surface: Surface, name: str) -> Surface:
    reach_mm = float(np.hypot(surface.xyz_world[:, 0], surface.xyz_world[:, 1]).max())
    if reach_mm > WORKING_RADIUS_MM:
        raise InputError(
            f"{name} spans {reach_mm:.0f} mm from the axis; at most {WORKING_RADIUS_MM:.0f} mm is seen; check --unit."
        )
    return surface


def build_sphere(radius_mm: float, centre_world: Floats, subdivisions: int = 5) -> Surface:
    """A sphere of flat facets whose corners lie on it (5 subdivisions: 20,480 facets, 0.0006 of the radius inside)."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius_mm)
    ball.apply_translation(centre_world)
    return surface_from_trimesh(ball)


def build_ball_bar(radius_mm: float, spacing_mm: float, height_mm: float = 60.0) -> Surface:
    """Two spheres whose centres lie `spacing_mm` apart along x; the thin bar between them is left out."""
    half = spacing_mm / 2.0
    balls = [build_sphere(radius_mm, np.array([x, 0.0, height_mm])) for x in (-half, half)]
    faces = np.concatenate([balls[0].faces, balls[1].faces + len(balls[0].xyz_world)])
    return Surface(np.concatenate([ball.xyz_world for ball in balls]), faces)


def build_plate(centre_world: Floats, normal: Floats, half_mm: float, step_mm: float = 5.0) -> Surface:
    """A square flat plate without thickness, `half_mm` from its middle to its edges; seen from either side."""
    one, two = _across(normal / np.linalg.norm(normal))
    count = int(np.ceil(2.0 * half_mm / step_mm)) + 1
    s, t = (axis.ravel() for axis in np.meshgrid(*[np.linspace(-half_mm, half_mm, count)] * 2, indexing="ij"))
    xyz_world = centre_world + s[:, None] * one + t[:, None] * two
    return Surface(np.ascontiguousarray(xyz_world), grid_faces(count, count), closed=False)


def build_cylinder(radius_mm: float, height_mm: float) -> Surface:
    """An upright cylinder about the axis, standing on the board, with a flat top.

    It has 240 flat staves whose edges lie on it; between them they are up to 0.00009 of the radius inside.
    """
    wall = np.linspace(0.0, height_mm, int(np.ceil(height_mm / 5.0)) + 1)
    rim = np.linspace(0.0, radius_mm, int(np.ceil(radius_mm / 5.0)) + 1)[1:]
    radius = np.concatenate([rim[:-1], np.full(len(wall), radius_mm), rim[-2::-1]])
    height = np.concatenate([np.zeros(len(rim) - 1), wall, np.full(len(rim) - 1, height_mm)])
    return _turned(radius, height, sections=240)


def _turned(radius_mm: Floats, height_mm: Floats, sections: int) -> Surface:
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
