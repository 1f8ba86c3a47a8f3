"""The foot seen from above: its convex outline, and the few places on it that fix the foot axis."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats, Ints
from footscan.foot.crossing import convex_hull
from footscan.foot.shell import Shell

CAP_SHARE = 0.01
"""Depth, as a share of foot length, of the cap whose middle stands for a tangent point: a flat curve has no
sharp extreme."""
BALL_CAP_SHARE = 0.02
HEEL_BREADTH_SHARE = 0.16
HEEL_BREADTHS_PER_LENGTH = 3.7
"""Foot length over heel breadth (ANSUR II: 3.74 men, 3.67 women), for feet whose front is missing."""
MTH1_WINDOW = (0.62, 0.80)
MTH5_WINDOW = (0.52, 0.72)


@dataclass(frozen=True)
class Outline:
    """Convex outline of the skin below some height: `xy` `(k, 2)` counter-clockwise, `vertex` `(k,)` in the shell."""

    xy: Floats
    vertex: Ints


@dataclass(frozen=True)
class Extreme:
    """A place where the outline stands out: `(x, y)` in the frame it was sought in, the corner nearest to it, and
    whether the extreme lies at the end of the window (then it is none)."""

    xy: Floats
    vertex: int
    at_end: bool


def find_outline(shell: Shell, height_mm: float) -> Outline:
    """Convex outline from above of the skin below `height_mm`."""
    vertex = np.flatnonzero(shell.xyz[:, 2] <= height_mm)
    corner = vertex[convex_hull(shell.xyz[vertex, :2])]
    return Outline(shell.xyz[corner, :2], corner)


def turned(outline: Outline, xy_forward: Floats, *, mirrored: bool) -> Outline:
    """The outline in axes x along the unit vector `xy_forward` and y to its left, or to its right when mirrored."""
    left = np.array([-xy_forward[1], xy_forward[0]])
    xy = outline.xy @ np.stack([xy_forward, -left if mirrored else left], axis=1)
    if not mirrored:
        return Outline(xy, outline.vertex)
    return Outline(np.ascontiguousarray(xy[::-1]), outline.vertex[::-1])


def beyond(xy: Floats, direction: Floats, level: float) -> Floats:
    """The part `(j, 2)` of a convex polygon where `direction . xy >= level`; empty when it does not reach that far."""
    height = xy @ direction - level
    following, later = np.roll(xy, -1, axis=0), np.roll(height, -1)
    crossing = (height >= 0) != (later >= 0)
    share = np.divide(height, height - later, out=np.zeros_like(height), where=crossing)
    between = xy + share[:, None] * (following - xy)
    points = np.stack([xy, between], axis=1).reshape(-1, 2)
    return points[np.stack([height >= 0, crossing], axis=1).reshape(-1)]


def _centroid(xy: Floats) -> Floats:
    relative = xy - xy[0]
    following = np.roll(relative, -1, axis=0)
    twice = relative[:, 0] * following[:, 1] - relative[:, 1] * following[:, 0]
    total = float(twice.sum())
    if abs(total) < 1e-12:
        return xy.mean(axis=0)
    return xy[0] + ((relative + following) * twice[:, None]).sum(axis=0) / (3.0 * total)


def find_heel(outline: Outline, length_mm: float) -> Extreme:
    """The pternion seen from above: rearmost x, and y in the middle of the cap behind the chord at 1 % of the
    length."""
    rear = float(outline.xy[:, 0].min())
    middle = _centroid(beyond(outline.xy, np.array([-1.0, 0.0]), -(rear + CAP_SHARE * length_mm)))
    return Extreme(np.array([rear, middle[1]]), int(outline.vertex[outline.xy[:, 0].argmin()]), at_end=False)


def find_bulge(outline: Outline, length_mm: float, window: tuple[float, float], sign: float) -> Extreme:
    """The place where the outline stands out sideways most, within shares of the length from its rearmost point.

    y is that of the most outward point in the window, x that of the middle of the cap there (within the window too): it
    moves smoothly with the shape where the most outward point itself would jump along a flat curve.

    Args:
        outline: In axes x forward and y medial.
        length_mm: Foot length.
        window: First and last share of the length.
        sign: +1 for the medial side, -1 for the lateral one.
    """
    rear = float(outline.xy[:, 0].min())
    first, last = rear + window[0] * length_mm, rear + window[1] * length_mm
    side = sign * outline.xy[:, 1]
    inside = (outline.xy[:, 0] >= first) & (outline.xy[:, 0] <= last)
    ends = side_at(outline.xy, np.array([first, last]), sign) * sign
    candidates = np.append(np.where(inside, side, -np.inf), ends)
    best = int(candidates.argmax())
    top = float(candidates[best])
    cap = beyond(outline.xy, np.array([0.0, sign]), top - BALL_CAP_SHARE * length_mm)
    cap = beyond(beyond(cap, np.array([1.0, 0.0]), first), np.array([-1.0, 0.0]), -last)
    place = np.array([_centroid(cap)[0], sign * top])
    nearest = int(np.linalg.norm(outline.xy - place, axis=1).argmin())
    return Extreme(place, int(outline.vertex[nearest]), at_end=best >= len(side))


def side_at(xy: Floats, x: Floats, sign: float) -> Floats:
    """Y `(n,)` of a convex polygon's medial (+1) or lateral (-1) side at some x `(n,)` within it."""
    a, b = xy, np.roll(xy, -1, axis=0)
    forward = (b[:, 0] - a[:, 0]) * sign < 0
    low, high = (b[forward], a[forward]) if sign > 0 else (a[forward], b[forward])
    order = np.argsort(low[:, 0])
    knots = np.vstack([low[order], high[order][-1:]])
    return np.interp(x, knots[:, 0], knots[:, 1])


def medial_tangent(outline: Outline, length_mm: float) -> Floats:
    """Unit direction `(2,)`, heel to toe, of the outline's edge that bridges the medial arch (at 45 % of the
    length)."""
    x = float(outline.xy[:, 0].min()) + 0.45 * length_mm
    a, b = outline.xy, np.roll(outline.xy, -1, axis=0)
    bridge = int(np.flatnonzero((a[:, 0] >= x) & (b[:, 0] < x))[0])
    edge = a[bridge] - b[bridge]
    return edge / np.linalg.norm(edge)


def length_from_heel(outline: Outline, length_mm: float) -> float:
    """The length (mm) that an outline's heel breadth leads one to expect; the search starts at `length_mm`."""
    rear = float(outline.xy[:, 0].min())
    for _ in range(8):
        x = np.array([rear + HEEL_BREADTH_SHARE * length_mm])
        breadth = float(side_at(outline.xy, x, 1.0)[0] - side_at(outline.xy, x, -1.0)[0])
        length_mm = HEEL_BREADTHS_PER_LENGTH * breadth
    return length_mm
