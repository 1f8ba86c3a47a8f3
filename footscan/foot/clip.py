"""Cutting a shell off at a height, with a flat top."""

import itertools

import numpy as np

from footscan.coordinates import Bytes, Floats, Ints
from footscan.foot.crossing import chain_segments
from footscan.foot.shell import Shell, compact
from footscan.foot.skin_origin import Origin


def cut_below(shell: Shell, height_mm: float, *, cap: bool = True) -> Shell:
    """The part of a shell below a level plane.

    Args:
        shell: Any shell; a hole in it stays a hole.
        height_mm: Height of the cut.
        cap: Whether the opening gets a flat top (`Origin.CUT`).

    Returns:
        A new shell, or the same one when nothing of it is higher.
    """
    z = shell.xyz[:, 2] - height_mm
    above = (z > 0)[shell.faces]
    count = above.sum(axis=1)
    if not count.any():
        return shell
    one, two = shell.faces[count == 1], shell.faces[count == 2]
    one = _rolled(one, np.argmax(above[count == 1], axis=1))
    two = _rolled(two, np.argmin(above[count == 2], axis=1))
    pairs = np.concatenate([one[:, [0, 1]], one[:, [0, 2]], two[:, [0, 1]], two[:, [0, 2]]])
    unique, place = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True)
    p, q, r, s = np.split(place.reshape(-1) + len(shell.xyz), np.cumsum([len(one), len(one), len(two)]))
    faces = np.concatenate(
        [
            shell.faces[count == 0],
            np.stack([p, one[:, 1], one[:, 2]], axis=1),
            np.stack([p, one[:, 2], q], axis=1),
            np.stack([two[:, 0], r, s], axis=1),
        ]
    )
    rim = np.concatenate([np.stack([p, q], axis=1), np.stack([r, s], axis=1)[:, ::-1]])
    xyz = np.concatenate([shell.xyz, _crossings(shell.xyz, z, unique)])
    origin = None if shell.origin is None else np.concatenate([shell.origin, _nearest(shell.origin, z, unique)])
    opened = Shell(xyz, faces, origin)
    return compact(close_rim(opened, rim[rim[:, 0] != rim[:, 1]], Origin.CUT) if cap else opened)


def close_rim(shell: Shell, rim: Ints, origin: int) -> Shell:
    """Fill openings by fans of triangles round the middle of each chain of rim edges.

    Args:
        shell: The open shell.
        rim: `(k, 2)` edges, directed as the new faces are to run along them.
        origin: Class of the middle of each new piece of skin; the rim keeps its own.
    """
    order, begins = chain_segments(np.ascontiguousarray(rim[:, 0]), np.ascontiguousarray(rim[:, 1]))
    loops = [rim[order[a:b]] for a, b in itertools.pairwise(begins)]
    middles = np.array([shell.xyz[loop[:, 0]].mean(axis=0) for loop in loops]).reshape(-1, 3)
    fans = [
        np.column_stack([_closed(loop), np.full(len(_closed(loop)), len(shell.xyz) + k)])
        for k, loop in enumerate(loops)
    ]
    classes = None if shell.origin is None else np.append(shell.origin, np.full(len(loops), origin, dtype=np.uint8))
    return Shell(np.concatenate([shell.xyz, middles]), np.concatenate([shell.faces, *fans]), classes)


def _closed(loop: Ints) -> Ints:
    """The chain of edges, with the edge back to its start where that is missing."""
    return loop if loop[-1, 1] == loop[0, 0] else np.vstack([loop, [loop[-1, 1], loop[0, 0]]])


def _rolled(faces: Ints, first: Ints) -> Ints:
    return np.take_along_axis(faces, (first[:, None] + np.arange(3)) % 3, axis=1)


def _crossings(xyz: Floats, z: Floats, edges: Ints) -> Floats:
    a, b = edges[:, 0], edges[:, 1]
    share = (z[a] / (z[a] - z[b]))[:, None]
    return xyz[a] + share * (xyz[b] - xyz[a])


def _nearest(origin: Bytes, z: Floats, edges: Ints) -> Bytes:
    nearer = np.abs(z[edges[:, 0]]) < np.abs(z[edges[:, 1]])
    return np.where(nearer, origin[edges[:, 0]], origin[edges[:, 1]])
