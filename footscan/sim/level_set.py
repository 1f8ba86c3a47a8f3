"""The surface field = 0 as a triangle mesh: surface nets (Gibson 1998) on a grid, then drawn onto the field exactly."""

from collections.abc import Callable

import numpy as np

from footscan.coordinates import Floats, Ints
from footscan.sim.surface import Surface

Field = Callable[[Floats], Floats]
"""`(n, 3)` places to `(n,)` values, negative inside, about as steep as a distance in mm."""

_CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
_EDGES = np.array([(a, b) for a in range(8) for b in range(a + 1, 8) if np.sum(np.abs(_CORNERS[a] - _CORNERS[b])) == 1])


def mesh_field(field: Field, low_mm: Floats, high_mm: Floats, step_mm: float, polish: int = 4) -> Surface:
    """Mesh the level field = 0 inside a box that holds all of it.

    Args:
        field: The implicit surface.
        low_mm: `(3,)` corner of the box.
        high_mm: `(3,)` opposite corner.
        step_mm: Grid step; the edges of the mesh are about as long.
        polish: Newton steps that draw the vertices onto the surface.

    Returns:
        A closed surface with outward normals, where the grid resolves the shape.
    """
    counts = np.ceil((high_mm - low_mm) / step_mm).astype(np.int64) + 1
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), axis=-1)
    values = field(low_mm + step_mm * grid.reshape(-1, 3)).reshape(tuple(counts))
    cell, place = _vertices(values)
    faces = _faces(values, cell)
    xyz = low_mm + step_mm * place
    for _ in range(polish):
        xyz = _drawn_onto(field, xyz, step_mm)
    return Surface(np.ascontiguousarray(xyz), faces)


def is_closed(faces: Ints) -> bool:
    """Whether every edge of `(m, 3)` faces is shared by exactly two that run through it in opposite directions.

    A grid cell that two sheets of the surface cross gives an edge of four faces; another grid then helps.
    """
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    key, back = edges[:, 0] * (faces.max() + 1) + edges[:, 1], edges[:, 1] * (faces.max() + 1) + edges[:, 0]
    return len(np.unique(key)) == len(key) and bool(np.array_equal(np.sort(key), np.sort(back)))


def _vertices(values: Floats) -> tuple[Ints, Floats]:
    """One vertex per grid cell that the surface crosses: the mean of the crossings of its edges (grid units)."""
    size = np.array(values.shape) - 1
    corner = np.stack([values[i : size[0] + i, j : size[1] + j, k : size[2] + k] for i, j, k in _CORNERS], axis=-1)
    crossed = np.argwhere((corner < 0.0).any(axis=-1) & (corner >= 0.0).any(axis=-1))
    value = corner[tuple(crossed.T)]
    a, b = value[:, _EDGES[:, 0]], value[:, _EDGES[:, 1]]
    cut = (a < 0.0) != (b < 0.0)
    t = np.where(cut, a / np.where(cut, a - b, 1.0), 0.0)
    start, along = _CORNERS[_EDGES[:, 0]], _CORNERS[_EDGES[:, 1]] - _CORNERS[_EDGES[:, 0]]
    crossing = start[None] + t[..., None] * along[None]
    place = crossed + np.sum(crossing * cut[..., None], axis=1) / cut.sum(axis=1)[:, None]
    cell = np.full(tuple(size), -1, dtype=np.int64)
    cell[tuple(crossed.T)] = np.arange(len(crossed))
    return cell, place


def _faces(values: Floats, cell: Ints) -> Ints:
    """Two triangles around each grid edge that the surface crosses, from the four cells that share it."""
    quads: list[Ints] = []
    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        ahead = np.moveaxis(values, (axis, one, two), (0, 1, 2))
        inside, outside = ahead[:-1] < 0.0, ahead[1:] < 0.0
        n, i, j = np.nonzero((inside != outside)[:, 1:-1, 1:-1])
        cells = np.moveaxis(cell, (axis, one, two), (0, 1, 2))
        around = np.stack([cells[n, i, j], cells[n, i + 1, j], cells[n, i + 1, j + 1], cells[n, i, j + 1]], axis=1)
        outward = inside[n, i + 1, j + 1]
        quads.append(np.where(outward[:, None], around, around[:, ::-1]))
    quad = np.concatenate(quads)
    return np.ascontiguousarray(np.concatenate([quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]]))


def _drawn_onto(field: Field, xyz: Floats, step_mm: float) -> Floats:
    probe = 0.05
    value = field(xyz)
    slope = np.stack([(field(xyz + probe * axis) - field(xyz - probe * axis)) / (2 * probe) for axis in np.eye(3)], 1)
    step = slope * (value / np.maximum(np.sum(slope**2, axis=1), 0.1))[:, None]
    length = np.linalg.norm(step, axis=1, keepdims=True)
    return xyz - step * np.minimum(1.0, 0.3 * step_mm / np.maximum(length, 1e-12))
