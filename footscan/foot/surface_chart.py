"""Where on a foot a point lies: a chart, u round the foot and v from the board up to the leg, unique for every point.

Skin is looked at from a slanted axis that runs from the middle of the foot up into the leg, along cones that rise
outwards. Seen so, a foot with its toes, heel overhang and ankle bones is a graph `reach(azimuth, level)`, where a level
is the height at which a cone leaves the axis; a coarse spline of it gives arc lengths, and these give parameters that
run evenly over the skin. The least squares fit then moves each point's parameters to its foot on the surface, so that
nothing of the chart's perspective is left in the result. Azimuths count from the direction leg -> middle of the foot,
so a turned foot gives the same surface, turned.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d, map_coordinates, median_filter, minimum_filter1d

from footscan.coordinates import Floats
from footscan.foot.nurbs import clamped_knots
from footscan.foot.nurbs_fit import fit_tube

_AZIMUTHS = 240
_LEVELS = 140
_LOWEST_BINS = 120
_COARSE = (44, 26)
_ASSUMED = 1.5  # length of the assumed skin over the height it bridges
_RISE = 0.5  # slope of the cones: level toes and hollow insteps are both met at a fair angle


@dataclass(frozen=True)
class SlantedAxis:
    """The bent line from the middle of the foot into the leg.

    Attributes:
        low_mm: (x, y) at and below `z_low_mm`.
        leg_mm: (x, y) at and above `z_leg_mm`.
        z_low_mm: Height where it starts to lean.
        z_leg_mm: Height where it is upright again.
    """

    low_mm: tuple[float, float]
    leg_mm: tuple[float, float]
    z_low_mm: float
    z_leg_mm: float

    @property
    def heading_rad(self) -> float:
        """Direction from the leg to the middle of the foot, from +x."""
        return float(np.arctan2(self.low_mm[1] - self.leg_mm[1], self.low_mm[0] - self.leg_mm[0]))

    def xy_at(self, z_mm: Floats) -> Floats:
        """`(n, 2)` place of the axis at given heights."""
        t = np.clip((z_mm - self.z_low_mm) / (self.z_leg_mm - self.z_low_mm), 0.0, 1.0)[..., None]
        return np.array(self.low_mm) * (1.0 - t) + np.array(self.leg_mm) * t

    def sight(self, xyz_world: Floats) -> tuple[Floats, Floats, Floats]:
        """Azimuth (rad), level (mm) and reach (horizontal, mm) of `(n, 3)` points."""
        away = xyz_world[:, :2] - self.xy_at(xyz_world[:, 2])
        reach = np.hypot(away[:, 0], away[:, 1])
        azimuth = np.mod(np.arctan2(away[:, 1], away[:, 0]) - self.heading_rad + np.pi, 2.0 * np.pi) - np.pi
        return azimuth, xyz_world[:, 2] - _RISE * reach, reach

    def xyz_from(self, azimuth: Floats, flat_mm: Floats, z_mm: Floats) -> Floats:
        """Points `(..., 3)` at a horizontal distance from the axis."""
        turned = azimuth + self.heading_rad
        xy = self.xy_at(z_mm) + flat_mm[..., None] * np.stack([np.cos(turned), np.sin(turned)], axis=-1)
        return np.concatenate([xy, z_mm[..., None]], axis=-1)


@dataclass(frozen=True)
class FootChart:
    """The map from points to parameters, and the assumed skin below the lowest seen skin.

    Attributes:
        axis: The slanted axis.
        u_table: `(A + 1,)` u at azimuths -pi .. pi, increasing from 0 to 1.
        v_table: `(A, E)` v over azimuth and level.
        level_mm: First and last level of the table.
    """

    axis: SlantedAxis
    u_table: Floats
    v_table: Floats
    level_mm: tuple[float, float]

    def parameters(self, xyz_world: Floats) -> tuple[Floats, Floats]:
        """Parameters u and v `(n,)` of `(n, 3)` points."""
        azimuth, level, _ = self.axis.sight(xyz_world)
        turn = (azimuth + np.pi) * (len(self.v_table) / (2.0 * np.pi))
        low, high = self.level_mm
        rise = (level - low) * ((self.v_table.shape[1] - 1) / (high - low))
        u = np.interp(turn, np.arange(len(self.u_table)), self.u_table)
        closed = np.concatenate([self.v_table, self.v_table[:1]])
        return np.mod(u, 1.0), map_coordinates(closed, np.stack([turn, rise]), order=1, mode="nearest")


def find_axis(xyz_world: Floats, z_cut_mm: float) -> SlantedAxis:
    """The slanted axis of a foot of any heading.

    Args:
        xyz_world: `(n, 3)` points.
        z_cut_mm: Height of the cut through the leg.
    """
    z = xyz_world[:, 2]
    low = xyz_world[z < max(0.35 * z_cut_mm, np.percentile(z, 20))][:, :2]
    leg = xyz_world[(z > 0.85 * z_cut_mm) & (z <= z_cut_mm)][:, :2]
    low_mm, length = box_middle(low)
    leg_mm, _ = box_middle(leg)
    z_leg = min(0.36 * length, 0.9 * z_cut_mm)
    return SlantedAxis(low_mm, leg_mm, min(0.06 * length, 0.3 * z_leg), z_leg)


def box_middle(xy: Floats) -> tuple[tuple[float, float], float]:
    """Middle of the box along the principal axes of `(n, 2)` points, and the longer side of the box."""
    middle, (_, longer) = principal_box(xy)
    return middle, longer


def principal_box(xy: Floats) -> tuple[tuple[float, float], tuple[float, float]]:
    """Middle and (shorter, longer) sides of the box along the principal axes of `(n, 2)` points."""
    centre = xy.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov((xy - centre).T))
    across = (xy - centre) @ axes
    low, high = across.min(axis=0), across.max(axis=0)
    middle = centre + axes @ (0.5 * (low + high))
    sides = np.sort(high - low)
    return (float(middle[0]), float(middle[1])), (float(sides[0]), float(sides[1]))


def build_chart(xyz_world: Floats, weight: Floats, z_cut_mm: float) -> FootChart:
    """Build the chart of a cleaned cloud whose leg is cut at a height."""
    axis = find_axis(xyz_world, z_cut_mm)
    azimuth, level, reach = axis.sight(xyz_world)
    span = (float(level.min()) - 1.0, float(level.max()) + 1.0)
    grid_reach = _coarse_reach(azimuth, level, reach, weight, span)
    lowest = _lowest_level(azimuth, level)
    return _arc_lengths(axis, grid_reach, span, lowest, z_cut_mm)


def _coarse_reach(azimuth: Floats, level: Floats, reach: Floats, weight: Floats, span: tuple[float, float]) -> Floats:
    """Reach `(A, E)` on the table's grid from a coarse stiff spline."""
    count_u, spans = _COARSE
    knots = clamped_knots(np.linspace(0.0, 1.0, spans - 2))
    v = (level - span[0]) / (span[1] - span[0])
    target = np.repeat(reach[:, None], 3, axis=1)
    stiffness = np.full((len(knots) - 4, count_u), 0.002 * len(reach) / (count_u * spans))
    tube = fit_tube(azimuth / (2.0 * np.pi) + 0.5, v, target, weight, count_u, knots, stiffness)
    return tube.grid(np.arange(_AZIMUTHS) / _AZIMUTHS, np.linspace(0.0, 1.0, _LEVELS))[:, :, 0].T


