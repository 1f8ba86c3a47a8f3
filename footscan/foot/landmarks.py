"""Landmarks of a standing foot: one rule each, in one place; a landmark given by hand wins.

Windows are shares of the foot length. What bone decides (metatarsal heads, navicular, sphyria, toes 2 to 5)
can only be felt: found on the skin it is a stand-in and says so, or it is not offered at all.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from footscan.coordinates import Floats
from footscan.foot.align import toe_2_place
from footscan.foot.girth import find_smallest
from footscan.foot.outline import (
    HEEL_BREADTH_SHARE,
    MTH1_WINDOW,
    MTH5_WINDOW,
    find_bulge,
    find_heel,
    fit_parabola,
    parabola_top,
)
from footscan.foot.sections import cut_shell
from footscan.foot.shell import Shell, compact
from footscan.foot.standing import TOP_MARGIN_SHARE, StandingFoot

INSTEP_SHARE = 0.50
TOE_1_SIDE_SHARE, TOE_5_SIDE_SHARE = 0.90, 0.80
MALLEOLUS_BAND = (0.19, 0.41)
CHORD_TOP_SHARE = 0.3425
"""Where no bulge stands out, the ankle is sought off the chord up to this share of the length, however high
the leg goes."""
MALLEOLUS_WINDOW = (0.15, 0.35)
JUNCTION_BAND_RAD = (np.radians(25.0), np.radians(60.0))
_LEVEL_STEP_SHARE, _CLEAR_BULGE_SHARE, _MALLEOLUS_PARABOLA_SHARE = 0.005, 0.002, 0.045

_SKIN_WITHIN_MM = 0.1
"""Twice what seen skin lies off (RMS 0.05 mm): a lean of so much over half a bulge moves its top."""

NEEDS_HAND = "needs palpation"


@dataclass(frozen=True)
class Landmark:
    """A place on the foot.

    `xyz_foot` `(3,)` mm; `doubts` say why what depends on it is not reliable, empty when nothing speaks against it;
    `height_within_mm` says how well its height is known where that hangs on the top of a flat bulge.
    """

    xyz_foot: Floats
    source: Literal["auto", "manual"] = "auto"
    doubts: tuple[str, ...] = ()
    height_within_mm: float = 0.0


Landmarks = Mapping[str, Landmark]
Missing = str
"""Why a landmark is not there: cut off, absent, not seen."""


@dataclass(frozen=True)
class LandmarkRule:
    """How one landmark is found: `find` gets the foot and the landmarks before it in `RULES`."""

    name: str
    definition: str
    find: Callable[[StandingFoot, Landmarks], Landmark | Missing]
    part: str | None = None


def find_landmarks(foot: StandingFoot) -> tuple[dict[str, Landmark], dict[str, Missing]]:
    """Every landmark there is, and why each of the others is not."""
    found: dict[str, Landmark] = {}
    missing: dict[str, Missing] = {}
    for rule in RULES:
        place = _place(rule, foot, found)
        if isinstance(place, Landmark):
            found[rule.name] = _doubted_if_unseen(foot, rule, place)
        else:
            missing[rule.name] = place
    for name, xyz in foot.given.items():
        found.setdefault(name, Landmark(xyz, "manual"))
    return found, missing


def _doubted_if_unseen(foot: StandingFoot, rule: LandmarkRule, place: Landmark) -> Landmark:
    """Add a doubt to a landmark whose skin is bridged, assumed or cut; a constructed point has no skin."""
    if place.source == "manual" or rule.name == "heel_corner" or not foot.uncut_unseen.any():
        return place
    x, y, z = (foot.uncut_xyz[:, k] - place.xyz_foot[k] for k in range(3))
    if not foot.uncut_unseen[(x * x + y * y + z * z).argmin()]:
        return place
    return replace(place, doubts=(*place.doubts, f"not seen: the skin at {rule.name} is bridged or assumed"))


def _place(rule: LandmarkRule, foot: StandingFoot, found: Landmarks) -> Landmark | Missing:
    if rule.name in foot.given:
        return Landmark(foot.given[rule.name], "manual")
    if rule.part in foot.absent:
        return f"not applicable: {rule.part} is absent"
    return rule.find(foot, found)


def _pternion(foot: StandingFoot, _: Landmarks) -> Landmark:
    outline = foot.alignment.outline
    heel = find_heel(outline, foot.length_mm)
    return Landmark(np.array([0.0, 0.0, foot.shell_height_at(heel.vertex)]))


def _heel_corner(_foot: StandingFoot, found: Landmarks) -> Landmark:
    x, y, _ = found["pternion"].xyz_foot
    return Landmark(np.array([x, y, 0.0]))


def _bulge(
    name: str, window: tuple[float, float], sign: float
) -> Callable[[StandingFoot, Landmarks], Landmark | Missing]:
    def find(foot: StandingFoot, _: Landmarks) -> Landmark:
        place = find_bulge(foot.alignment.outline, foot.length_mm, window, sign)
        doubts = [f"{NEEDS_HAND}: {name} is bone, here the most outward skin stands in for it"]
        if place.at_end:
            doubts.append(f"{name} lies at the end of its search window")
        return Landmark(np.array([*place.xy, foot.shell_height_at(place.vertex)]), doubts=tuple(doubts))

    return find


def _foremost(foot: StandingFoot, _: Landmarks) -> Landmark:
    outline = foot.alignment.outline
    front = int(outline.xy[:, 0].argmax())
    return Landmark(np.array([*outline.xy[front], foot.shell_height_at(outline.vertex_of_corner(front))]))


def _toe_1_tip(foot: StandingFoot, found: Landmarks) -> Landmark | Missing:
    medial, lateral = found.get("metatarsale_tibiale"), found.get("metatarsale_fibulare")
    if medial is None or lateral is None:
        return "not applicable: no ball to tell the toes apart by"
    xyz = foot.shell.xyz
    border = medial.xyz_foot[1] - 0.36 * (medial.xyz_foot[1] - lateral.xyz_foot[1])
    toe = xyz[(xyz[:, 1] > border) & (xyz[:, 2] < 0.2 * foot.length_mm)]
    if len(toe) == 0:
        return "not seen"
    return Landmark(toe[toe[:, 0].argmax()])


def _toe_2_tip(foot: StandingFoot, found: Landmarks) -> Landmark | Missing:
    medial, lateral = found.get("metatarsale_tibiale"), found.get("metatarsale_fibulare")
    if medial is None or lateral is None:
        return "not applicable: no ball to tell the toes apart by"
    xy = toe_2_place(foot.alignment.outline, float(medial.xyz_foot[1]), float(lateral.xyz_foot[1]))
    near = int(np.linalg.norm(foot.alignment.outline.xy - xy, axis=1).argmin())
    height = foot.shell_height_at(foot.alignment.outline.vertex_of_corner(near))
    return Landmark(np.array([*xy, height]), doubts=(f"{NEEDS_HAND}: toe_2_tip is taken from the outline's front",))


def _instep(foot: StandingFoot, _: Landmarks) -> Landmark | Missing:
    return _top_across(foot, INSTEP_SHARE)


def _top_across(foot: StandingFoot, share: float) -> Landmark | Missing:
    xyz = foot.across(share)
    if len(xyz) == 0:
        return f"not applicable: the foot ends before {share:.0%} of the expected length"
    top = xyz[xyz[:, 2].argmax()]
    if top[2] > foot.top_mm - 1e-6:
        return f"cut off: at {share:.0%} of the length the skin is higher than the mesh ({foot.top_mm:.0f} mm)"
    near = top[2] > foot.top_mm - TOP_MARGIN_SHARE * foot.length_mm
    return Landmark(top, doubts=(f"cut off: the mesh ends at {foot.top_mm:.0f} mm, just above",) if near else ())


def _side_across(share: float, sign: float) -> Callable[[StandingFoot, Landmarks], Landmark | Missing]:
    def find(foot: StandingFoot, _: Landmarks) -> Landmark | Missing:
        xyz = foot.across(share)
        xyz = xyz[xyz[:, 2] < HEEL_BREADTH_SHARE * foot.length_mm]
        if len(xyz) == 0:
            return f"not applicable: the foot ends before {share:.0%} of the expected length"
        return Landmark(xyz[(sign * xyz[:, 1]).argmax()])

    return find


def _junction(foot: StandingFoot, found: Landmarks) -> Landmark | Missing:
    """The dorsum nearest to the heel corner: where a tape round the heel slides to."""
    corner = found["heel_corner"].xyz_foot
    ends = foot.across_top()
    steepest = float(np.arctan2(foot.top_mm - corner[2], ends - corner[0]))
    band = (JUNCTION_BAND_RAD[0], min(JUNCTION_BAND_RAD[1], steepest))
    if band[0] >= band[1]:
        return f"cut off: the mesh ends at {foot.top_mm:.0f} mm, below the bend from foot to leg"
    angle, distance, at_end = find_smallest(lambda a: _reach(foot, corner, a)[0], band)
    cut = f"cut off at {foot.top_mm:.0f} mm: the bend from foot to leg may be higher"
    far = _reach(foot, corner, angle)[1]
    place = corner + distance * np.array([np.cos(angle), 0.0, np.sin(angle)])
    place[1] = far[1]
    doubts = (cut if steepest < JUNCTION_BAND_RAD[1] else "at the end of its search band",) if at_end else ()
    return Landmark(place, doubts=doubts)


def _reach(foot: StandingFoot, corner: Floats, angle_rad: float) -> tuple[float, Floats]:
    """Largest distance (mm), square to y, from the corner within the plane through it at an angle, and that point."""
    direction = np.array([np.cos(angle_rad), 0.0, np.sin(angle_rad)])
    normal = np.array([-direction[2], 0.0, direction[0]])
    xyz = cut_shell(foot.shell, corner, normal).xyz.reshape(-1, 3)
    reach = (xyz - corner) @ direction
    far = int(reach.argmax())
    return float(reach[far]), xyz[far]


def _malleolus(sign: float) -> Callable[[StandingFoot, Landmarks], Landmark | Missing]:
    def find(foot: StandingFoot, _: Landmarks) -> Landmark | Missing:
        bottom, high = (share * foot.length_mm for share in MALLEOLUS_BAND)
        top = min(high, foot.top_mm - 0.005 * foot.length_mm)
        if top < CHORD_TOP_SHARE * foot.length_mm:
            return f"cut off: the mesh ends at {foot.top_mm:.0f} mm"
        step = _LEVEL_STEP_SHARE * foot.length_mm
        heights = bottom + step * np.arange(int((top - bottom) / step + 1e-6) + 1, dtype=np.float64)
        part = _between(foot, (bottom, top))
        points = np.array([_outermost(part, foot.length_mm, z, sign) for z in heights])
        return _bulge_of_profile(heights, points, sign, foot.length_mm)

    return find


def _between(foot: StandingFoot, z_band: tuple[float, float]) -> Shell:
    """The triangles that reach into a band of heights and into the malleoli's window along the axis."""
    x_band = (MALLEOLUS_WINDOW[0] * foot.length_mm, MALLEOLUS_WINDOW[1] * foot.length_mm)
    faces = foot.shell.faces
    for axis, (first, last) in ((2, z_band), (0, x_band)):
        a, b, c = (foot.shell.xyz[:, axis][faces[:, k]] for k in range(3))
        low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
        faces = faces[(low <= last) & (high >= first)]
    return compact(Shell(foot.shell.xyz, faces))


