"""The bottom pattern of a last: as it lies in plan, and developed (laid flat) from the middle outwards."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.shoelast.handed import mirrored
from footscan.shoelast.model import Shoelast

_STEPS = 361
_ACROSS = 41


@dataclass(frozen=True)
class BottomPattern:
    """Outlines of the bottom, mm, real side: x to the toe, y to the left seen from above; closed lines.

    Attributes:
        plan: `(n, 2)` the feather edge seen from above.
        middle: `(k, 2)` the middle of the bottom seen from above.
        developed: `(n, 2)` laid flat: the middle turns as it turns within the bottom (its geodesic curvature), every
            point lies as far beside it as a tape along the bottom measures. x runs from the heel end of the feather
            edge to its toe end.
        length_mm: Along the middle of the bottom.
        edge_stretch: How much longer the developed edge is than the real feather edge, as a share; a bottom that is
            hollow and convex can not be laid flat without any.
    """

    plan: Floats
    middle: Floats
    developed: Floats
    length_mm: float
    edge_stretch: float


def bottom_pattern(shoelast: Shoelast) -> BottomPattern:
    """Draw the bottom pattern of a last."""
    s, t = np.linspace(0.0, 1.0, _STEPS), np.linspace(0.0, 1.0, _ACROSS)
    grid = mirrored(shoelast.bottom.grid(s, t), shoelast.side)
    middle = grid[:, _ACROSS // 2]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(middle, axis=0), axis=1))])
    ahead = np.gradient(middle, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    left, right = (_beside(half, ahead) for half in (grid[:, _ACROSS // 2 :], grid[:, _ACROSS // 2 :: -1]))
    left, right = (left, right) if shoelast.side == "right" else (right, left)
    across = grid[:, _ACROSS // 2 + 1] - grid[:, _ACROSS // 2 - 1]
    across = across if shoelast.side == "right" else -across
    course = _laid_flat(middle, ahead, across)
    heading = np.gradient(course, axis=0)
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    aside = np.column_stack([-heading[:, 1], heading[:, 0]])
    flat = [course + part[:, :1] * heading + sign * part[:, 1:] * aside for part, sign in ((left, 1), (right, -1))]
    developed = np.vstack([flat[0], flat[1][::-1]])
    lines = (grid[:, -1], grid[:, 0]) if shoelast.side == "right" else (grid[:, 0], grid[:, -1])
    edge = np.vstack([lines[0], lines[1][::-1]])
    stretch = _length(developed) / _length(edge) - 1.0
    return BottomPattern(edge[:, :2], middle[:, :2], developed, float(along[-1]), stretch)


def _laid_flat(middle: Floats, ahead: Floats, across: Floats) -> Floats:
    """The middle line `(n, 2)` with its lengths and its turning within the surface; `across` points to its left."""
    up = np.cross(ahead, across)
    to_left = np.cross(up, ahead)
    to_left /= np.maximum(np.linalg.norm(to_left, axis=1, keepdims=True), 1e-12)
    to_left[[0, -1]] = to_left[[1, -2]]  # the ends of the bottom are points without a direction across
    turn = 0.5 * (np.diff(ahead, axis=0) * (to_left[1:] + to_left[:-1])).sum(axis=1)
    heading = np.concatenate([[0.0], np.cumsum(turn)])
    step = np.linalg.norm(np.diff(middle, axis=0), axis=1)
    way = 0.5 * (heading[1:] + heading[:-1])
    course = np.vstack([[0.0, 0.0], np.cumsum(step[:, None] * np.column_stack([np.cos(way), np.sin(way)]), axis=0)])
    x, y = course[-1] / np.linalg.norm(course[-1])
    return course @ np.array([[x, -y], [y, x]])


def _beside(rows: Floats, ahead: Floats) -> Floats:
    """Along and beside the middle `(n, 2)`: where rows `(n, k, 3)` end that begin on it.

    The distance is measured along the row on the bottom, the direction is the one in which the row leaves the middle.
    """
    reach = np.linalg.norm(np.diff(rows, axis=1), axis=2).sum(axis=1)
    leave = rows[:, 1] - rows[:, 0]
    size = np.linalg.norm(leave, axis=1)
    slant = np.divide((leave * ahead).sum(axis=1), size, out=np.zeros_like(size), where=size > 1e-9)
    return reach[:, None] * np.column_stack([slant, np.sqrt(np.maximum(1.0 - slant**2, 0.0))])


def _length(line: Floats) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
