"""How measurements are read off a standing foot: the rules behind the entries of the catalogue.

Every rule gets the foot and its landmarks in the foot frame and gives a `Reading`, or says why there is none.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats
from footscan.foot.align import AxisName, fit_axis
from footscan.foot.clip import cut_below
from footscan.foot.girth import Girth, find_smallest, measure_girth
from footscan.foot.landmarks import Landmark, Landmarks
from footscan.foot.sections import tape_girth_mm
from footscan.foot.shell import NEVER_SEEN_BELOW_MM, area_mm2, volume_mm3
from footscan.foot.skin_origin import Origin
from footscan.foot.sole_bounds import area_interval_mm2, volume_interval_mm3
from footscan.foot.standing import TOP_MARGIN_SHARE, VOLUME_HEIGHT_SHARE, StandingFoot

ANKLE_BAND = (0.30, 0.51)
WAIST_BAND = (0.52, 0.64)
TOE_HEIGHT_SHARE = 0.90
WIDTH_HEIGHT_SHARE = 0.16
UNSEEN_LIMIT = 0.10
"""A girth of which more than this share, above the sole's edge, was not seen is not reliable."""
END_MM = 1.0
FLAT_MM = 0.3
"""A height known worse than this is not reliable."""
_BESIDE_SHARE = 0.06
"""The end of a length is the skin within `END_MM` of its extreme; at the ball, within this share of the length in x."""
_MTH = ("metatarsale_tibiale", "metatarsale_fibulare")

_X, _Y, _Z = np.eye(3)


@dataclass(frozen=True)
class Reading:
    """What a rule gives: a value in the entry's unit, an interval where the value rests on the assumed sole, doubts
    about the measuring, and for girths the plane of the tape (a point and the unit normal, `(3,)` each)."""

    value: float
    interval: tuple[float, float] | None = None
    doubts: tuple[str, ...] = ()
    tape: tuple[Floats, Floats] | None = None


Missing = str


def along(first: str, second: str) -> Callable[[StandingFoot, Landmarks], Reading]:
    """Distance along the axis from one landmark to another."""
    return lambda _, marks: Reading(float(_between(marks[first], marks[second])[0]))


def length_along(axis: AxisName) -> Callable[[StandingFoot, Landmarks], Reading]:
    """Extent of the low skin along another definition of the foot axis."""

    def measure(foot: StandingFoot, marks: Landmarks) -> Reading:
        outline = foot.alignment.outline
        xy_given = {name: xyz[:2] for name, xyz in foot.given.items()}
        return Reading(float(np.ptp(outline.xy @ fit_axis(outline, _X[:2], axis, xy_given, mirrored=False))))

    return measure


def across(first: str, second: str) -> Callable[[StandingFoot, Landmarks], Reading]:
    """Distance across the axis between two landmarks."""
    return lambda _, marks: Reading(abs(float(_between(marks[first], marks[second])[1])))


def width_at(share: float) -> Callable[[StandingFoot, Landmarks], Reading | Missing]:
    """Width of the cut across the axis at a share of the length, below `WIDTH_HEIGHT_SHARE` of the length in height."""

    def measure(foot: StandingFoot, _: Landmarks) -> Reading | Missing:
        xyz = foot.across(share)
        low = xyz[xyz[:, 2] < WIDTH_HEIGHT_SHARE * foot.length_mm]
        if len(low) == 0:
            return "not applicable: the foot does not reach that far"
        return Reading(float(np.ptp(low[:, 1])))

    return measure


def level_distance(first: str, second: str) -> Callable[[StandingFoot, Landmarks], Reading]:
    """Distance between two landmarks seen from above."""
    return lambda _, marks: Reading(float(np.linalg.norm(_between(marks[first], marks[second])[:2])))


def height_of(name: str) -> Callable[[StandingFoot, Landmarks], Reading]:
    """Height of a landmark above the board; on a flat bulge it is known badly, and that is a doubt."""

    def measure(_: StandingFoot, marks: Landmarks) -> Reading:
        within = marks[name].height_within_mm
        flat = (f"the bulge is flat: its top is known to {within:.1f} mm only",) if within > FLAT_MM else ()
        return Reading(float(marks[name].xyz_foot[2]), None, flat)

    return measure


def _between(first: Landmark, second: Landmark) -> Floats:
    return second.xyz_foot - first.xyz_foot


def _taped(foot: StandingFoot, origin: Floats, normal: Floats, doubts: tuple[str, ...] = ()) -> Reading | Missing:
    unit = normal / np.linalg.norm(normal)
    girth = measure_girth(foot.shell, foot.length_mm, origin, unit)
    if girth is None:
        return "not applicable: the foot does not reach that far"
    return Reading(girth.value_mm, girth.interval_mm, doubts + _girth_doubts(foot, girth), (origin, unit))


