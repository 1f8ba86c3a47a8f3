"""How exact a tape girth is on the skin that was seen, when the true foot is known.

The seen share of a girth is the part of the tape that lies on seen skin: those stretches of the hull, in the plane of
the tape, both of whose ends touch skin that was seen. The true foot is cut by the same plane, and its hull is measured
between the same directions from the middle of the tape. Skin nobody saw (the sole's edge, bridges) is in neither
number.
"""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats
from footscan.foot.crossing import convex_hull
from footscan.foot.measurements import TapePlane
from footscan.foot.sections import cut_shell, plane_axes
from footscan.foot.shell import Shell


@dataclass(frozen=True)
class SeenTape:
    """Tape over seen skin, mm: on the scanned foot, on the true one, and the whole girth of the scanned one."""

    scanned_mm: float
    true_mm: float
    whole_mm: float


def compare_seen_tape(scanned: Shell, true: Shell, tape: TapePlane) -> SeenTape:
    """Compare a tape where it lies on seen skin.

    Args:
        scanned: With a known origin of its skin.
        true: In the same coordinates.
        tape: The plane, in these coordinates; it must cut both.

    Raises:
        ValueError: The plane misses one of them.
    """
    axes = np.stack(plane_axes(tape.normal), axis=1)
    cut = cut_shell(scanned, tape.origin, tape.normal)
    true_xy = cut_shell(true, tape.origin, tape.normal).xyz.reshape(-1, 3) @ axes
    if len(cut.xyz) == 0 or len(true_xy) == 0:
        raise ValueError("the plane of the tape misses the foot")
    xy = cut.xyz.reshape(-1, 3) @ axes
    return _compare(xy, cut.seen.reshape(-1), true_xy)


def _compare(xy: Floats, seen: Bools, true_xy: Floats) -> SeenTape:
    corner = convex_hull(xy)
    hull, touches = xy[corner], seen[corner]
    stretch = np.linalg.norm(np.roll(hull, -1, axis=0) - hull, axis=1)
    both = touches & np.roll(touches, -1)
    middle = 0.5 * (hull.min(axis=0) + hull.max(axis=0))
    along, whole = _tape_to(true_xy[convex_hull(true_xy)] - middle, hull - middle)
    true_stretch = np.mod(np.roll(along, -1) - along, whole)
    return SeenTape(float(stretch[both].sum()), float(true_stretch[both].sum()), float(stretch.sum()))


def _tape_to(hull: Floats, towards: Floats) -> tuple[Floats, float]:
    """Length along a hull `(k, 2)` about the origin to where rays towards `(n, 2)` leave it, and its whole length."""
    hull = np.roll(hull, -int(np.arctan2(hull[:, 1], hull[:, 0]).argmin()), axis=0)
    turn = np.arctan2(hull[:, 1], hull[:, 0])
    edge = np.roll(hull, -1, axis=0) - hull
    length = np.linalg.norm(edge, axis=1)
    start = np.concatenate([[0.0], np.cumsum(length)[:-1]])
    k = np.searchsorted(turn, np.arctan2(towards[:, 1], towards[:, 0]), side="right") - 1
    share = -_cross(hull[k], towards) / _cross(edge[k], towards)
    return start[k] + share * length[k], float(length.sum())


def _cross(a: Floats, b: Floats) -> Floats:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