def _lowest_level(azimuth: Floats, level: Floats) -> Floats:
    """Level `(A,)` of the lowest seen skin, smoothed around the foot."""
    which = np.floor((azimuth + np.pi) * (_LOWEST_BINS / (2.0 * np.pi))).astype(np.int64) % _LOWEST_BINS
    order = np.lexsort((level, which))
    starts = np.searchsorted(which[order], np.arange(_LOWEST_BINS + 1))
    counts = np.diff(starts)
    third = order[np.minimum(starts[:-1] + 2, len(order) - 1)]
    found = np.flatnonzero(counts >= 5)
    lowest = np.interp(np.arange(_LOWEST_BINS), found, level[third[found]], period=_LOWEST_BINS)
    lowest = minimum_filter1d(median_filter(lowest, 3, mode="wrap"), 3, mode="wrap")
    lowest = gaussian_filter1d(lowest, 1.5, mode="wrap")
    centres = (np.arange(_LOWEST_BINS) + 0.5) / _LOWEST_BINS
    return np.interp(np.arange(_AZIMUTHS) / _AZIMUTHS, centres, lowest, period=1.0)


def _arc_lengths(
    axis: SlantedAxis, reach: Floats, span: tuple[float, float], lowest: Floats, z_cut_mm: float
) -> FootChart:
    """Turn the coarse shape into parameters that follow arc length, column by column."""
    azimuth = -np.pi + 2.0 * np.pi * np.arange(_AZIMUTHS) / _AZIMUTHS
    level = np.linspace(*span, _LEVELS)
    flat, z = reach, level + _RISE * reach
    place = axis.xyz_from(azimuth[:, None], flat, z)
    length = np.concatenate(
        [np.zeros((_AZIMUTHS, 1)), np.cumsum(np.linalg.norm(np.diff(place, axis=1), axis=2), axis=1)], axis=1
    )
    column = np.arange(_AZIMUTHS)
    start = np.array([np.interp(lowest[k], level, length[k]) for k in column])
    top = np.array([_length_at_height(z[k], length[k], z_cut_mm) for k in column])
    bottom = _ASSUMED * np.maximum([np.interp(lowest[k], level, z[k]) for k in column], 1.0)
    v_table = (length + (bottom - start)[:, None]) / np.maximum(top - start + bottom, 1.0)[:, None]
    return FootChart(axis, _around(place, v_table), np.clip(v_table, 0.0, 1.2), span)


def _length_at_height(z: Floats, length: Floats, z_cut_mm: float) -> float:
    """Arc length at which a column passes the cut for the last time."""
    above = np.flatnonzero(z < z_cut_mm)
    k = min(int(above[-1]) if len(above) else 0, len(z) - 2)
    share = (z_cut_mm - z[k]) / max(z[k + 1] - z[k], 1e-6)
    return float(length[k] + min(share, 3.0) * (length[k + 1] - length[k]))


def _around(place: Floats, v_table: Floats) -> Floats:
    """Table of u `(A + 1,)`: the mean arc length around the lower two thirds of the skin, scaled to 0..1."""
    step = np.linalg.norm(np.roll(place, -1, axis=0) - place, axis=2)
    lower = (v_table > 0.02) & (v_table < 0.65)
    mean = np.sqrt((step**2 * lower).sum(axis=1) / np.maximum(lower.sum(axis=1), 1))
    mean = gaussian_filter1d(mean, 3.0, mode="wrap")
    return np.concatenate([[0.0], np.cumsum(mean)]) / mean.sum()
