"""The shadow inside the sheet: what the laser's fan of rays meets first, kept per slope of the ray."""

import numpy as np

from footscan.compiled import compiled, compiled_inline
from footscan.coordinates import Floats

STEEPEST = 1.2
"""Slope |dy / dx| of the steepest ray of the fan; the foot needs 0.6."""
SLOPES = 32768
"""Rays kept: 0.04 mm apart at the axis."""
NEARER_MM = 0.3
"""A piece this much nearer to the laser casts a shadow; less is the same surface."""


@compiled
def find_nearest(pieces: Floats, begin: int, end: int, laser_x: float, laser_y: float, nearest: Floats) -> None:
    """Write 1 / distance along x_L of the first thing each ray meets into `nearest` `(SLOPES,)`; 0 is nothing.

    Along a straight piece, 1 / distance is linear in the slope of the ray.
    """
    nearest[:] = 0.0
    per_slope = SLOPES / (2.0 * STEEPEST)
    for i in range(begin, end):
        x0, x1 = pieces[i, 0] - laser_x, pieces[i, 2] - laser_x
        if x0 < 1.0 or x1 < 1.0:
            continue
        inverse0, inverse1 = 1.0 / x0, 1.0 / x1
        ray0 = ((pieces[i, 1] - laser_y) * inverse0 + STEEPEST) * per_slope
        ray1 = ((pieces[i, 3] - laser_y) * inverse1 + STEEPEST) * per_slope
        if ray0 > ray1:
            ray0, ray1, inverse0, inverse1 = ray1, ray0, inverse1, inverse0
        first, last = max(int(np.ceil(ray0)), 0), min(int(np.floor(ray1)), SLOPES - 1)
        growth = (inverse1 - inverse0) / max(ray1 - ray0, 1e-9)
        for ray in range(first, last + 1):
            nearest[ray] = max(nearest[ray], inverse0 + growth * (ray - ray0))


@compiled_inline
def is_lit(x: float, y: float, laser_x: float, laser_y: float, nearest: Floats) -> bool:
    """Whether the ray of the laser reaches the place (x, y) of its sheet."""
    distance = x - laser_x
    if distance < 1.0:
        return False
    place = ((y - laser_y) / distance + STEEPEST) * (SLOPES / (2.0 * STEEPEST))
    ray = int(np.floor(place))
    if ray < 0 or ray + 1 >= SLOPES:
        return False
    first_met = min(nearest[ray], nearest[ray + 1])
    return first_met * (distance - NEARER_MM) <= 1.0
