"""Is it a foot, where does it point, and which one is it: decided from the shape alone, before any landmark."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.errors import MeshError
from footscan.foot.crossing import convex_hull
from footscan.foot.outline import Outline, find_bulge, find_outline, turned
from footscan.foot.sections import cut_shell
from footscan.foot.shell import Shell
from footscan.foot.units import check_foot_length

_LOW_SHARE = 0.25
"""The horizontal shape is judged from the skin below this share of the longest extent: the leg may lean."""
_FLATTEST_BOARD, _FLATTEST_FOOT = 0.03, 0.14
"""Height over length: below the first there is no foot, below the second only its sole."""
_ROUNDEST_STUMP, _BROADEST_FOOT = 1.2, 1.55
"""Length over breadth; a foot has 2.3 to 3, a short stump after amputation may have 1.3, two feet side by side 1.3."""
_ANKLE_SHARE, _LEAST_ANKLE_MM, _BROADEST_ANKLE = 0.52, 140.0, 0.85
"""The area near the top, or up to this share of the length (a stump: at least this height), over that near the bottom:
a foot has 0.2 to 0.5 (cut at 60 mm), stumps of 110 to 165 mm 0.4 to 0.7; a box, a lying ellipsoid, upside down >= 1."""
_BROADEST_TOP = 1.6
"""The same at the very top, where the calf over a short stump may be broader than the stump, but not as a sole is."""
_LOWEST_SHARE, _REFUSED_SHARE = (-0.015, 0.03), (-0.2, 0.1)
"""Height of the lowest skin over the length: outside the first a question, outside the second refused."""
STUMP_SHARE = 0.17
"""Dorsum height at 90 % of the length, over the length, from which the front is a stump (toes: 0.08 to 0.12)."""


@dataclass(frozen=True)
class Heading:
    """A rough pose: unit `xy_forward` `(2,)` heel to toe, extent along and across it, height of the skin (mm)."""

    xy_forward: Floats
    length_mm: float
    breadth_mm: float
    height_mm: float


def rough_heading(shell: Shell, lift_mm: float = 0.0) -> Heading:
    """Where the foot points, to some degrees, from the moments of its outline; the leg is above the heel.

    Args:
        shell: Skin in mm.
        lift_mm: By how much the heel is raised: skin is counted up to so much higher.

    Raises:
        MeshError: The extent cannot be a foot's.
    """
    if len(shell.xyz) < 100:
        raise MeshError(f"{len(shell.xyz)} points are no foot: a scan has thousands")
    whole = find_outline(shell, np.inf)
    bottom, top = float(shell.xyz[:, 2].min()), float(shell.xyz[:, 2].max())
    low = find_outline(shell, bottom + lift_mm + _LOW_SHARE * _diameter(whole.xy))
    check_foot_length(_diameter(low.xy))
    forward = _long_direction(low.xy)
    along, across = low.xy @ forward, low.xy @ np.array([-forward[1], forward[0]])
    if _toes_behind(shell, forward, along):
        forward = -forward
    return Heading(forward, float(np.ptp(along)), float(np.ptp(across)), top - bottom)


def check_shape(shell: Shell, outline: Outline, heading: Heading) -> None:
    """Refuse what is no foot: an empty board, a sole alone, a ball.

    Raises:
        MeshError: Saying what it looks like.
    """
    flat = heading.height_mm / heading.length_mm
    size = f"{heading.length_mm:.0f} x {heading.breadth_mm:.0f} mm and {heading.height_mm:.0f} mm high"
    if flat < _FLATTEST_BOARD:
        raise MeshError(f"{size}: an empty board, no foot on it; check that the foot was in the scan")
    if flat < _FLATTEST_FOOT:
        raise MeshError(f"{size}: only a sole (plantar scan); foot measurements need the skin up to the ankle")
    if heading.length_mm / heading.breadth_mm < _ROUNDEST_STUMP:
        raise MeshError(f"{size}: as broad as it is long, like a ball, not like a foot; check the mesh")
    if heading.length_mm / heading.breadth_mm < _BROADEST_FOOT and not is_stump(shell, outline, heading):
        raise MeshError(f"{size}: too broad for one foot: two feet, or something beside it? one foot at a time")


def check_ankle(shell: Shell, heading: Heading) -> None:
    """Refuse what is at its top about as broad as on the board: upside down, a box, a ball; a cloud is never refused.

    Raises:
        MeshError: Saying both areas.
    """
    ankle = min(heading.height_mm, max(_ANKLE_SHARE * heading.length_mm, _LEAST_ANKLE_MM))
    bottom = float(shell.xyz[:, 2].min())
    low = _level_area_mm2(shell, bottom + 0.1 * ankle)
    for height, limit in ((0.9 * ankle, _BROADEST_ANKLE), (0.9 * heading.height_mm, _BROADEST_TOP)):
        high = _level_area_mm2(shell, bottom + height)
        if high > limit * low:
            raise MeshError(
                f"{high / 100.0:.0f} cm2 across at {height:.0f} mm above its lowest point, {low / 100.0:.0f} cm2 near "
                "that: no ankle narrower than the foot, so no foot, or one upside down; turn the mesh, z up"
            )


def _level_area_mm2(shell: Shell, height_mm: float) -> float:
    """Area of the hull of a level cut; 0 where there is none."""
    xyz = cut_shell(shell, np.array([0.0, 0.0, height_mm]), np.array([0.0, 0.0, 1.0])).xyz.reshape(-1, 3)
    if len(xyz) < 3:
        return 0.0
    xy = np.ascontiguousarray(xyz[:, :2])
    xy = xy[convex_hull(xy)]
    following = np.roll(xy, -1, axis=0)
    return abs(float((xy[:, 0] * following[:, 1] - xy[:, 1] * following[:, 0]).sum())) / 2.0


def check_standing(shell: Shell, heading: Heading) -> None:
    """Refuse a foot so far from the board that its low skin, which everything is taken from, is not low.

    Raises:
        MeshError: Saying how far.
    """
    lowest = float(shell.xyz[:, 2].min())
    if not _REFUSED_SHARE[0] * heading.length_mm <= lowest <= _REFUSED_SHARE[1] * heading.length_mm:
        raise MeshError(
            f"the foot does not stand on z = 0 (lowest skin at {lowest:.0f} mm): put it on the board, z = 0"
        )


def standing_questions(shell: Shell, length_mm: float) -> tuple[str, ...]:
    """A question when the lowest skin is so far from z = 0 that z = 0 may not be the board; nothing is moved."""
    lowest = float(shell.xyz[:, 2].min())
    if _LOWEST_SHARE[0] * length_mm <= lowest <= _LOWEST_SHARE[1] * length_mm:
        return ()
    where = "above" if lowest > 0 else "below"
    return (f"The lowest skin is {abs(lowest):.0f} mm {where} z = 0: is z = 0 the board? Heights count from there.",)


def is_stump(shell: Shell, outline: Outline, heading: Heading) -> bool:
    """Whether the front ends high and blunt, as after an amputation; a cloud (no faces) never says so."""
    normal = np.array([*heading.xy_forward, 0.0])
    rear = float((outline.xy @ heading.xy_forward).min())
    xyz = cut_shell(shell, (rear + 0.9 * heading.length_mm) * normal, normal).xyz.reshape(-1, 3)
    return len(xyz) > 0 and float(xyz[:, 2].max()) > STUMP_SHARE * heading.length_mm


def side_score(shell: Shell, outline: Outline, heading: Heading) -> float:
    """How much the left-hand side (seen along the heading) is the medial one: positive for a right foot.

    Three signs, each as a share of the size: the ridge of the instep lies medially, the ball stands out
    further forward on the medial side, and the foremost toe lies medially.
    """
    ahead = turned(outline, heading.xy_forward, mirrored=False)
    rear, length = float(ahead.xy[:, 0].min()), heading.length_mm
    left = find_bulge(ahead, length, (0.5, 0.85), 1.0)
    right = find_bulge(ahead, length, (0.5, 0.85), -1.0)
    breadth = left.xy[1] - right.xy[1]
    tip = ahead.xy[ahead.xy[:, 0].argmax()]
    toe = (tip[1] - (left.xy[1] + right.xy[1]) / 2.0) / breadth
    ball = (left.xy[0] - right.xy[0]) / length
    return float(_ridge(shell, heading, rear) + ball + toe / 3.0)


def _ridge(shell: Shell, heading: Heading, rear: float) -> float:
    """Mean place of the highest point across the instep, as a share of its width from the middle; 0 for a cloud."""
    normal = np.array([*heading.xy_forward, 0.0])
    across = np.array([-normal[1], normal[0], 0.0])
    shares: list[float] = []
    for share in (0.50, 0.55, 0.60, 0.65):
        xyz = cut_shell(shell, normal * (rear + share * heading.length_mm), normal).xyz.reshape(-1, 3)
        if len(xyz):
            y = xyz @ across
            shares.append(float((y[xyz[:, 2].argmax()] - (y.max() + y.min()) / 2.0) / np.ptp(y)))
    return float(np.mean(shares)) if shares else 0.0


def _toes_behind(shell: Shell, forward: Floats, along: Floats) -> bool:
    """Whether the ankle (the skin at half of the length in height, or the highest) is over the outline's front."""
    length, top = float(np.ptp(along)), float(shell.xyz[:, 2].max())
    height = min(0.45 * length, 0.9 * top)
    xyz = cut_shell(shell, np.array([0.0, 0.0, height]), np.array([0.0, 0.0, 1.0])).xyz.reshape(-1, 3)
    if len(xyz) == 0:
        xyz = shell.xyz[np.abs(shell.xyz[:, 2] - height) < 0.05 * length]
    x = xyz[:, :2] @ forward
    return len(x) > 0 and bool(x.min() + x.max() > along.min() + along.max())


def _diameter(xy: Floats) -> float:
    """Longest distance between two of `(k, 2)` corners."""
    if len(xy) == 0:
        return 0.0
    return float(np.sqrt(((xy[:, None] - xy[None]) ** 2).sum(axis=-1).max()))


def _long_direction(xy: Floats) -> Floats:
    """Unit direction `(2,)` of a convex polygon's longest second moment of area."""
    relative = xy - xy.mean(axis=0)
    following = np.roll(relative, -1, axis=0)
    twice = relative[:, 0] * following[:, 1] - relative[:, 1] * following[:, 0]
    total = float(twice.sum())
    if abs(total) < 1e-12:
        return np.array([1.0, 0.0])
    summed = relative + following
    centre = (summed * twice[:, None]).sum(axis=0) / (3.0 * total)
    parts = [np.einsum("k,ki,kj->ij", twice, p, p) for p in (relative, following, summed)]
    moment = sum(parts, np.zeros((2, 2))) / (12.0 * total) - np.outer(centre, centre)
    return np.linalg.eigh(moment)[1][:, 1]
