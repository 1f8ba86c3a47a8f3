"""How far in under a foot the footboard was seen bare: free space, measured, although the sole is not.

A place of the board that was lit and seen holds no foot, and the light's and the camera's rays to it pass under the
skin. The lit board therefore runs in under every overhang of the sole's edge, and far in under an arch, and where it
ends the foot begins.
"""

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter

from footscan.coordinates import Bools, Floats, Ints

_DIRECTIONS = 240
_OUTSIDE_MM = 15.0
"""The lit board is followed inwards from this far outside the lowest seen skin."""
_BEGIN_MM = 8.0
"""It must begin at least this far outside; else something stands there, or the board is dark."""
_ENDS_MM = 3.0
"""And go on to at least this far outside; else it is a dark stretch of the board that ends it, not the foot."""
_GAP_MM = 4.0
"""A gap as long as this along a direction ends it."""
_THIRD = 2
_STEADY = 1.5
_LEAST_SHARE = 0.25
"""Share of all directions that must be known; else the board is too dark to say anything."""


def find_bare_reach(
    xy_board: Floats, middle_mm: tuple[float, float], rim_xy: Floats, heading_rad: float = 0.0
) -> Floats:
    """Distance from the middle of the foot to the innermost bare board, in the direction of each place on a rim.

    Args:
        xy_board: `(n, 2)` places where the board was seen, world.
        middle_mm: The middle of the foot.
        rim_xy: `(A, 2)` the lowest seen skin from above, in order around the foot.
        heading_rad: From where directions are counted; that of the foot makes a turned foot give the same.

    Returns:
        `(A,)` mm, steadied around the foot; NaN everywhere when the board says too little.
    """
    middle = np.array(middle_mm)
    rim_turn, rim_mm = _polar(rim_xy - middle, heading_rad)
    order = np.argsort(rim_turn)
    centres = (np.arange(_DIRECTIONS) + 0.5) / _DIRECTIONS
    rim = np.interp(centres, rim_turn[order], rim_mm[order], period=1.0)
    turn, reach = _polar(xy_board - middle, heading_rad)
    which = np.minimum((turn * _DIRECTIONS).astype(np.int64), _DIRECTIONS - 1)
    near = reach < rim[which] + _OUTSIDE_MM
    found, known = _innermost(which[near], reach[near], rim)
    if known.mean() < _LEAST_SHARE:
        return np.full(len(rim_xy), np.nan)
    inset = median_filter((rim - found)[known], 5, mode="wrap")
    whole = rim - np.interp(centres, centres[known], inset, period=1.0)
    whole = gaussian_filter1d(whole, _STEADY, mode="wrap")
    return np.interp(rim_turn, centres, whole, period=1.0)


def _polar(xy: Floats, heading_rad: float) -> tuple[Floats, Floats]:
    """Direction from a heading in turns (0..1) and distance of `(n, 2)` places."""
    turn = (np.arctan2(xy[:, 1], xy[:, 0]) - heading_rad) / (2.0 * np.pi)
    return np.mod(turn, 1.0), np.hypot(xy[:, 0], xy[:, 1])


def _innermost(which: Ints, reach: Floats, rim: Floats) -> tuple[Floats, Bools]:
    """Reach `(D,)` of the third innermost place of each direction's unbroken lit board, and where it is known."""
    order = np.lexsort((-reach, which))
    which, reach = which[order], reach[order]
    starts = np.searchsorted(which, np.arange(len(rim) + 1))
    broken = np.zeros(len(reach), dtype=np.int64)
    broken[1:] = (reach[:-1] - reach[1:] > _GAP_MM) & (which[1:] == which[:-1])
    runs = np.cumsum(broken)
    first = runs[np.minimum(starts[:-1], max(len(runs) - 1, 0))] if len(runs) else np.zeros(len(rim), dtype=np.int64)
    whole = runs == first[which] if len(runs) else np.zeros(0, dtype=np.bool_)
    count = np.bincount(which[whole], minlength=len(rim))
    place = starts[:-1] + count - 1 - _THIRD
    known = count > _THIRD
    found = np.full(len(rim), np.nan)
    found[known] = reach[place[known]]
    begins = np.full(len(rim), -np.inf)
    begins[known] = reach[starts[:-1][known]]
    return found, known & (begins > rim + _BEGIN_MM) & (found < rim + _ENDS_MM)