def _outermost(shell: Shell, length_mm: float, height_mm: float, sign: float) -> Floats:
    """The most medial or lateral point `(3,)` of the level cut, within the malleoli's window along the axis."""
    segments = cut_shell(shell, np.array([0.0, 0.0, height_mm]), np.array([0.0, 0.0, 1.0])).xyz
    points = [segments.reshape(-1, 3)]
    for x in (share * length_mm for share in MALLEOLUS_WINDOW):
        a, b = segments[:, 0], segments[:, 1]
        through = (a[:, 0] < x) != (b[:, 0] < x)
        a, b = a[through], b[through]
        points.append(a + ((x - a[:, 0]) / (b[:, 0] - a[:, 0]))[:, None] * (b - a))
    xyz = np.concatenate(points)
    low, high = (share * length_mm for share in MALLEOLUS_WINDOW)
    xyz = xyz[(xyz[:, 0] >= low - 1e-9) & (xyz[:, 0] <= high + 1e-9)]
    return xyz[(sign * xyz[:, 1]).argmax()] if len(xyz) else np.array([low, -sign * np.inf, height_mm])


def _bulge_of_profile(heights: Floats, points: Floats, sign: float, length_mm: float) -> Landmark | Missing:
    """The highest bulge of a profile outward: its most outward level, or, without one, where it rises most off
    its chord."""
    out = sign * points[:, 1]
    if not np.isfinite(out).all():
        return "not seen: the level cuts at the ankle are empty"
    peaks = np.flatnonzero((out[1:-1] >= out[:-2]) & (out[1:-1] >= out[2:])) + 1
    rises = np.array([out[p] - max(out[: p + 1].min(), out[p:].min()) for p in peaks])
    doubts: tuple[str, ...] = ()
    if len(peaks) and rises.max() > _CLEAR_BULGE_SHARE * length_mm:
        best = int(peaks[rises.argmax()])
    else:
        low = heights <= CHORD_TOP_SHARE * length_mm
        heights, points, out = heights[low], points[low], out[low]
        out = out - np.interp(heights, heights[[0, -1]], out[[0, -1]])
        best = int(out.argmax())
        doubts = ("no bulge stands out there: needs palpation",)
    half_width = _MALLEOLUS_PARABOLA_SHARE * length_mm
    height = parabola_top(heights, out, float(heights[best]), half_width)
    y = sign * float(fit_parabola(heights, sign * points[:, 1], height, half_width / 2.0)[0])
    place = np.array([float(np.interp(height, heights, points[:, 0])), y, height])
    rise = max(-float(fit_parabola(heights, out, height, half_width)[2]), 1e-6)
    within = min(half_width * _SKIN_WITHIN_MM / (2.0 * rise), half_width)
    return Landmark(place, doubts=doubts, height_within_mm=within)


