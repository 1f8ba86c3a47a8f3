"""Zones of the foot for statements about parts of a scan: toes, ball, midfoot, heel, ankle.

Only a rough foot axis is needed here; landmarks have their own, exact one. The leg stands over the heel, so the end of
the foot that the higher points lie nearer to is the heel. Heights are shares of the foot's length, so that a child's
ankle is an ankle too.
"""

import numpy as np

from footscan.coordinates import Floats, Ints

ZONES = ("heel", "midfoot", "ball", "toes", "ankle")
_LOW, _HIGH = 0.18, 0.24
_BOUNDS = (0.30, 0.60, 0.80)  # shares of the length: heel | midfoot | ball | toes
_ANKLE = 0.27
_CORE_SHARE = 0.6  # the core line is this share of the foot's length, so that heel and toes have an outside too
_CORE_DEPTH = 0.12


def zone_of_points(xyz_world: Floats) -> Ints:
    """Index into `ZONES` for `(n, 3)` points of a foot standing on z = 0."""
    height = xyz_world[:, 2]
    low = _low_points(xyz_world)
    centre, axis = _long_axis(low)
    along = (xyz_world[:, :2] - centre) @ axis
    along_low = (low[:, :2] - centre) @ axis
    begin, end = float(along_low.min()), float(along_low.max())
    size_mm = _size_mm(xyz_world)
    high = along[height > _HIGH * size_mm]
    heel_first = len(high) == 0 or abs(float(high.mean()) - begin) < abs(float(high.mean()) - end)
    share = (along - begin) / max(end - begin, 1e-9)
    share = share if heel_first else 1.0 - share
    zone = np.searchsorted(_BOUNDS, share)
    return np.where((height > _ANKLE * size_mm) & (share < 0.5), ZONES.index("ankle"), zone)


def direction_from_core(xyz_world: Floats) -> Floats:
    """Directions `(n, 3)`, not normalised, that point out of the foot at each of its points.

    They start on a line inside the foot: below the point, on the middle part of the foot's long axis.
    """
    low = _low_points(xyz_world)
    centre, axis = _long_axis(low)
    along_low = (low[:, :2] - centre) @ axis
    middle, half = 0.5 * (along_low.min() + along_low.max()), 0.5 * _CORE_SHARE * np.ptp(along_low)
    along = np.clip((xyz_world[:, :2] - centre) @ axis, middle - half, middle + half)
    core = centre + along[:, None] * axis
    depth = np.maximum(xyz_world[:, 2] - _CORE_DEPTH * _size_mm(xyz_world), 0.0)
    return xyz_world - np.column_stack([core, depth])


def _low_points(xyz_world: Floats) -> Floats:
    low = xyz_world[:, 2] < _LOW * _size_mm(xyz_world)
    return xyz_world[low] if low.sum() > 10 else xyz_world


def _size_mm(xyz_world: Floats) -> float:
    """About the foot's length, whatever its heading: a foot is about 0.4 as wide as long, which hides a turn by 45
    degrees to a few per cent."""
    return float(np.ptp(xyz_world[:, :2], axis=0).max())


def _long_axis(xyz_world: Floats) -> tuple[Floats, Floats]:
    """Middle and direction `(2,)` of the longest extent seen from above."""
    centre = xyz_world[:, :2].mean(axis=0)
    return centre, np.linalg.eigh(np.cov((xyz_world[:, :2] - centre).T))[1][:, -1]
