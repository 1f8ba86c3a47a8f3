"""Sectors around the axis in which no skin was seen, and the measurements that lie in them."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats
from footscan.foot.catalogue import CATALOGUE, Entry
from footscan.scanning.matrix import ScanMatrix
from footscan.workflow.foot import MeasuredFoot

_LEAST_STEPS = 3.0  # stripes are some degrees apart: a gap of a few is none
_OUTLINE = 0.16  # share of the length: skin below shows what of the outline lies in a sector
_BESIDE = 0.02  # of the length
_PLACES: dict[str, tuple[float, float]] = {
    "waist_girth": (0.52, 0.64),
    "instep_girth": (0.48, 0.52),
    "midfoot_breadth": (0.49, 0.51),
    "heel_breadth": (0.15, 0.17),
    "toe_height": (0.88, 0.92),
}
"""Measurements that go across the foot somewhere else than at their landmarks: shares of the length."""
_ALL_ROUND = ("ankle_girth", "overall_length", "overall_breadth", "volume", "surface_area")


@dataclass(frozen=True)
class Sector:
    """From one angle about the axis counter-clockwise to another, rad; the end may exceed a full turn."""

    begin_rad: float
    end_rad: float

    @property
    def width_rad(self) -> float:
        """How wide."""
        return self.end_rad - self.begin_rad

    def holds(self, xyz_world: Floats) -> Bools:
        """Which of `(n, 3)` points lie in it."""
        azimuth = np.arctan2(xyz_world[:, 1], xyz_world[:, 0])
        return np.mod(azimuth - self.begin_rad, 2.0 * np.pi) < self.width_rad


def blocked_sectors(xyz_world: Floats, step_rad: float, narrowest_rad: float) -> list[Sector]:
    """Gaps in the directions from the axis to the `(n, 3)` points of a foot that stands over it, widest first.

    Args:
        xyz_world: The cloud.
        step_rad: Usual angle between two stripes of one laser; a gap must be wider than three of them.
        narrowest_rad: Smaller gaps are none.
    """
    azimuth = np.sort(np.arctan2(xyz_world[:, 1], xyz_world[:, 0]))
    gap = np.diff(np.append(azimuth, azimuth[0] + 2.0 * np.pi))
    wide = np.flatnonzero(gap > max(narrowest_rad, _LEAST_STEPS * step_rad))
    sectors = [Sector(float(azimuth[i]), float(azimuth[i] + gap[i])) for i in wide]
    return sorted(sectors, key=lambda sector: -sector.width_rad)


def usual_step_rad(matrix: ScanMatrix) -> float:
    """Usual angle between neighbouring stripes of the laser that has fewer of them."""
    steps = [np.diff(np.sort(matrix.theta_rad[matrix.laser == code])) for code in np.unique(matrix.laser)]
    return max((float(np.median(step)) for step in steps if len(step)), default=0.0)


def spoiled_measurements(foot: MeasuredFoot, sectors: list[Sector]) -> tuple[str, ...]:
    """Names of the measurements of which a landmark, or a part of the way around the foot, lies in a sector."""
    vertices = np.asarray(foot.mesh.vertices, dtype=np.float64)
    transform = foot.measurements.foot_from_input
    along = vertices @ transform[0, :3] + transform[0, 3]
    length = foot.measurements["foot_length"].value or float(np.ptp(along))
    low = vertices[:, 2] < _OUTLINE * length
    ranges: list[tuple[float, float]] = []
    for sector in sectors:
        inside = along[low & sector.holds(vertices)] / length
        if len(inside):
            ranges.append((float(inside.min()) - _BESIDE, float(inside.max()) + _BESIDE))
    return tuple(entry.name for entry in CATALOGUE if _is_spoiled(entry, foot, sectors, ranges))


def _is_spoiled(entry: Entry, foot: MeasuredFoot, sectors: list[Sector], ranges: list[tuple[float, float]]) -> bool:
    if foot.measurements[entry.name].value is None:
        return False
    if entry.name in _ALL_ROUND:
        return True
    low, high = _PLACES.get(entry.name, (np.inf, -np.inf))
    if any(begin <= high and low <= end for begin, end in ranges):
        return True
    marks = foot.measurements.landmarks
    places = np.array([marks[name].xyz for name in entry.needs if name in marks]).reshape(-1, 3)
    return any(bool(sector.holds(places).any()) for sector in sectors)