RULES: tuple[LandmarkRule, ...] = (
    LandmarkRule("pternion", "rearmost heel: middle of the cap behind the chord at 1 % of the length", _pternion),
    LandmarkRule("heel_corner", "the vertical through the pternion meets the board (construction point)", _heel_corner),
    LandmarkRule("foremost_point", "foremost skin below 16 % of the length in height: the longest toe", _foremost),
    LandmarkRule(
        "metatarsale_tibiale",
        "top of the medial bulge of the skin from above, at 62-80 % of the length",
        _bulge("metatarsale_tibiale", MTH1_WINDOW, 1.0),
        "mth_1",
    ),
    LandmarkRule(
        "metatarsale_fibulare",
        "top of the lateral bulge of the skin from above, at 52-72 % of the length",
        _bulge("metatarsale_fibulare", MTH5_WINDOW, -1.0),
        "mth_5",
    ),
    LandmarkRule("toe_1_tip", "foremost skin of the medial 36 % of the ball breadth", _toe_1_tip, "toe_1"),
    LandmarkRule("toe_2_tip", "front of the outline at 42 % of the ball breadth from medial", _toe_2_tip, "toe_2"),
    LandmarkRule("instep_point", "top of the dorsum at 50 % of the length", _instep),
    LandmarkRule("heel_medial", "most medial skin across 16 % of the length", _side_across(HEEL_BREADTH_SHARE, 1.0)),
    LandmarkRule("heel_lateral", "most lateral skin across 16 % of the length", _side_across(HEEL_BREADTH_SHARE, -1.0)),
    LandmarkRule(
        "toe_1_side", "most medial skin across 90 % of the length", _side_across(TOE_1_SIDE_SHARE, 1.0), "toe_1"
    ),
    LandmarkRule(
        "toe_5_side", "most lateral skin across 80 % of the length", _side_across(TOE_5_SIDE_SHARE, -1.0), "toe_5"
    ),
    LandmarkRule("malleolus_medialis", "most medial level of the inner ankle's bulge", _malleolus(1.0)),
    LandmarkRule("malleolus_lateralis", "most lateral level of the outer ankle's bulge", _malleolus(-1.0)),
    LandmarkRule("junction_point", "dorsum nearest to the heel corner, seen from the side", _junction),
)
"""Every landmark found without a hand, in the order they are found."""

BY_HAND = ("navicular", "sphyrion", "sphyrion_fibulare", "toe_3_tip", "toe_4_tip", "toe_5_tip")
"""Landmarks that only a hand can give."""