def _girth_doubts(foot: StandingFoot, girth: Girth) -> tuple[str, ...]:
    doubts: list[str] = []
    if girth.unseen_share > UNSEEN_LIMIT:
        doubts.append(f"not seen: {girth.unseen_share:.0%} of the skin there")
    if girth.xyz[:, 2].max() > foot.top_mm - TOP_MARGIN_SHARE * foot.length_mm:
        doubts.append(f"cut off: the tape runs over or just below the top of the mesh ({foot.top_mm:.0f} mm)")
    return tuple(doubts)


def _ball_normal(marks: Landmarks) -> Floats:
    """Unit normal `(3,)` of the upright plane through both metatarsal heads, pointing forward."""
    across = _between(marks["metatarsale_fibulare"], marks["metatarsale_tibiale"])
    normal = np.array([across[1], -across[0], 0.0])
    return normal / np.linalg.norm(normal)


def ball_girth(foot: StandingFoot, marks: Landmarks) -> Reading | Missing:
    """Tape round the upright plane through both metatarsal heads."""
    return _taped(foot, marks["metatarsale_tibiale"].xyz_foot, _ball_normal(marks))


def waist_girth(foot: StandingFoot, marks: Landmarks) -> Reading | Missing:
    """The smallest tape girth parallel to the ball plane, within `WAIST_BAND`."""
    normal = _ball_normal(marks)
    band = (WAIST_BAND[0] * foot.length_mm, WAIST_BAND[1] * foot.length_mm)
    x, _, at_end = find_smallest(lambda place: tape_girth_mm(foot.shell, place * _X, normal), band)
    doubts = ("no smallest girth inside its search band",) if at_end else ()
    return _taped(foot, x * _X, normal, doubts)


def instep_girth(foot: StandingFoot, marks: Landmarks) -> Reading | Missing:
    """Tape round the upright plane across the axis at the instep point."""
    return _taped(foot, marks["instep_point"].xyz_foot, _X)


def heel_girth(to: str, foot: StandingFoot, marks: Landmarks) -> Reading | Missing:
    """Tape round the heel corner and a landmark on the dorsum, square to the side view."""
    corner = marks["heel_corner"].xyz_foot
    return _taped(foot, corner, np.cross(marks[to].xyz_foot - corner, _Y))


def ankle_girth(foot: StandingFoot, _: Landmarks) -> Reading | Missing:
    """The smallest level tape girth within `ANKLE_BAND`, as far as the mesh reaches."""
    low, high = (share * foot.length_mm for share in ANKLE_BAND)
    top = foot.top_mm - 0.004 * foot.length_mm
    if top < low:
        return f"cut off: the mesh ends at {foot.top_mm:.0f} mm, below the ankle"
    z, _value, at_end = find_smallest(lambda place: tape_girth_mm(foot.shell, place * _Z, _Z), (low, min(high, top)))
    doubts: tuple[str, ...] = ()
    if at_end and top < high:
        doubts = (f"cut off at {foot.top_mm:.0f} mm: the leg may be thinner higher up",)
    elif at_end:
        doubts = ("no smallest girth inside its search band",)
    return _taped(foot, z * _Z, _Z, doubts)


def ball_height(foot: StandingFoot, marks: Landmarks) -> Reading | Missing:
    """Highest point of the ball plane's cut."""
    girth = measure_girth(foot.shell, foot.length_mm, marks["metatarsale_tibiale"].xyz_foot, _ball_normal(marks))
    return Reading(float(girth.xyz[:, 2].max())) if girth else "not applicable: the foot does not reach that far"


def toe_height(foot: StandingFoot, marks: Landmarks) -> Reading | Missing:
    """Highest skin of the medial half across `TOE_HEIGHT_SHARE` of the length."""
    xyz = foot.across(TOE_HEIGHT_SHARE)
    middle = (marks["metatarsale_tibiale"].xyz_foot[1] + marks["metatarsale_fibulare"].xyz_foot[1]) / 2.0
    xyz = xyz[xyz[:, 1] > middle]
    return Reading(float(xyz[:, 2].max())) if len(xyz) else "not applicable: no toe there"


def bend_angle(heel: str, ball: str, toe: str, sign: float) -> Callable[[StandingFoot, Landmarks], Reading]:
    """Angle by which the line ball-toe leans towards the foot's middle from the line heel-ball, seen from above."""

    def measure(_: StandingFoot, marks: Landmarks) -> Reading:
        back, front = _between(marks[heel], marks[ball])[:2], _between(marks[ball], marks[toe])[:2]
        cross = float(front[0] * back[1] - front[1] * back[0])
        return Reading(sign * float(np.degrees(np.arctan2(cross, float(back @ front)))))

    return measure


