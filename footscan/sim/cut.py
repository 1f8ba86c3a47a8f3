"""Where parallel planes cut a triangle mesh: the light curves of a laser sheet of finite width."""

from dataclasses import dataclass

import numpy as np

from footscan.compiled import compiled, compiled_inline
from footscan.coordinates import Floats, Ints


@dataclass(frozen=True)
class Cut:
    """Straight pieces of the curves in which parallel planes z_L = const cut a mesh.

    Attributes:
        pieces: `(n, 7)`: x0, y0, x1, y1 (mm, in the light system) and the face's unit normal (light system).
        face: `(n,)` index of the face each piece lies on; -1 for none.
        start: `(layers + 1,)` first piece of each layer.
    """

    pieces: Floats
    face: Ints
    start: Ints


def cut_mesh(xyz_light: Floats, faces: Ints, layers_mm: Floats) -> Cut:
    """Cut a mesh with the planes z_L = each of `layers_mm`, ascending.

    Args:
        xyz_light: `(n, 3)` vertices in the light system.
        faces: `(m, 3)` vertex indices.
        layers_mm: `(k,)` ascending distances from the middle of the sheet.

    Returns:
        Pieces in the order of the layers; neighbouring faces share the end points exactly.
    """
    candidates = np.empty(len(faces), dtype=np.int64)
    count = _faces_between(xyz_light, faces, layers_mm[0], layers_mm[-1], candidates)
    pieces = np.empty((count * len(layers_mm), 7))
    face, start = np.empty(len(pieces), dtype=np.int64), np.zeros(len(layers_mm) + 1, dtype=np.int64)
    _cut_layers(xyz_light, faces, candidates[:count], layers_mm, pieces, face, start)
    return Cut(pieces[: start[-1]], face[: start[-1]], start)


@compiled
def _faces_between(xyz: Floats, faces: Ints, low: float, high: float, candidates: Ints) -> int:
    count = 0
    for i in range(faces.shape[0]):
        a, b, c = xyz[faces[i, 0], 2], xyz[faces[i, 1], 2], xyz[faces[i, 2], 2]
        if min(a, b, c) < high and max(a, b, c) >= low:
            candidates[count] = i
            count += 1
    return count


@compiled
def _cut_layers(
    xyz: Floats, faces: Ints, candidates: Ints, layers: Floats, pieces: Floats, face: Ints, start: Ints
) -> None:
    count = 0
    for k in range(layers.shape[0]):
        start[k] = count
        for i in candidates:
            a, b, c = faces[i, 0], faces[i, 1], faces[i, 2]
            above_a, above_b, above_c = xyz[a, 2] >= layers[k], xyz[b, 2] >= layers[k], xyz[c, 2] >= layers[k]
            if above_a == above_b == above_c:
                continue
            if above_b == above_c:
                lone, second, third = a, b, c
            elif above_a == above_c:
                lone, second, third = b, c, a
            else:
                lone, second, third = c, a, b
            piece = pieces[count]
            piece[0], piece[1] = _on_edge(xyz, lone, second, layers[k])
            piece[2], piece[3] = _on_edge(xyz, lone, third, layers[k])
            face[count] = i
            if _write_normal(xyz, a, b, c, piece):
                count += 1
    start[layers.shape[0]] = count


@compiled_inline
def _on_edge(xyz: Floats, first: int, second: int, level: float) -> tuple[float, float]:
    """Where an edge crosses the level; the same number from either face, so the lower index comes first."""
    p, q = min(first, second), max(first, second)
    t = (level - xyz[p, 2]) / (xyz[q, 2] - xyz[p, 2])
    return xyz[p, 0] + t * (xyz[q, 0] - xyz[p, 0]), xyz[p, 1] + t * (xyz[q, 1] - xyz[p, 1])


@compiled_inline
def _write_normal(xyz: Floats, a: int, b: int, c: int, piece: Floats) -> bool:
    """Write the unit normal behind the end points; False for a face without area."""
    ux, uy, uz = xyz[b, 0] - xyz[a, 0], xyz[b, 1] - xyz[a, 1], xyz[b, 2] - xyz[a, 2]
    vx, vy, vz = xyz[c, 0] - xyz[a, 0], xyz[c, 1] - xyz[a, 1], xyz[c, 2] - xyz[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    if length < 1e-12:
        return False
    piece[4], piece[5], piece[6] = nx / length, ny / length, nz / length
    return True
