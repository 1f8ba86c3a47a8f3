"""Where a hole of the mesh interrupts feather or cone edge: the edge is led across as it runs on either side."""

import numpy as np

from footscan.coordinates import Bools, Floats, Ints

_REACH_MM = 6.0
_LONGEST_MM = 40.0


def edges_across_holes(xyz: Floats, loop: Ints, at_hole: Bools) -> tuple[Floats, float]:
    """Vertices of an edge that only run round a hole, moved to a smooth line between its good ends.

    Args:
        xyz: `(n, 3)` mm.
        loop: A closed edge, vertices in order.
        at_hole: `(n,)` vertices on the rim of a hole, or in the middle of its fan.

    Returns:
        All vertices, and how long (mm) the bridged parts are together.
    """
    runs = _runs(at_hole[loop])
    moved, total = xyz.copy(), 0.0
    for first, count in runs:
        place = (first + np.arange(count)) % len(loop)
        line = _line_across(xyz[loop], first, count)
        length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
        if length > _LONGEST_MM:
            continue
        moved[loop[place]] = line
        total += length
    return moved, total


def _runs(chosen: Bools) -> list[tuple[int, int]]:
    """First place and length of every run of at least three, round the end too; none when all are chosen."""
    if chosen.all() or not chosen.any():
        return []
    start = int(np.flatnonzero(~chosen)[0])
    turned = np.concatenate([[False], np.roll(chosen, -start), [False]]).astype(np.int64)
    begins, ends = (np.flatnonzero(np.diff(turned) == step) for step in (1, -1))
    return [(int(a + start), int(b - a)) for a, b in zip(begins, ends, strict=True) if b - a > 2]


def _line_across(places: Floats, first: int, count: int) -> Floats:
    """`(count, 3)` places of a cubic between the ends of a run, along the edge's own directions there."""
    begin, end = places[first % len(places)], places[(first + count - 1) % len(places)]
    before = _direction(places, first, -1)
    after = _direction(places, first + count - 1, 1)
    reach = float(np.linalg.norm(end - begin))
    t = np.linspace(0.0, 1.0, count)[:, None]
    return (
        (2 * t**3 - 3 * t**2 + 1) * begin
        - (t**3 - 2 * t**2 + t) * reach * before
        + (3 * t**2 - 2 * t**3) * end
        + (t**3 - t**2) * reach * after
    )


def _direction(places: Floats, at: int, step: int) -> Floats:
    """Which way `(3,)` an edge runs off from a place, outward from the run, at that place."""
    there = places[(at + step * np.arange(1, len(places) // 4)) % len(places)] - places[at % len(places)]
    walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(there, axis=0), axis=1))])
    walked = walked + np.linalg.norm(there[0])
    near = walked <= max(_REACH_MM, float(walked[1]))
    columns = np.stack([walked[near], walked[near] ** 2], axis=1)
    slope = np.linalg.lstsq(columns, there[near], rcond=None)[0][0]
    return slope / np.linalg.norm(slope)
