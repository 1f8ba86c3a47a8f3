"""The measurements: one entry in `CATALOGUE` each. To add one, add an entry; nothing else knows their names.

Everything is in the foot frame (x heel to toe, y medial, z up from the board) and in shares of the foot length.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

from footscan.foot.landmarks import Landmarks
from footscan.foot.readings import (
    Missing,
    Reading,
    across,
    along,
    ankle_girth,
    ball_girth,
    ball_height,
    bend_angle,
    foot_breadth,
    foot_length,
    heel_girth,
    height_index,
    height_of,
    instep_girth,
    length_along,
    level_distance,
    overall_extent,
    surface_to_cut,
    toe_height,
    volume_to_cut,
    waist_girth,
    width_at,
)
from footscan.foot.standing import StandingFoot

Unit = Literal["mm", "deg", "cm3", "cm2", "1"]


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


_MTH = ("metatarsale_tibiale", "metatarsale_fibulare")

CATALOGUE: tuple[Entry, ...] = (
    Entry(
        "foot_length",
        "mm",
        "pternion to the longest toe, along the foot axis",
        ("pternion", "foremost_point"),
        foot_length,
    ),
    Entry(
        "foot_length_a1",
        "mm",
        "extent along the axis from the pternion to the tip of the second toe (A1)",
        ("pternion", "toe_2_tip"),
        length_along("A1"),
    ),
    Entry(
        "ball_length",
        "mm",
        "pternion to metatarsale tibiale, along the axis",
        ("pternion", _MTH[0]),
        along("pternion", _MTH[0]),
    ),
    Entry(
        "outside_ball_length",
        "mm",
        "pternion to metatarsale fibulare, along the axis",
        ("pternion", _MTH[1]),
        along("pternion", _MTH[1]),
    ),
    Entry("foot_breadth", "mm", "across the axis, most medial to most lateral at the ball", _MTH, foot_breadth, _MTH),
    Entry("foot_breadth_diagonal", "mm", "metatarsale tibiale to fibulare, from above", _MTH, level_distance(*_MTH)),
    Entry(
        "ball_girth", "mm", "tape round the upright plane through metatarsale tibiale and fibulare", _MTH, ball_girth
    ),
    Entry(
        "waist_girth",
        "mm",
        "smallest tape girth parallel to the ball plane, crossing the axis at 52-64 % of the length",
        _MTH,
        waist_girth,
        _MTH,
    ),
    Entry(
        "instep_girth",
        "mm",
        "tape round the upright plane across the axis at the instep point",
        ("instep_point",),
        instep_girth,
    ),
    Entry(
        "long_heel_girth",
        "mm",
        "tape round the heel corner and the junction point, square to the side view",
        ("heel_corner", "junction_point"),
        partial(heel_girth, "junction_point"),
    ),
    Entry(
        "short_heel_girth",
        "mm",
        "tape round the heel corner and the instep point, square to the side view",
        ("heel_corner", "instep_point"),
        partial(heel_girth, "instep_point"),
    ),
    Entry("ankle_girth", "mm", "smallest level tape girth at 30-51 % of the length in height", (), ankle_girth),
    Entry(
        "heel_breadth",
        "mm",
        "width of the cut across the axis at 16 % of the length, below 16 % in height",
        ("heel_medial", "heel_lateral"),
        across("heel_medial", "heel_lateral"),
    ),
    Entry(
        "midfoot_breadth",
        "mm",
        "width of the cut across the axis at 50 % of the length, below 16 % of it in height",
        ("pternion",),
        width_at(0.5),
    ),
    Entry(
        "bimalleolar_breadth",
        "mm",
        "across the axis, malleolus to malleolus",
        ("malleolus_medialis", "malleolus_lateralis"),
        across("malleolus_medialis", "malleolus_lateralis"),
    ),
    Entry(
        "malleolus_medialis_height",
        "mm",
        "board to the most medial level of the inner malleolus",
        ("malleolus_medialis",),
        height_of("malleolus_medialis"),
    ),
    Entry(
        "malleolus_lateralis_height",
        "mm",
        "board to the most lateral level of the outer malleolus",
        ("malleolus_lateralis",),
        height_of("malleolus_lateralis"),
    ),
    Entry("instep_height", "mm", "board to the instep point", ("instep_point",), height_of("instep_point")),
    Entry("ball_height", "mm", "board to the top of the ball plane's cut", _MTH, ball_height, _MTH),
    Entry(
        "toe_height",
        "mm",
        "board to the dorsum of the first toe, across 90 % of the length",
        (*_MTH, "toe_1_tip"),
        toe_height,
        _MTH,
    ),
    Entry("navicular_height", "mm", "board to the navicular, marked by hand", ("navicular",), height_of("navicular")),
    Entry(
        "toe_1_angle",
        "deg",
        "how far the outline medial of toe 1 leans to lateral from the line heel to ball",
        ("heel_medial", _MTH[0], "toe_1_side"),
        bend_angle("heel_medial", _MTH[0], "toe_1_side", 1.0),
    ),
    Entry(
        "toe_5_angle",
        "deg",
        "how far the outline lateral of toe 5 leans to medial from the line heel to ball",
        ("heel_lateral", _MTH[1], "toe_5_side"),
        bend_angle("heel_lateral", _MTH[1], "toe_5_side", -1.0),
    ),
    Entry(
        "height_index",
        "1",
        "instep height over ball length (arch height index)",
        ("pternion", _MTH[0], "instep_point"),
        height_index,
    ),
    Entry(
        "overall_length",
        "mm",
        "extent along the axis of the skin below 16 % of the length in height",
        (),
        overall_extent(0),
    ),
    Entry(
        "overall_breadth",
        "mm",
        "extent across the axis of the skin below 16 % of the length in height",
        (),
        overall_extent(1),
    ),
    Entry("volume", "cm3", "outer volume below 35 % of the length in height, on a flat sole", (), volume_to_cut),
    Entry(
        "surface_area",
        "cm2",
        "surface below 35 % of the length in height, flat sole included",
        (),
        surface_to_cut,
    ),
)

NOT_MEASURABLE: dict[str, str] = {
    "footprint_area": "the sole stands on an opaque board: no camera sees it",
    "contact_area": "the sole stands on an opaque board: what touches it is not seen",
    "arch_vault": "the medial arch is hardly seen below 15 mm: its vault is assumed",
    "heel_seat_contour": "skin below about 8 mm is seldom seen: the heel's edge on the board is assumed",
    "toe_cleft_depth": "the walls of toe clefts are almost never lit and seen: the clefts are bridged",
}
"""What this machine cannot measure by construction, and why."""
