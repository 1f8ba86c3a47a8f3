"""The measurements: one entry in `CATALOGUE` each. To add one, add an entry; nothing else knows their names.

Everything is in the foot frame (x heel to toe, y medial, z up from the board) and in shares of the foot length.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from footscan.coordinates import Floats
from footscan.foot.align import AxisName, fit_axis
from footscan.foot.clip import cut_below
from footscan.foot.girth import Girth, find_smallest, measure_girth
from footscan.foot.landmarks import Landmark, Landmarks
from footscan.foot.sections import tape_girth_mm
from footscan.foot.shell import NEVER_SEEN_BELOW_MM, area_mm2, volume_mm3
from footscan.foot.skin_origin import Origin
from footscan.foot.standing import VOLUME_HEIGHT_SHARE, StandingFoot

ANKLE_BAND = (0.30, 0.51)
WAIST_BAND = (0.52, 0.64)
TOE_HEIGHT_SHARE = 0.90
UNSEEN_LIMIT = 0.10
"""A girth of which more than this share, above the sole's edge, was not seen is not reliable."""

Unit = Literal["mm", "deg", "cm3", "cm2", "1"]
_X, _Y, _Z = np.eye(3)


@dataclass(frozen=True)
class Reading:
    """What a rule gives: a value in the entry's unit, for girths an interval, and doubts about the measuring."""

    value: float
    interval: tuple[float, float] | None = None
    doubts: tuple[str, ...] = ()


Missing = str


@dataclass(frozen=True)
class Entry:
    """One measurement.

    Attributes:
        name: Its key everywhere.
        unit: mm, deg, cm3, cm2, or 1 for a ratio.
        definition: One line for people.
        needs: Landmarks it is taken from; their doubts are its doubts, and without one of them there is no value.
        measure: The rule, given the foot and all landmarks.
        exempt: Landmarks of `needs` whose being taken from the skin is no doubt, because the skin is what is measured.
    """

    name: str
    unit: Unit
    definition: str
    needs: tuple[str, ...]
    measure: Callable[[StandingFoot, Landmarks], Reading | Missing]
    exempt: tuple[str, ...] = ()


def _along(first: str, second: str) -> Callable[[StandingFoot, Landmarks], Reading]:
    return lambda _, marks: Reading(float(_between(marks[first], marks[second])[0]))


def _length_along(axis: AxisName) -> Callable[[StandingFoot, Landmarks], Reading]:
    """Extent of the low skin along another definition of the foot axis."""

    def measure(foot: StandingFoot, marks: Landmarks) -> Reading:
        outline = foot.alignment.outline
        xy_given = {name: xyz[:2] for name, xyz in foot.given.items()}
        return Reading(float(np.ptp(outline.xy @ fit_axis(outline, _X[:2], axis, xy_given, mirrored=False))))

    return measure


def _across(first: str, second: str) -> Callable[[StandingFoot, Landmarks], Reading]:
    return lambda _, marks: Reading(abs(float(_between(marks[first], marks[second])[1])))


def _level(first: str, second: str) -> Callable[[StandingFoot, Landmarks], Reading]:
    return lambda _, marks: Reading(float(np.linalg.norm(_between(marks[first], marks[second])[:2])))


def _height(name: str) -> Callable[[StandingFoot, Landmarks], Reading]:
    return lambda _, marks: Reading(float(marks[name].xyz_foot[2]))


def _between(first: Landmark, second: Landmark) -> Floats:
    return second.xyz_foot - first.xyz_foot


def _taped(foot: StandingFoot, origin: Floats, normal: Floats, doubts: tuple[str, ...] = ()) -> Reading | Missing:
    girth = measure_girth(foot.shell, foot.length_mm, origin, normal / np.linalg.norm(normal))
    if girth is None:
        return "not applicable: the foot does not reach that far"
    return Reading(girth.value_mm, girth.interval_mm, doubts + _girth_doubts(foot, girth))


def _girth_doubts(foot: StandingFoot, girth: Girth) -> tuple[str, ...]:
    doubts: list[str] = []
    if girth.unseen_share > UNSEEN_LIMIT:
        doubts.append(f"not seen: {girth.unseen_share:.0%} of the skin there")
    if girth.xyz[:, 2].max() > foot.top_mm - 1e-6:
        doubts.append(f"cut off: the tape runs over the top of the mesh ({foot.top_mm:.0f} mm)")
    return tuple(doubts)


def _ball_normal(marks: Landmarks) -> Floats:
    """Unit normal `(3,)` of the upright plane through both metatarsal heads, pointing forward."""
    across = _between(marks["metatarsale_fibulare"], marks["metatarsale_tibiale"])
    normal = np.array([across[1], -across[0], 0.0])
    return normal / np.linalg.norm(normal)


