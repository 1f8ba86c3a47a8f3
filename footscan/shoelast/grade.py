"""Grading: the same last in another size or width, its pitch and toe spring kept.

Along the bottom everything is stretched by Paris points; across and in height, measured from the middle of the bottom,
by two factors (ball and instep) that are solved so that these girths change by the trade's steps.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from footscan.coordinates import Floats
from footscan.errors import InputError, QualityError
from footscan.foot.nurbs import SplineTube
from footscan.shoelast.design import Curve
from footscan.shoelast.dimensions import girths_mm, with_points_and_lines
from footscan.shoelast.family_data import GIRTHS, family_data
from footscan.shoelast.landmarks import MARK_SAMPLING, body_of, find_points
from footscan.shoelast.model import Shoelast
from footscan.shoelast.patches import ChordDisc
from footscan.shoelast.pose import settled

TOLERANCE_MM = 0.05
_MOST_SIZES, _MOST_WIDTHS = 4.0, 4.0
_ROUNDS = 8
_PLACES = np.array([0.0, 0.16, 0.474, 0.66, 0.77, 1.0])
"""Shares of the length: from the second to the third the instep's factor holds, between the next two the ball's."""


def grade(shoelast: Shoelast, size_eu: float | None = None, widths: float = 0.0) -> Shoelast:
    """A last in another size or width.

    Args:
        shoelast: Of known size when `size_eu` is given.
        size_eu: Paris points wanted; None keeps the length.
        widths: Width fittings up (positive) or down.

    Raises:
        InputError: The size is not known, or the step is too large to be a grade.
        QualityError: The girths were not reached.
    """
    sizes = _sizes(shoelast, size_eu)
    if not abs(sizes) + abs(widths) > 0.0:
        raise InputError(f"{shoelast.name} is EU {shoelast.size_eu:g} already; name another size or --widths.")
    if abs(sizes) > _MOST_SIZES or abs(widths) > _MOST_WIDTHS:
        raise InputError(
            f"{sizes:+g} sizes and {widths:+g} widths are no grade: at most {_MOST_SIZES:g} of each; start from a "
            "nearer last (`footscan lasts list`)."
        )
    graded = _solved(shoelast, sizes, widths)
    name = _name(shoelast, size_eu, widths)
    remark = f"graded from {shoelast.name} by {sizes:+g} sizes and {widths:+g} widths"
    fitting = shoelast.fitting if widths == 0 else f"{shoelast.fitting}{widths:+g}"
    return replace(
        with_points_and_lines(graded),
        name=name,
        size_eu=size_eu if size_eu is not None else shoelast.size_eu,
        fitting=fitting,
        attachments=(),
        remarks=(*shoelast.remarks, remark),
    )


def _sizes(shoelast: Shoelast, size_eu: float | None) -> float:
    if size_eu is None:
        return 0.0
    if shoelast.size_eu is None:
        raise InputError(f"the size of {shoelast.name} is not known; add it again with --size, or grade by --widths.")
    return size_eu - shoelast.size_eu


def _name(shoelast: Shoelast, size_eu: float | None, widths: float) -> str:
    size = "" if size_eu is None else f" eu{size_eu:g}"
    width = "" if widths == 0 else f" {widths:+g} widths"
    return f"{shoelast.name} graded{size}{width}"


def _solved(shoelast: Shoelast, sizes: float, widths: float) -> Shoelast:
    """Newton steps on both factors with a plain slope: a girth grows as its factor does."""
    before, stick = _values(shoelast)
    steps = family_data()["grading"]
    wanted = before + np.array(
        [sizes * steps["per_size_mm"][name] + widths * steps["per_fitting_mm"][name] for name in GIRTHS]
    )
    along = 1.0 + sizes * family_data()["paris_point_mm"] / stick
    factors, miss = wanted / before, np.inf
    for _ in range(_ROUNDS):
        graded = settled(_stretched(shoelast, along, factors))
        found, _ = _values(graded)
        miss = float(np.abs(found - wanted).max())
        if miss < TOLERANCE_MM:
            return graded
        factors = factors * wanted / found
    raise QualityError(
        f"{shoelast.name}: graded girths miss by {miss:.2f} mm, at most {TOLERANCE_MM} mm; grade in smaller steps."
    )


def _values(shoelast: Shoelast) -> tuple[Floats, float]:
    body = body_of(shoelast, MARK_SAMPLING)
    found = girths_mm(body, find_points(body))
    return np.array([found[name] for name in GIRTHS]), body.stick_mm


def _stretched(shoelast: Shoelast, along: float, factors: Floats) -> Shoelast:
    """Stretch the control nets of all patches; the middle of the bottom only moves along."""
    line = body_of(shoelast).centre_line
    ball, instep = (float(value) for value in factors)
    across = Curve(_PLACES, np.array([1.0, 0.5 + 0.5 * instep, instep, ball, ball, 0.3 + 0.7 * ball]))
    bottom = _height_of_bottom(line)
    begin, length = float(line[0, 0]), float(np.ptp(line[:, 0]))

    def stretch(xyz: Floats) -> Floats:
        factor, floor = across.at((xyz[..., 0] - begin) / length), bottom(xyz[..., 0])
        z = floor + factor * (xyz[..., 2] - floor)
        return np.stack([along * xyz[..., 0], factor * xyz[..., 1], z], axis=-1)

    return _mapped(shoelast, stretch)


def _height_of_bottom(line: Floats) -> Callable[[Floats], Floats]:
    """Height of the bottom's middle over x, straight on beyond its ends."""
    thin = line[:: max(len(line) // 24, 1)]
    keep = np.concatenate([[True], np.diff(thin[:, 0]) > 1e-6])
    spline = CubicSpline(thin[keep, 0], thin[keep, 2])
    low, high = thin[keep, 0][[0, -1]]
    return lambda x: spline(np.clip(x, low, high))


def _mapped(shoelast: Shoelast, function: Callable[[Floats], Floats]) -> Shoelast:
    upper, bottom, cone = shoelast.upper, shoelast.bottom, shoelast.cone_top
    return replace(
        shoelast,
        upper=SplineTube(function(upper.net_mm), upper.knots_v),
        bottom=ChordDisc(function(bottom.net_mm), bottom.knots_s, bottom.knots_t),
        cone_top=ChordDisc(function(cone.net_mm), cone.knots_s, cone.knots_t),
        attachments=(),
    )


def mirror(shoelast: Shoelast) -> Shoelast:
    """The last of the other foot: the same in memory, as y is medial for both."""
    other = "left" if shoelast.side == "right" else "right"
    name = shoelast.name.removesuffix("-left").removesuffix("-right")
    return replace(
        shoelast, side=other, name=f"{name}-{other}", remarks=(*shoelast.remarks, f"mirrored from {shoelast.name}")
    )
