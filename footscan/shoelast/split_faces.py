"""Long facets, as CAD writes them on flat places, split until every edge is short; the shape stays as it is."""

import numpy as np

from footscan.coordinates import Bools, Floats, Ints
from footscan.shoelast.mesh_topology import edge_names

LONGEST_MM = 4.0
_ROUNDS = 8


def with_short_edges(xyz: Floats, faces: Ints, longest_mm: float = LONGEST_MM) -> tuple[Floats, Ints]:
    """Halve every longer edge, in all faces that share it, again and again.

    Args:
        xyz: `(n, 3)` mm.
        faces: `(m, 3)`.
        longest_mm: Edges may be so long; 2^8 times as long ones are left longer.

    Returns:
        Vertices, the given ones first, and faces; no crack is opened.
    """
    for _ in range(_ROUNDS):
        directed, name = edge_names(faces)
        edges = directed[np.unique(name, return_index=True)[1]]
        long = np.linalg.norm(xyz[edges[:, 0]] - xyz[edges[:, 1]], axis=1) > longest_mm
        if not long.any():
            break
        middle = np.where(long, len(xyz) + np.cumsum(long) - 1, -1)
        xyz = np.vstack([xyz, 0.5 * (xyz[edges[long, 0]] + xyz[edges[long, 1]])])
        faces = _split(faces, middle[name].reshape(-1, 3))
    return xyz, faces


def _split(faces: Ints, middle: Ints) -> Ints:
    """Faces cut at the middles `(m, 3)` of their sides 01, 12, 20; -1 where a side stays."""
    parts = middle >= 0
    count = parts.sum(axis=1)
    result = [faces[count == 0]]
    for wanted in (1, 2, 3):
        here = np.flatnonzero(count == wanted)
        turn = _first_side(parts[here], wanted)
        column = (turn[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(faces[here], column, axis=1).T
        ab, bc, ca = np.take_along_axis(middle[here], column, axis=1).T
        rows = {
            1: [(a, ab, c), (ab, b, c)],
            2: [(ab, b, bc), (a, ab, bc), (a, bc, c)],
            3: [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)],
        }[wanted]
        result += [np.stack(row, axis=1) for row in rows]
    return np.ascontiguousarray(np.vstack(result))


def _first_side(parts: Bools, wanted: int) -> Ints:
    """The side `(k,)` that comes first: the cut one, or the first of two neighbouring cut ones."""
    if wanted == 1:
        return parts.argmax(axis=1)
    return (np.argmin(parts, axis=1) + 1) % 3 if wanted == 2 else np.zeros(len(parts), dtype=np.int64)
