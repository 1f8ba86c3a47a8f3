"""The foot seen from above: its convex outline, and the few places on it that fix the foot axis."""

from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Floats, Ints
from footscan.foot.crossing import convex_hull, find_silhouette
from footscan.foot.shell import Shell

CAP_SHARE = 0.01
"""Depth, as a share of foot length, of the cap whose middle stands for a tangent point: a flat curve has no
sharp extreme."""
_STEP_SHARE, _PARABOLA_SHARE, _TOP_SHARE, _CLEAR_BULGE_SHARE = 0.005, 0.06, 0.025, 0.001
"""For the ball, as shares of the length: spacing of the silhouette, half widths of the parabolas that give place and
height of a bulge, and depth of a dip that parts two bulges."""
HEEL_BREADTH_SHARE = 0.16
HEEL_BREADTHS_PER_LENGTH = 3.7
"""Foot length over heel breadth (ANSUR II: 3.74 men, 3.67 women), for feet whose front is missing."""
MTH1_WINDOW = (0.62, 0.80)
MTH5_WINDOW = (0.52, 0.72)


@dataclass(frozen=True)
class Outline:
    """The skin below some height, from above.

    `xy` `(k, 2)` is its convex hull, counter-clockwise, and `corner` `(k,)` the hull's places in `xy_skin` `(n, 2)`,
    which is all of that skin; `vertex` `(n,)` are its numbers in the shell, `faces` `(m, 3)` its triangles (none in a
    cloud).
    """

    xy: Floats
    corner: Ints
    xy_skin: Floats
    vertex: Ints
    faces: Ints

    def vertex_of_corner(self, corner: int) -> int:
        """Number in the shell of a corner of the hull."""
        return int(self.vertex[self.corner[corner]])


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
    xy = np.ascontiguousarray(shell.xyz[vertex, :2])
    corner = convex_hull(xy)
    number = np.full(len(shell.xyz), -1)
    number[vertex] = np.arange(len(vertex))
    faces = number[shell.faces]
    return Outline(xy[corner], corner, xy, vertex, faces[(faces >= 0).all(axis=1)])


def turned(outline: Outline, xy_forward: Floats, *, mirrored: bool) -> Outline:
    """The outline in axes x along the unit vector `xy_forward` and y to its left, or to its right when mirrored."""
    left = np.array([-xy_forward[1], xy_forward[0]])
    axes = np.stack([xy_forward, -left if mirrored else left], axis=1)
    xy, corner = outline.xy @ axes, outline.corner
    if mirrored:
        xy, corner = np.ascontiguousarray(xy[::-1]), corner[::-1]
    return replace(outline, xy=xy, corner=corner, xy_skin=outline.xy_skin @ axes)


def shifted(outline: Outline, xy: Floats) -> Outline:
    """The outline moved by `xy` `(2,)`."""
    return replace(outline, xy=outline.xy + xy, xy_skin=outline.xy_skin + xy)


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
    return Extreme(np.array([rear, middle[1]]), outline.vertex_of_corner(int(outline.xy[:, 0].argmin())), at_end=False)


def find_bulge(outline: Outline, length_mm: float, window: tuple[float, float], sign: float) -> Extreme:
    """Where the skin, seen from above, stands out sideways most, within shares of the length from its rearmost point.

    A bulge inside the window is taken before a higher end of the window (there the big toe may begin). The place is the
    top of a parabola fitted to the silhouette: a flat curve has no sharp extreme, its most outward point would jump.

    Args:
        outline: In axes x forward and y medial.
        length_mm: Foot length.
        window: First and last share of the length.
        sign: +1 for the medial side, -1 for the lateral one.
    """
    x, out = _silhouette(outline, length_mm, window, sign)
    peak, at_end = _bulge_peak(out, _CLEAR_BULGE_SHARE * length_mm)
    place, top = float(x[peak]), float(out[peak])
    if not at_end:
        place = parabola_top(x, out, place, _PARABOLA_SHARE * length_mm)
        top = float(fit_parabola(x, out, place, _TOP_SHARE * length_mm)[0])
    xy = np.array([place, sign * top])
    nearest = int(np.abs(outline.xy_skin - xy).sum(axis=1).argmin())
    return Extreme(xy, int(outline.vertex[nearest]), at_end)


def _silhouette(outline: Outline, length_mm: float, window: tuple[float, float], sign: float) -> tuple[Floats, Floats]:
    """Places x `(k,)` in a window, and how far the skin reaches outward there `(k,)`; the hull's reach in a cloud."""
    rear = float(outline.xy[:, 0].min())
    x = rear + length_mm * np.arange(window[0], window[1] + _STEP_SHARE / 2.0, _STEP_SHARE)
    step = _STEP_SHARE * length_mm
    both = find_silhouette(np.ascontiguousarray(outline.xy_skin), outline.faces, float(x[0]), step, len(x))
    reach = both[:, 1] if sign > 0 else -both[:, 0]
    hull = sign * side_at(outline.xy, x, sign)
    return x, np.where(np.isfinite(reach), reach, hull)


def _bulge_peak(out: Floats, clear_mm: float) -> tuple[int, bool]:
    """Place of the highest peak between dips of at least `clear_mm`; without one, that of the highest end, and True."""
    best = int(out.argmax())
    if 0 < best < len(out) - 1:
        return best, False
    peaks = np.flatnonzero((out[1:-1] >= out[:-2]) & (out[1:-1] >= out[2:])) + 1
    clear = [p for p in peaks if out[p] - max(out[: p + 1].min(), out[p:].min()) > clear_mm]
    return (int(max(clear, key=lambda p: out[p])), False) if clear else (best, True)


def fit_parabola(x: Floats, out: Floats, place: float, half_width: float) -> Floats:
    """Coefficients `(3,)` in u = (x - place) / half_width, by weights that fall to 0 at u = 1 and -1."""
    u = (x - place) / half_width
    weight = np.clip(1.0 - u**2, 0.0, None)
    terms = np.stack([np.ones_like(u), u, u**2])
    return np.asarray(np.linalg.solve((weight * terms) @ terms.T, (weight * terms) @ out), dtype=np.float64)


def parabola_top(x: Floats, out: Floats, place: float, half_width: float) -> float:
    """The x of the top of a parabola fitted round a peak, moved along until it stays."""
    for _ in range(20):
        _, slope, bend = fit_parabola(x, out, place, half_width)
        if bend >= 0:
            break
        step = float(np.clip(-slope / (2.0 * bend), -0.5, 0.5))
        place = float(np.clip(place + step * half_width, x[0], x[-1]))
        if abs(step) < 1e-9:
            break
    return place


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
