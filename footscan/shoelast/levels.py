"""From a design to points of the upper: closed level curves from the feather edge to the cone edge.

Every curve is a cubic spline of x / length, every end an exact square root, and x is spaced by a cosine: the result is
smooth all round. The walls are drawn in towards the feather edge, which is lifted at the shank, and the whole is bent
to its pitch and toe spring, with lengths kept along the bottom.
"""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.shoelast.design import SEAT_SHARE, Design, ridge_height, rounded, run_of

_INSET_FADE_MM = 9.0
_CONE_ENDS = (0.36, 0.80)
"""In front of the first share of the length nothing of the cone's plane is left at the second."""
_BULGE_SHARE = 0.33
"""The back stands out most this far up the cone height."""


@dataclass(frozen=True)
class LevelCurves:
    """Places of the upper: rows are levels, columns go round.

    Attributes:
        xyz_shoelast: `(n_h, n_u, 3)`.
        depth_mm: `(n_u,)` how far the middle of the bottom lies below the straight chord from each feather place.
    """

    xyz_shoelast: Floats
    depth_mm: Floats


def level_heights(design: Design, v: Floats) -> Floats:
    """Levels `(n,)` for parameters 0..1, such that ridge and back are both walked evenly, without a sudden change."""
    x = np.linspace(design.end_mm, 0.25 * design.length_mm, 1500)
    height = ridge_height(design, x)
    keep = height < design.cone_height_mm
    x, height = x[keep], height[keep]
    walked = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(height)) + 1.5 * np.diff(height))])
    coarse = np.linspace(0.0, 1.0, 7)
    share = np.interp(coarse, walked / walked[-1], height / height[-1])
    return design.cone_height_mm * _monotone_cubic(coarse, share, v)


def _monotone_cubic(places: Floats, values: Floats, v: Floats) -> Floats:
    """Bernstein polynomial through control values: smooth everywhere, and monotone as they are."""
    degree = len(places) - 1
    rows = [values]
    level = np.repeat(rows[0][:, None], len(v), axis=1)
    for _ in range(degree):
        level = (1.0 - v) * level[:-1] + v * level[1:]
    return level[0]


def level_curves(design: Design, u: Floats, heights: Floats) -> LevelCurves:
    """Build the upper.

    Args:
        design: What to build.
        u: `(n_u,)` even parameters from 0.
        heights: `(n_h,)` levels, the first one 0 (the feather edge).
    """
    along, medial = 0.5 - 0.5 * np.cos(2.0 * np.pi * u), np.sin(2.0 * np.pi * u) >= 0
    back = _back(design, heights)
    x = back + (_front(design, heights)[:, None] - back) * along
    share = x / design.length_mm
    plan = rounded((design.end_mm - x) / design.toe_length_mm) * rounded((x - back) / design.heel_length_mm)
    half = plan * _section(design, x, heights[:, None])
    half *= np.where(medial, design.medial.at(share), -design.lateral.at(share))
    xy = np.stack([x, design.ridge_y.at(share) + half], axis=-1)
    return _finished(design, u, xy, heights)


def _back(design: Design, heights: Floats) -> Floats:
    """X of the back `(n_h, 1)` at each level: it leans forward above its fullest level, and a little below it."""
    top = heights / design.cone_height_mm
    lean = ((top - _BULGE_SHARE) / (1.0 - _BULGE_SHARE)) ** 2
    return (design.back_lean_mm * lean)[:, None]


def _front(design: Design, heights: Floats) -> Floats:
    """X where the ridge has each height; it falls from the cone to the toe, so it is bisected."""
    low, high = np.full(len(heights), 0.2 * design.length_mm), np.full(len(heights), design.end_mm)
    for _ in range(45):
        middle = 0.5 * (low + high)
        above = ridge_height(design, middle) > heights
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return np.where(heights <= 0.0, design.end_mm, 0.5 * (low + high))


def _section(design: Design, x: Floats, heights: Floats) -> Floats:
    """Share of the half width that a section has at a height."""
    ratio = np.clip(heights / np.maximum(ridge_height(design, x), 1e-9), 0.0, 1.0)
    ratio = np.where(heights <= 0.0, 0.0, ratio)
    return np.sqrt(1.0 - ratio ** design.fullness.at(x / design.length_mm))


def _finished(design: Design, u: Floats, xy: Floats, heights: Floats) -> LevelCurves:
    """Draw in the walls at the feather edge, lift it, and bend the last to its pitch."""
    x, medial = xy[0, :, 0], 0.5 + 0.5 * np.tanh(3.0 * np.sin(2.0 * np.pi * u))
    share, top = x / design.length_mm, heights / design.cone_height_mm
    inset = medial * design.inset_medial.at(share) + (1.0 - medial) * design.inset_lateral.at(share)
    rise = medial * design.rise_medial.at(share) + (1.0 - medial) * design.rise_lateral.at(share)
    fade = np.exp(-heights / _INSET_FADE_MM) * (1.0 - top) ** 2
    drawn = xy - (fade[:, None] * inset)[..., None] * _plan_normal(xy[0])
    z = heights[:, None] + rise * ((1.0 - top) ** 2)[:, None]
    ends = rounded((design.end_mm - x) / design.toe_length_mm) * rounded((x - x[0]) / design.heel_length_mm)
    opposite = np.roll(rise[::-1], 1)
    return LevelCurves(_bent(design, drawn, z, top), 0.5 * (rise + opposite) * ends**2)


def _plan_normal(outline: Floats) -> Floats:
    """Outward unit normals `(n, 2)` of a closed curve at even parameters, by its Fourier series."""
    count = len(outline)
    turns = 2j * np.pi * np.fft.rfftfreq(count, 1.0 / count)
    turns[-1] = 0.0
    tangent = np.fft.irfft(np.fft.rfft(outline, axis=0) * turns[:, None], count, axis=0)
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _bent(design: Design, xy: Floats, z: Floats, top: Floats) -> Floats:
    """Lay x along the lifted bottom and raise z with it; at the cone top, which is flat, with a plane instead."""
    along, forward = run_of(design.lift, design.length_mm)
    share = xy[..., 0] / design.length_mm
    lift, seat = design.lift.at(share), design.lift.at(np.array([SEAT_SHARE]))[0]
    level = seat - design.cone_tilt * design.length_mm * (share - SEAT_SHARE)
    flat = _eased(top, 0.3, 1.0)[:, None] * (1.0 - _eased(share, *_CONE_ENDS))
    return np.stack([np.interp(xy[..., 0], along, forward), xy[..., 1], z + lift + flat * (level - lift)], axis=-1)


def _eased(value: Floats, low: float, high: float) -> Floats:
    """0 below `low`, 1 above `high`, twice differentiable."""
    t = np.clip((value - low) / (high - low), 0.0, 1.0)
    return t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
