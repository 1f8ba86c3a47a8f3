"""Two lasts that become one pair of shoes: what must be equal however unlike the feet are, and how it is made so.

Sizes, widths and girths may differ from foot to foot. Style, pitch, toe and height of the cone may not: they are what
one sees of a pair of shoes, and what its heels and quarters are cut for.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from footscan.coordinates import Floats
from footscan.errors import InputError
from footscan.foot.nurbs import SplineTube
from footscan.shoelast.custom_report import slope_deg
from footscan.shoelast.dimensions import Dimension, dimensions, with_points_and_lines
from footscan.shoelast.model import Shoelast
from footscan.shoelast.patches import ChordDisc

SHARED_MM = {"pitch": 0.5, "toe_spring": 0.5}
"""Dimensions that may differ by so much and cannot be made equal."""
CONE_MM = 0.1
"""Cones that differ by more are made equal."""
_TOE_SHARE, _TOE_PLACES, _TIP_MM = 0.18, 25, 2.0
_RISING_OVER_MM, _MOST_RISE_MM = 30.0, 12.0
_TOES = (0.85, 0.98)


@dataclass(frozen=True)
class Agreement:
    """A property that a pair shares: both values, and by how much they may differ (None: only stated)."""

    left: float
    right: float
    limit: float | None
    unit: Literal["mm", "deg"]

    @property
    def kept(self) -> bool:
        """Within the limit."""
        return self.limit is None or abs(self.left - self.right) <= self.limit


def agreements(left: Shoelast, right: Shoelast) -> dict[str, Agreement]:
    """What a pair of shoes shares, name -> values of both lasts.

    `toe_shape` is how far the outlines of the toes lie apart in plan (the foremost 18 % of the feather edge, tip on
    tip, each scaled to the mean width of both bottoms at the ball). The height of the toe box grows with size and
    width and where a foot needs it: it is only stated.
    """
    one, other = dimensions(left), dimensions(right)

    def of(name: str, limit: float | None) -> Agreement:
        return Agreement(one[name].value, other[name].value, limit, "mm")

    return {
        **{name: of(name, limit) for name, limit in SHARED_MM.items()},
        "toe_slope": Agreement(slope_deg(left, *_TOES), slope_deg(right, *_TOES), 1.0, "deg"),
        "toe_shape": Agreement(0.0, _toes_apart_mm((left, right), (one, other)), 1.5, "mm"),
        "cone_height": of("cone_height", 0.2),
        "cone_slope": Agreement(_cone_slope_deg(left), _cone_slope_deg(right), 1.5, "deg"),
        "toe_box_height": of("toe_box_height", None),
    }


def check_pair(left: Shoelast, right: Shoelast) -> None:
    """Refuse two lasts that cannot become one pair of shoes; cones may differ, as they can be made equal.

    Raises:
        InputError: Another style, pitch, toe or cone, with both values.
    """
    names = f"{left.name} and {right.name}"
    advice = "take two lasts of one style (`footscan lasts rank LEFT --other RIGHT` lists pairs)."
    if left.style != right.style:
        said = " and ".join(one.style or "of unknown style" for one in (left, right))
        raise InputError(f"a pair has one style, {names} are {said}; {advice}")
    for name, found in agreements(left, right).items():
        if name == "cone_height" and abs(found.left - found.right) <= _MOST_RISE_MM:
            continue
        if not found.kept:
            raise InputError(f"{names} are no pair: {_words(name, found)}; {advice}")


def _words(name: str, found: Agreement) -> str:
    unit = "mm" if found.unit == "mm" else "degrees"
    if name == "toe_shape":
        return f"the outlines of their toes lie {found.right:.1f} mm apart, at most {found.limit} mm are allowed"
    return (
        f"their {name.replace('_', ' ')} is {found.left:.1f} and {found.right:.1f} {unit}, at most {found.limit} "
        f"{unit} apart are allowed"
    )


def with_even_cones(left: Shoelast, right: Shoelast) -> tuple[Shoelast, Shoelast]:
    """Both with the cone of the higher one: nothing is taken away, and what lies 30 mm lower stays."""
    heights = [dimensions(one)["cone_height"].value for one in (left, right)]
    highest = max(heights)
    one, other = (
        with_raised_cone(each, highest - height) if highest - height > CONE_MM else each
        for each, height in zip((left, right), heights, strict=True)
    )
    return one, other


def with_raised_cone(shoelast: Shoelast, rise_mm: float) -> Shoelast:
    """A last whose cone is higher: its top moves up as it is, what lies 30 mm below it or deeper stays.

    Args:
        shoelast: With its points.
        rise_mm: How much, zero or more.
    """
    front, back = shoelast.points["cone_front"], shoelast.points["cone_back"]
    tilt = (front[2] - back[2]) / (front[0] - back[0])
    over = min(_RISING_OVER_MM, float(front[2] - shoelast.points["instep_point"][2]))
    over = max(over, 2.0 * rise_mm)

    def raised(xyz: Floats) -> Floats:
        below = back[2] + tilt * (xyz[..., 0] - back[0]) - xyz[..., 2]
        share = np.clip(1.0 - below / over, 0.0, 1.0)
        rise = rise_mm * share * share * (3.0 - 2.0 * share)
        return xyz + rise[..., None] * np.array([0.0, 0.0, 1.0])

    upper, cone = shoelast.upper, shoelast.cone_top
    remark = f"its cone was raised by {rise_mm:.1f} mm, to that of the other last of the pair"
    return replace(
        with_points_and_lines(
            replace(
                shoelast,
                upper=SplineTube(raised(upper.net_mm), upper.knots_v),
                cone_top=ChordDisc(raised(cone.net_mm), cone.knots_s, cone.knots_t),
            )
        ),
        remarks=(*shoelast.remarks, remark),
    )


def _cone_slope_deg(shoelast: Shoelast) -> float:
    front, back = shoelast.points["cone_front"], shoelast.points["cone_back"]
    return float(np.degrees(np.arctan2(front[2] - back[2], front[0] - back[0])))


def _toes_apart_mm(pair: tuple[Shoelast, Shoelast], measured: tuple[dict[str, Dimension], ...]) -> float:
    widths = [dims["bottom_ball_width"].value for dims in measured]
    toes = [
        _toe_outline_mm(shoelast, _TOE_SHARE * dims["stick_length"].value) * float(np.mean(widths)) / width
        for shoelast, dims, width in zip(pair, measured, widths, strict=True)
    ]
    return float(np.abs(toes[0] - toes[1]).max())


def _toe_outline_mm(shoelast: Shoelast, reach_mm: float) -> Floats:
    """Medial and lateral y `(2, k)` of the feather edge behind the toe's tip, less the middle at the rearmost place."""
    edge = shoelast.upper.grid(np.linspace(0.25, 0.75, 4001), np.array([0.0]))[0]
    tip = int(edge[:, 0].argmax())
    x = edge[tip, 0] - np.linspace(_TIP_MM, reach_mm, _TOE_PLACES)
    sides = [np.interp(x, half[:, 0], half[:, 1]) for half in (edge[: tip + 1], edge[tip:][::-1])]
    return np.stack(sides) - 0.5 * (sides[0][-1] + sides[1][-1])
