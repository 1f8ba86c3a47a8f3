"""How the skin that nobody saw is continued down to the board.

The machine looks from outside and a little above. Skin that leaned outwards below the lowest seen skin would have been
seen, so the true skin goes on inside the tangent there. The one rule offered, `curvature-rounded`, therefore follows
the lowest seen skin's own lean (never outwards, never more than 60 degrees from upright) and curvature, and runs out on
the board in a parabola that is tangent to both; the sole within is flat. Nothing of it is measured. Vertical walls, the
outer bound that tape girths use, are not drawn.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter

from footscan.coordinates import Floats

ClosureName = Literal["curvature-rounded"]
_SAMPLES = 14
_STEADY = 2.0  # columns over which leans are averaged
_SHORTEST_RUN = 0.5  # of the slope's length
_LARGEST_LEAN_RAD = np.radians(60.0)


@dataclass(frozen=True)
class ClosureRule:
    """A named closure.

    Attributes:
        name: What the report calls it.
        longest_run_mm: Longest run of the rounding along the board.
    """

    name: ClosureName
    longest_run_mm: float


@dataclass(frozen=True)
class EdgeShape:
    """How the lowest seen skin runs towards the board, in order around the foot.

    Attributes:
        lean_rad: `(A,)` lean inwards from upright.
        bend_per_mm: `(A,)` by how much the lean grows per mm on the way down.
    """

    lean_rad: Floats
    bend_per_mm: Floats


def edge_shape(rows_mm: Floats, inwards: Floats) -> EdgeShape:
    """Lean and bend of the lowest seen skin, steadied around the foot.

    Args:
        rows_mm: `(3, A, 3)` places on the skin: its lowest seen part and two rows above it.
        inwards: `(A, 2)` horizontal unit vectors towards the axis.
    """
    down = rows_mm[:-1] - rows_mm[1:]
    across = (down[..., :2] * inwards).sum(axis=2)
    leans = np.arctan2(across, np.maximum(-down[..., 2], 1e-9))
    leans = gaussian_filter1d(median_filter(leans, (1, 5), mode="wrap"), _STEADY, axis=1, mode="wrap")
    length = np.hypot(across, down[..., 2])
    bend = np.maximum((leans[0] - leans[1]) / np.maximum(0.5 * (length[0] + length[1]), 1e-6), 0.0)
    lean = np.clip(leans[0] + 0.5 * length[0] * bend, 0.0, _LARGEST_LEAN_RAD)
    return EdgeShape(lean, bend)


def closing_arcs(
    ring_mm: Floats, inwards: Floats, edge: EdgeShape, room_mm: Floats, rule: ClosureRule
) -> tuple[Floats, Floats]:
    """Assumed skin from the board up to the lowest seen skin.

    Args:
        ring_mm: `(A, 3)` lowest seen skin, in order around the foot.
        inwards: `(A, 2)` horizontal unit vectors towards the axis.
        edge: Lean and bend of the skin there.
        room_mm: `(A,)` how far inwards the arc may reach.
        rule: The closure.

    Returns:
        Points `(A, C, 3)`, board first, and how far along its arc each lies, 0..1, `(A, C)`.
    """
    height = ring_mm[:, 2]
    shift = np.minimum(height * np.tan(edge.lean_rad), 0.6 * room_mm)
    slope = np.hypot(height, shift)
    same_bend = 2.0 * edge.bend_per_mm * slope**3 / np.maximum(height, 1e-9)
    run = np.clip(same_bend, _SHORTEST_RUN * slope, np.maximum(rule.longest_run_mm, _SHORTEST_RUN * slope))
    run = np.minimum(run, np.maximum(room_mm - shift, 0.0))
    t = np.linspace(1.0, 0.0, _SAMPLES)
    inset = 2.0 * t * (1.0 - t) * shift[:, None] + t**2 * (shift + run)[:, None]
    points = np.concatenate(
        [ring_mm[:, None, :2] + inset[..., None] * inwards[:, None], ((1.0 - t) ** 2 * height[:, None])[..., None]],
        axis=2,
    )
    step = np.linalg.norm(np.diff(points, axis=1), axis=2)
    along = np.concatenate([np.zeros((len(ring_mm), 1)), np.cumsum(step, axis=1)], axis=1)
    return points, along / np.maximum(along[:, -1:], 1e-9)
