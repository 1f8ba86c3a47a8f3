"""How the skin that nobody saw is continued down to the board.

The machine looks from outside and a little above. Skin that leaned outwards below the lowest seen skin would have been
seen, so the true skin goes on inside the tangent there. Where the board beside the foot was lit and seen, the rule
`bare-board` is used: no skin stands on bare board, and the foot begins where it ends, so the skin runs in a parabola
from its lowest seen place to the board a little further in (`bare_board`). Elsewhere the rule `curvature-rounded`
follows the lowest seen skin's own lean (never outwards, never more than 60 degrees from upright) and curvature, and
runs out on the board in a parabola that is tangent to both. The sole within is flat. None of this skin is measured.
Vertical walls, the outer bound that tape girths use, are not drawn.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter

from footscan.coordinates import Floats

ClosureName = Literal["bare-board", "curvature-rounded"]
_SAMPLES = 14
_STEADY = 2.0  # columns over which leans are averaged
_SHORTEST_RUN = 0.5  # of the slope's length
_LARGEST_LEAN_RAD = np.radians(60.0)
_STEEPEST = 0.7  # least way inwards to the board over the height; seen skin has at least this lean at its lower end
_FARTHEST = 0.8  # of the way to the axis
_BEYOND_TANGENT = 1.4  # of the way that the tangent of the lowest seen skin takes to the board
_TRUST_IN_LEAN = 0.8  # against a lean that would halve the way to the board
_LEANS = (0.35, 0.85)  # of the way to the board, between which the tangent may meet it


@dataclass(frozen=True)
class ClosureRule:
    """A named closure; `bare-board` falls back to `curvature-rounded` where the board says nothing.

    Attributes:
        name: What the report calls it.
        longest_run_mm: Longest run of the rounding along the board, where the board says nothing.
        soft_mm: How far inside the last bare board the skin reaches the board.
    """

    name: ClosureName
    longest_run_mm: float
    soft_mm: float


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
    ring_mm: Floats, inwards: Floats, edge: EdgeShape, room_mm: Floats, bare_mm: Floats, rule: ClosureRule
) -> tuple[Floats, Floats]:
    """Assumed skin from the board up to the lowest seen skin.

    Args:
        ring_mm: `(A, 3)` lowest seen skin, in order around the foot.
        inwards: `(A, 2)` horizontal unit vectors towards the axis.
        edge: Lean and bend of the skin there.
        room_mm: `(A,)` distance to the axis.
        bare_mm: `(A,)` how far inwards of the lowest seen skin the board was seen bare; NaN where it was not.
        rule: The closure.

    Returns:
        Points `(A, C, 3)`, board first, and how far along its arc each lies, 0..1, `(A, C)`.
    """
    height = ring_mm[:, 2]
    known = np.isfinite(bare_mm)
    guessed = _curvature_rounded(height, edge, 0.5 * room_mm, rule)
    bounded = _to_bare_board(height, edge, room_mm, bare_mm + rule.soft_mm)
    shift, run = (np.where(known, ours, other) for ours, other in zip(bounded, guessed, strict=True))
    t = np.linspace(1.0, 0.0, _SAMPLES)
    inset = 2.0 * t * (1.0 - t) * shift[:, None] + t**2 * (shift + run)[:, None]
    points = np.concatenate(
        [ring_mm[:, None, :2] + inset[..., None] * inwards[:, None], ((1.0 - t) ** 2 * height[:, None])[..., None]],
        axis=2,
    )
    step = np.linalg.norm(np.diff(points, axis=1), axis=2)
    along = np.concatenate([np.zeros((len(ring_mm), 1)), np.cumsum(step, axis=1)], axis=1)
    return points, along / np.maximum(along[:, -1:], 1e-9)


def _to_bare_board(height: Floats, edge: EdgeShape, room_mm: Floats, contact_mm: Floats) -> tuple[Floats, Floats]:
    """The same for skin that reaches the board where the bare board ends, or, under an arch, further in.

    An arch keeps light and camera from the board in front of it: where the seen skin's own lean leads further in than
    the bare board, the skin reaches the board somewhat beyond where its tangent does.
    """
    shift = np.minimum(height * np.tan(edge.lean_rad), 0.6 * room_mm)
    least = np.maximum(contact_mm, _BEYOND_TANGENT * shift)
    contact = np.clip(least, _STEEPEST * height, _FARTHEST * room_mm)
    leant = np.clip(shift, _LEANS[0] * contact, _LEANS[1] * contact)
    shift = (1.0 - _TRUST_IN_LEAN) * 0.5 * contact + _TRUST_IN_LEAN * leant
    return shift, contact - shift


def _curvature_rounded(height: Floats, edge: EdgeShape, room_mm: Floats, rule: ClosureRule) -> tuple[Floats, Floats]:
    """Where the tangent of the lowest seen skin meets the board, and how far the skin runs on from there `(A,)`."""
    shift = np.minimum(height * np.tan(edge.lean_rad), 0.6 * room_mm)
    slope = np.hypot(height, shift)
    same_bend = 2.0 * edge.bend_per_mm * slope**3 / np.maximum(height, 1e-9)
    run = np.clip(same_bend, _SHORTEST_RUN * slope, np.maximum(rule.longest_run_mm, _SHORTEST_RUN * slope))
    return shift, np.minimum(run, np.maximum(room_mm - shift, 0.0))
