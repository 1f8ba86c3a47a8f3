"""Curves that a file brought with its last (3DM, STEP, IGES): they count before anything that is detected."""

from collections.abc import Mapping

import numpy as np

from footscan.coordinates import Floats, Ints
from footscan.geometry.nearest import PointTree

EDGES = ("feather_edge", "cone_edge")
NEAR_MM, OFF_MM = 0.4, 1.5
"""Mesh edges nearer to a curve than the first are cheap; a curve further off than the second is not used."""
_STEP_MM = 0.02


def dense_curve(xyz: Floats) -> Floats:
    """Places every 0.02 mm along a polyline `(n, 3)`."""
    step = np.linalg.norm(np.diff(xyz, axis=0), axis=1)
    walked = np.concatenate([[0.0], np.cumsum(step)])
    places = np.arange(0.0, walked[-1], _STEP_MM)
    return np.stack([np.interp(places, walked, xyz[:, k]) for k in range(3)], axis=1)


def off_curve(xyz: Floats, ends: Ints, curve: Floats | None) -> Floats:
    """How far off a dense curve mesh edges `(k, 2)` lie: 0 on it, 1 from `NEAR_MM` on and without one."""
    off = np.ones(len(xyz))
    if curve is None:
        return np.ones(len(ends))
    low, high = curve.min(axis=0) - NEAR_MM, curve.max(axis=0) + NEAR_MM
    asked = np.flatnonzero(((xyz > low) & (xyz < high)).all(axis=1))
    off[asked] = np.minimum((PointTree(curve).nearest(xyz[asked], 1, NEAR_MM)[0][:, 0] / NEAR_MM) ** 2, 1.0)
    return np.asarray(off[ends].max(axis=1), dtype=np.float64)


def place_on_loop(places: Floats, line: Floats | None, found: int) -> int:
    """Which of the places `(k, 3)` of an edge is the end of a line of the file; `found` where no end comes near it."""
    if line is None:
        return found
    away = np.linalg.norm(places[:, None] - line[[0, -1]], axis=2)
    return int(away.min(axis=1).argmin()) if away.min() <= NEAR_MM else found


def drawn_to_curves(
    xyz: Floats, loops: Mapping[str, Ints], curves: Mapping[str, Floats]
) -> tuple[Floats, tuple[str, ...]]:
    """Vertices of the detected edges moved on to the curves that the file brought for them, and words on it.

    Args:
        xyz: `(n, 3)`.
        loops: Name of an edge -> its vertices.
        curves: Name -> dense curve `(m, 3)`.
    """
    drawn, words = xyz.copy(), list[str]()
    for name, loop in loops.items():
        if name not in curves:
            continue
        distance, index = PointTree(curves[name]).nearest(xyz[loop], 1)
        off = float(np.percentile(distance, 95))
        plain = name.replace("_", " ")
        if off > OFF_MM:
            words.append(f"the file's {plain} lies {off:.1f} mm off the edge of the mesh and was not used")
            continue
        drawn[loop] = curves[name][index[:, 0]]
        words.append(f"the {plain} was taken from the file; the mesh's lay within {off:.2f} mm of it")
    return drawn, tuple(words)
