"""How the skin that nobody saw is continued down to the board.

The machine looks from outside and a little above. Skin that leaned outwards below the lowest seen skin would have been
seen, so the true skin goes on inside the tangent there. The one rule offered, `tangent-rounded`, therefore follows the
lowest seen skin's own lean (never outwards, never more than 60 degrees from upright) and turns on to the board in an
arc that is tangent to both; the sole within is flat. Nothing of it is measured. Vertical walls, the outer bound that
tape girths use, are not drawn.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter

from footscan.coordinates import Floats

ClosureName = Literal["tangent-rounded"]
_SAMPLES = 14
_LARGEST_LEAN_RAD = np.radians(60.0)


@dataclass(frozen=True)
class ClosureRule:
    """A named closure.

    Attributes:
        name: What the report calls it.
        radius_mm: Longest run of the rounding along the board.
    """

    name: ClosureName
    radius_mm: float


def lean_rad(downwards: Floats, inwards: Floats) -> Floats:
    """Lean `(A,)` of the lowest seen skin, inwards from upright, steadied around the foot.

    Args:
        downwards: `(A, 3)` direction of the skin towards the board.
        inwards: `(A, 2)` horizontal unit vectors towards the axis.
    """
    across = (downwards[:, :2] * inwards).sum(axis=1)
    lean = np.clip(np.arctan2(across, np.maximum(-downwards[:, 2], 1e-9)), 0.0, _LARGEST_LEAN_RAD)
    return gaussian_filter1d(median_filter(lean, 5, mode="wrap"), 2.0, mode="wrap")


def closing_arcs(
    ring_mm: Floats, inwards: Floats, lean: Floats, room_mm: Floats, rule: ClosureRule
) -> tuple[Floats, Floats]:
    """Assumed skin from the board up to the lowest seen skin.

    Args:
        ring_mm: `(A, 3)` lowest seen skin, in order around the foot.
        inwards: `(A, 2)` horizontal unit vectors towards the axis.
        lean: `(A,)` lean of the skin there (rad), see `lean_rad`.
        room_mm: `(A,)` how far inwards the arc may reach.
        rule: The closure.

    Returns:
        Points `(A, C, 3)`, board first, and how far along its arc each lies, 0..1, `(A, C)`.
    """
    height = ring_mm[:, 2]
    shift = np.minimum(height * np.tan(lean), 0.6 * room_mm)
    run = np.minimum(np.minimum(np.hypot(height, shift), rule.radius_mm), np.maximum(room_mm - shift, 0.0))
    t = np.linspace(1.0, 0.0, _SAMPLES)
    inset = 2.0 * t * (1.0 - t) * shift[:, None] + t**2 * (shift + run)[:, None]
    points = np.concatenate(
        [ring_mm[:, None, :2] + inset[..., None] * inwards[:, None], ((1.0 - t) ** 2 * height[:, None])[..., None]],
        axis=2,
    )
    step = np.linalg.norm(np.diff(points, axis=1), axis=2)
    along = np.concatenate([np.zeros((len(ring_mm), 1)), np.cumsum(step, axis=1)], axis=1)
    return points, along / np.maximum(along[:, -1:], 1e-9)
