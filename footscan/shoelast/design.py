"""A built-in last thought flat: its curves along the bottom, from which `levels.py` builds the upper.

x runs along the bottom, h is the height above the feather edge. At a level h the outline runs from the back to the
place where the ridge has that height, so the outlines of all levels are the upper's parameter lines. Their half widths
are sections with rounded tops:

    y(x, h) = ridge_y(x) +- width(x) (1 - (h / ridge(x))^fullness(x))^(1/2)   times the rounded heel and toe
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from footscan.coordinates import Floats

SEAT_SHARE = 0.16
"""Where along a last the seat's height and the heel's width are taken (a foot's heel breadth is at 16 % too)."""
TREAD_SHARE = 0.65
"""Where the design's bottom touches the ground."""


@dataclass(frozen=True)
class Curve:
    """A cubic spline over shares of the length, level at both ends and beyond; `shares` and `values` are `(k,)`."""

    shares: Floats
    values: Floats

    def at(self, share: Floats) -> Floats:
        """Values at any shares."""
        return self._spline(np.clip(share, self.shares[0], self.shares[-1]))

    @cached_property
    def _spline(self) -> CubicSpline:
        return CubicSpline(self.shares, self.values, bc_type="clamped")

    def times(self, factor: "Curve | float") -> "Curve":
        """The curve multiplied, at its own shares."""
        by = factor.at(self.shares) if isinstance(factor, Curve) else factor
        return Curve(self.shares, self.values * by)


@dataclass(frozen=True)
class Design:
    """A last thought flat. Lengths in mm; curves over x / length_mm, which may go beyond 1.

    Attributes:
        length_mm: Along the bottom from the back to where a plain toe ends.
        end_mm: Where this toe ends.
        medial: Half width from the ridge line, the ends not yet rounded.
        lateral: The same to the other side.
        ridge: Height of the dorsum above the feather edge; behind the cone's front it goes on above the cone top.
        ridge_y: Where the ridge runs, medial positive.
        fullness: Exponent of the sections: 1.5 a roof, 3 a box.
        toe_length_mm: Over which the outline is rounded at the toe.
        toe_depth_mm: Over which the ridge is rounded at the toe.
        heel_length_mm: Over which the outline is rounded at the heel.
        cone_height_mm: Level of the cone top.
        back_lean_mm: How far the back leans forward at the cone top.
        inset_medial: How far the feather edge lies inside the wall above it.
        inset_lateral: The same on the other side.
        rise_medial: How far the feather edge lies above the middle of the bottom.
        rise_lateral: The same on the other side.
        lift: Height of the bottom's middle above the ground: pitch, shank and toe spring.
        cone_tilt: Slope of the cone top, down towards the toe.
    """

    length_mm: float
    end_mm: float
    medial: Curve
    lateral: Curve
    ridge: Curve
    ridge_y: Curve
    fullness: Curve
    toe_length_mm: float
    toe_depth_mm: float
    heel_length_mm: float
    cone_height_mm: float
    back_lean_mm: float
    inset_medial: Curve
    inset_lateral: Curve
    rise_medial: Curve
    rise_lateral: Curve
    lift: Curve
    cone_tilt: float


def rounded(t: Floats) -> Floats:
    """An end's profile: 0 at t = 0 with a square root, 1 from t = 1 on, twice differentiable there."""
    return np.sqrt(1.0 - (1.0 - np.clip(t, 0.0, 1.0)) ** 3)


def ridge_height(design: Design, x: Floats) -> Floats:
    """Height of the dorsum above the feather edge `(n,)` at x `(n,)`, the toe rounded."""
    return design.ridge.at(x / design.length_mm) * rounded((design.end_mm - x) / design.toe_depth_mm)


def run_of(lift: Curve, length_mm: float) -> tuple[Floats, Floats]:
    """Level distance from the back for places along a lifted bottom.

    Returns:
        `(n,)` places along the bottom and `(n,)` how far forward they lie; both 0 at the back.
    """
    along = np.linspace(-0.1, 1.1, 1201) * length_mm
    slope = np.clip(np.gradient(lift.at(along / length_mm), along), -0.95, 0.95)
    pace = np.sqrt(1.0 - slope**2)
    forward = np.concatenate([[0.0], np.cumsum(0.5 * (pace[1:] + pace[:-1]) * np.diff(along))])
    return along, forward - np.interp(0.0, along, forward)