def height_index(_: StandingFoot, marks: Landmarks) -> Reading:
    """Instep height over ball length."""
    ball_length = float(_between(marks["pternion"], marks["metatarsale_tibiale"])[0])
    return Reading(float(marks["instep_point"].xyz_foot[2]) / ball_length)


def volume_to_cut(foot: StandingFoot, _: Landmarks) -> Reading:
    """Volume (cm3) below `VOLUME_HEIGHT_SHARE` of the length in height."""
    height = VOLUME_HEIGHT_SHARE * foot.length_mm
    open_shell = cut_below(foot.shell, height, cap=False)
    inside = volume_mm3(open_shell, min(height, foot.top_mm) * _Z)
    low, high = volume_interval_mm3(open_shell, min(height, foot.top_mm), inside)
    return Reading(inside / 1000.0, (low / 1000.0, high / 1000.0), _counted(foot, height))


def surface_to_cut(foot: StandingFoot, _: Landmarks) -> Reading:
    """Skin (cm2) below `VOLUME_HEIGHT_SHARE` of the length in height."""
    height = VOLUME_HEIGHT_SHARE * foot.length_mm
    open_shell = cut_below(foot.shell, height, cap=False)
    area = area_mm2(open_shell)
    doubts = _counted(foot, height)
    if open_shell.origin is not None:
        upper = open_shell.xyz[open_shell.faces][:, :, 2].mean(axis=1) > NEVER_SEEN_BELOW_MM
        unseen = (open_shell.origin != Origin.SEEN)[open_shell.faces].mean(axis=1)
        share = float((area * unseen)[upper].sum() / area[upper].sum())
        if share > UNSEEN_LIMIT:
            doubts += (f"not seen: {share:.0%} of the skin above the sole's edge",)
    low, high = area_interval_mm2(open_shell, float(area.sum()))
    return Reading(float(area.sum()) / 100.0, (low / 100.0, high / 100.0), doubts)


def _counted(foot: StandingFoot, height_mm: float) -> tuple[str, ...]:
    if foot.top_mm >= height_mm - 1e-9:
        return ()
    return (f"cut off at {foot.top_mm:.0f} mm: counted to there, not to {height_mm:.0f} mm",)


def overall_extent(axis: int) -> Callable[[StandingFoot, Landmarks], Reading]:
    """Extent of the low skin along (0) or across (1) the axis."""

    def measure(foot: StandingFoot, _: Landmarks) -> Reading:
        return Reading(float(np.ptp(foot.alignment.outline.xy[:, axis])), None, _unseen_ends(foot, axis))

    return measure


def foot_length(foot: StandingFoot, marks: Landmarks) -> Reading:
    """Distance along the axis from the pternion to the foremost point; a hand's landmarks need no skin."""
    value = float(_between(marks["pternion"], marks["foremost_point"])[0])
    by_hand = marks["pternion"].source == marks["foremost_point"].source == "manual"
    return Reading(value, None, () if by_hand else _unseen_ends(foot, 0))


def foot_breadth(foot: StandingFoot, marks: Landmarks) -> Reading:
    """Distance across the axis between the metatarsal heads; the skin beside each must be seen."""
    xyz, doubts = foot.uncut_xyz[foot.alignment.outline.vertex], ()
    for name, side, sign in (("metatarsale_tibiale", "medial", 1.0), ("metatarsale_fibulare", "lateral", -1.0)):
        x, y, _ = marks[name].xyz_foot
        near = (np.abs(xyz[:, 0] - x) < _BESIDE_SHARE * foot.length_mm) & (sign * (xyz[:, 1] - y) > -END_MM)
        doubts += () if marks[name].source == "manual" else _unseen_end(foot, near, f"{side} side of the ball")
    return Reading(abs(float(_between(*(marks[n] for n in _MTH))[1])), None, doubts)


def _unseen_ends(foot: StandingFoot, axis: int) -> tuple[str, ...]:
    """A doubt for each end of the outline along an axis whose skin was mostly not seen."""
    reach = foot.alignment.outline.xy_skin[:, axis]
    low, high = (("heel", "front"), ("lateral side", "medial side"))[axis]
    return _unseen_end(foot, reach < reach.min() + END_MM, low) + _unseen_end(foot, reach > reach.max() - END_MM, high)


def _unseen_end(foot: StandingFoot, near: Bools, words: str) -> tuple[str, ...]:
    unseen = foot.uncut_unseen[foot.alignment.outline.vertex[near]]
    share = float(unseen.mean()) if len(unseen) else 0.0
    return (f"not seen: {share:.0%} of the skin at its end ({words})",) if share > 0.5 else ()