def _ball_girth(foot: StandingFoot, marks: Landmarks) -> Reading | Missing:
    return _taped(foot, marks["metatarsale_tibiale"].xyz_foot, _ball_normal(marks))


def _waist_girth(foot: StandingFoot, marks: Landmarks) -> Reading | Missing:
    normal = _ball_normal(marks)
    band = (WAIST_BAND[0] * foot.length_mm, WAIST_BAND[1] * foot.length_mm)
    x, _, at_end = find_smallest(lambda place: tape_girth_mm(foot.shell, place * _X, normal), band)
    doubts = ("no smallest girth inside its search band",) if at_end else ()
    return _taped(foot, x * _X, normal, doubts)


def _instep_girth(foot: StandingFoot, marks: Landmarks) -> Reading | Missing:
    return _taped(foot, marks["instep_point"].xyz_foot, _X)


def _heel_girth(to: str, foot: StandingFoot, marks: Landmarks) -> Reading | Missing:
    corner = marks["heel_corner"].xyz_foot
    return _taped(foot, corner, np.cross(marks[to].xyz_foot - corner, _Y))


def _ankle_girth(foot: StandingFoot, _: Landmarks) -> Reading | Missing:
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


def _ball_height(foot: StandingFoot, marks: Landmarks) -> Reading | Missing:
    girth = measure_girth(foot.shell, foot.length_mm, marks["metatarsale_tibiale"].xyz_foot, _ball_normal(marks))
    return Reading(float(girth.xyz[:, 2].max())) if girth else "not applicable: the foot does not reach that far"


def _toe_height(foot: StandingFoot, marks: Landmarks) -> Reading | Missing:
    xyz = foot.across(TOE_HEIGHT_SHARE)
    middle = (marks["metatarsale_tibiale"].xyz_foot[1] + marks["metatarsale_fibulare"].xyz_foot[1]) / 2.0
    xyz = xyz[xyz[:, 1] > middle]
    return Reading(float(xyz[:, 2].max())) if len(xyz) else "not applicable: no toe there"


def _bend(heel: str, ball: str, toe: str, sign: float) -> Callable[[StandingFoot, Landmarks], Reading]:
    """Angle by which the line ball-toe leans towards the foot's middle from the line heel-ball, seen from above."""

    def measure(_: StandingFoot, marks: Landmarks) -> Reading:
        back, front = _between(marks[heel], marks[ball])[:2], _between(marks[ball], marks[toe])[:2]
        cross = float(front[0] * back[1] - front[1] * back[0])
        return Reading(sign * float(np.degrees(np.arctan2(cross, float(back @ front)))))

    return measure


def _height_index(_: StandingFoot, marks: Landmarks) -> Reading:
    ball_length = float(_between(marks["pternion"], marks["metatarsale_tibiale"])[0])
    return Reading(float(marks["instep_point"].xyz_foot[2]) / ball_length)


def _volume(foot: StandingFoot, _: Landmarks) -> Reading:
    height = VOLUME_HEIGHT_SHARE * foot.length_mm
    open_shell = cut_below(foot.shell, height, cap=False)
    inside = volume_mm3(open_shell, min(height, foot.top_mm) * _Z)
    return Reading(inside / 1000.0, None, _counted(foot, height))


def _surface(foot: StandingFoot, _: Landmarks) -> Reading:
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
    return Reading(float(area.sum()) / 100.0, None, doubts)


def _counted(foot: StandingFoot, height_mm: float) -> tuple[str, ...]:
    if foot.top_mm >= height_mm - 1e-9:
        return ()
    return (f"cut off at {foot.top_mm:.0f} mm: counted to there, not to {height_mm:.0f} mm",)


def _overall(axis: int) -> Callable[[StandingFoot, Landmarks], Reading]:
    return lambda foot, _: Reading(float(np.ptp(foot.alignment.outline.xy[:, axis])))


_MTH = ("metatarsale_tibiale", "metatarsale_fibulare")

