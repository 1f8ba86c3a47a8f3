"""Tape girths and what is not known about them.

The machine does not see the skin near the board. A girth therefore has an interval: from the hull of the seen
points alone to the hull with vertical walls from the lowest seen skin down to the board.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy.optimize import OptimizeResult, minimize_scalar

from footscan.coordinates import Bools, Floats
from footscan.foot.crossing import hull_perimeter_mm
from footscan.foot.sections import cut_shell, plane_axes
from footscan.foot.shell import NEVER_SEEN_BELOW_MM, Shell

WALL_SHARE, RIM_SHARE = 0.05, 0.15
"""For the upper end of an interval a vertical wall goes down to the board from seen skin below the first share of the
length, and from seen skin below the second that borders on unseen skin."""
_FLAT = 1e-4
MARGIN_MM = 1.0
"""Both ends of an interval are moved out by this much: what the seen skin itself is trusted to along a tape."""
BRIDGE_SHARE = 0.02
"""And by this share of the bridged skin under the tape: how far a bridge may miss the skin."""


@dataclass(frozen=True)
class Girth:
    """A tape girth (mm), its interval, the share not seen, and the cut `(n, 3)`.

    `unseen_share` leaves out the sole's edge (`NEVER_SEEN_BELOW_MM`): the interval speaks of that, `reliable` does not.
    """

    value_mm: float
    interval_mm: tuple[float, float]
    unseen_share: float
    xyz: Floats


def measure_girth(shell: Shell, length_mm: float, origin: Floats, normal: Floats) -> Girth | None:
    """Tape girth of the cut by a plane with unit `normal`; None when the plane misses the shell.

    Args:
        shell: In the foot frame, on z = 0.
        length_mm: Foot length, which the heights of edge and walls scale with.
        origin: `(3,)` a point of the plane.
        normal: `(3,)` unit.
    """
    cut = cut_shell(shell, origin, normal)
    if len(cut.xyz) == 0:
        return None
    xyz = cut.xyz.reshape(-1, 3)
    seen = cut.seen.reshape(-1) if shell.origin is not None else shell_seen(xyz, shell)
    axes = np.stack(plane_axes(normal), axis=1)
    value = hull_perimeter_mm(xyz @ axes)
    low = hull_perimeter_mm(xyz[seen] @ axes) if seen.any() else 0.0
    walls = _wall_points(shell, length_mm, origin, normal)
    high = hull_perimeter_mm(np.concatenate([xyz, walls]) @ axes)
    size = np.linalg.norm(cut.xyz[:, 1] - cut.xyz[:, 0], axis=1)
    upper = size * (cut.xyz[:, :, 2].mean(axis=1) > NEVER_SEEN_BELOW_MM)
    unseen = float((upper * (~seen.reshape(-1, 2)).mean(axis=1)).sum() / max(float(upper.sum()), 1e-12))
    margin = MARGIN_MM + BRIDGE_SHARE * unseen * float(upper.sum())
    return Girth(value, (low - margin, high + margin), unseen, xyz)


def shell_seen(xyz: Floats, shell: Shell) -> Bools:
    """`(n,)` whether points of a shell of unknown origin count as seen: by their height alone."""
    return Shell(xyz, shell.faces).seen


def find_smallest(
    measure: Callable[[float], float], band: tuple[float, float], steps: int = 9
) -> tuple[float, float, bool]:
    """Where a smooth quantity is smallest within a band.

    Returns:
        Place, value, and whether this is no minimum: it lies at an end of the band, or is not lower than an end.
    """
    places = np.linspace(*band, steps)
    values = np.array([measure(float(place)) for place in places])
    k = int(values.argmin())
    around = (float(places[max(k - 1, 0)]), float(places[min(k + 1, steps - 1)]))
    options = {"xatol": 1e-4 * (band[1] - band[0])}
    found = cast("OptimizeResult", minimize_scalar(measure, bounds=around, method="bounded", options=options))
    place, value = float(found["x"]), float(found["fun"])
    if value >= values[k]:
        place, value = float(places[k]), float(values[k])
    flat = min(values[0], values[-1]) - value < _FLAT * value
    if flat or min(place - band[0], band[1] - place) < 1e-3 * (band[1] - band[0]):
        return place, value, True
    place = _settled(measure, place, min(0.002 * (band[1] - band[0]), place - band[0], band[1] - place))
    return place, measure(place), False


def _settled(measure: Callable[[float], float], place: float, half_width: float) -> float:
    """The bottom of the parabola through a minimum and both sides: rounding moves it far less than the search's end."""
    left, middle, right = (measure(place + side * half_width) for side in (-1.0, 0.0, 1.0))
    bend = left - 2.0 * middle + right
    return place + half_width * float(np.clip((left - right) / (2.0 * bend), -1.0, 1.0)) if bend > 0 else place


def _wall_points(shell: Shell, length_mm: float, origin: Floats, normal: Floats) -> Floats:
    """Where the plane crosses vertical walls below the lowest seen skin: `(n, 3)` on the board and between it
    and the skin.

    A wall below a triangle is a prism; its cut is the hull of the crossings of the prism's edges: the triangle's own
    crossings (already in the cut), those of its shadow on the board, and those of the vertical edges.
    """
    low = _lowest_seen(shell, length_mm)
    a, b, c = (low[shell.faces[:, k]] for k in range(3))
    faces = shell.faces[a | b | c]
    shadow = Shell(shell.xyz * np.array([1.0, 1.0, 0.0]), faces)
    on_board = cut_shell(shadow, origin, normal).xyz.reshape(-1, 3)
    if abs(normal[2]) < 1e-9:
        return on_board
    corner = shell.xyz[low]
    height = (float(origin @ normal) - corner[:, :2] @ normal[:2]) / normal[2]
    below = (height >= 0) & (height <= corner[:, 2])
    return np.concatenate([on_board, np.column_stack([corner[below, :2], height[below]])])


def _lowest_seen(shell: Shell, length_mm: float) -> Bools:
    """`(n,)` seen vertices near the board, or beside unseen skin not far above it (the arch is seen from 15 mm up)."""
    seen, z = shell.seen, shell.xyz[:, 2]
    near = z <= RIM_SHARE * length_mm
    a, b, c = (near[shell.faces[:, k]] for k in range(3))
    faces = shell.faces[a & b & c]
    beside = np.zeros(len(z), dtype=np.bool_)
    beside[faces[~seen[faces].all(axis=1)].ravel()] = True
    return seen & ((z <= WALL_SHARE * length_mm) | beside)