CATALOGUE: tuple[Entry, ...] = (
    Entry(
        "foot_length",
        "mm",
        "pternion to the longest toe, along the foot axis",
        ("pternion", "foremost_point"),
        _along("pternion", "foremost_point"),
    ),
    Entry(
        "foot_length_a1",
        "mm",
        "extent along the axis from the pternion to the tip of the second toe (A1)",
        ("pternion", "toe_2_tip"),
        _length_along("A1"),
    ),
    Entry(
        "ball_length",
        "mm",
        "pternion to metatarsale tibiale, along the axis",
        ("pternion", _MTH[0]),
        _along("pternion", _MTH[0]),
    ),
    Entry(
        "outside_ball_length",
        "mm",
        "pternion to metatarsale fibulare, along the axis",
        ("pternion", _MTH[1]),
        _along("pternion", _MTH[1]),
    ),
    Entry("foot_breadth", "mm", "across the axis, most medial to most lateral at the ball", _MTH, _across(*_MTH), _MTH),
    Entry("foot_breadth_diagonal", "mm", "metatarsale tibiale to fibulare, seen from above", _MTH, _level(*_MTH)),
    Entry(
        "ball_girth", "mm", "tape round the upright plane through metatarsale tibiale and fibulare", _MTH, _ball_girth
    ),
    Entry(
        "waist_girth",
        "mm",
        "smallest tape girth parallel to the ball plane, crossing the axis at 52-64 % of the length",
        _MTH,
        _waist_girth,
        _MTH,
    ),
    Entry(
        "instep_girth",
        "mm",
        "tape round the upright plane across the axis at the instep point",
        ("instep_point",),
        _instep_girth,
    ),
    Entry(
        "long_heel_girth",
        "mm",
        "tape round the heel corner and the junction point, square to the side view",
        ("heel_corner", "junction_point"),
        partial(_heel_girth, "junction_point"),
    ),
    Entry(
        "short_heel_girth",
        "mm",
        "tape round the heel corner and the instep point, square to the side view",
        ("heel_corner", "instep_point"),
        partial(_heel_girth, "instep_point"),
    ),
    Entry("ankle_girth", "mm", "smallest level tape girth at 30-51 % of the length in height", (), _ankle_girth),
    Entry(
        "heel_breadth",
        "mm",
        "width of the cut across the axis at 16 % of the length, below 16 % in height",
        ("heel_medial", "heel_lateral"),
        _across("heel_medial", "heel_lateral"),
    ),
    Entry(
        "bimalleolar_breadth",
        "mm",
        "across the axis, malleolus to malleolus",
        ("malleolus_medialis", "malleolus_lateralis"),
        _across("malleolus_medialis", "malleolus_lateralis"),
    ),
    Entry(
        "malleolus_medialis_height",
        "mm",
        "board to the most medial level of the inner malleolus",
        ("malleolus_medialis",),
        _height("malleolus_medialis"),
    ),
    Entry(
        "malleolus_lateralis_height",
        "mm",
        "board to the most lateral level of the outer malleolus",
        ("malleolus_lateralis",),
        _height("malleolus_lateralis"),
    ),
    Entry("instep_height", "mm", "board to the instep point", ("instep_point",), _height("instep_point")),
    Entry("ball_height", "mm", "board to the top of the ball plane's cut", _MTH, _ball_height, _MTH),
    Entry(
        "toe_height",
        "mm",
        "board to the dorsum of the first toe, across 90 % of the length",
        (*_MTH, "toe_1_tip"),
        _toe_height,
        _MTH,
    ),
    Entry("navicular_height", "mm", "board to the navicular, marked by hand", ("navicular",), _height("navicular")),
    Entry(
        "toe_1_angle",
        "deg",
        "how far the outline medial of toe 1 leans to lateral from the line heel to ball",
        ("heel_medial", _MTH[0], "toe_1_side"),
        _bend("heel_medial", _MTH[0], "toe_1_side", 1.0),
    ),
    Entry(
        "toe_5_angle",
        "deg",
        "how far the outline lateral of toe 5 leans to medial from the line heel to ball",
        ("heel_lateral", _MTH[1], "toe_5_side"),
        _bend("heel_lateral", _MTH[1], "toe_5_side", -1.0),
    ),
    Entry(
        "height_index",
        "1",
        "instep height over ball length (arch height index)",
        ("pternion", _MTH[0], "instep_point"),
        _height_index,
    ),
    Entry(
        "overall_length", "mm", "extent along the axis from above, below 16 % of the length in height", (), _overall(0)
    ),
    Entry(
        "overall_breadth",
        "mm",
        "extent across the axis from above, below 16 % of the length in height",
        (),
        _overall(1),
    ),
    Entry("volume", "cm3", "outer volume below 35 % of the length in height, on a flat sole", (), _volume),
    Entry("surface_area", "cm2", "outer surface below 35 % of the length in height, flat sole included", (), _surface),
)

NOT_MEASURABLE: dict[str, str] = {
    "footprint_area": "the sole stands on an opaque board: no camera sees it",
    "contact_area": "the sole stands on an opaque board: what touches it is not seen",
    "arch_vault": "the medial arch is hardly seen below 15 mm: its vault is assumed",
    "heel_seat_contour": "skin below about 8 mm is seldom seen: the heel's edge on the board is assumed",
    "toe_cleft_depth": "the walls of toe clefts are almost never lit and seen: the clefts are bridged",
}
"""What this machine cannot measure by construction, and why."""
