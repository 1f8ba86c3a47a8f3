"""Zones of the foot for statements about parts of a scan: toes, ball, midfoot, heel, ankle.

Only a rough foot axis is needed here; landmarks have their own, exact one. The leg stands over the heel, so the end of
the foot that the higher points lie nearer to is the heel.
"""

import numpy as np

from footscan.coordinates import Floats, Ints

ZONES = ("heel", "midfoot", "ball", "toes", "ankle")
_LOW_MM, _HIGH_MM = 45.0, 60.0
_BOUNDS = (0.30, 0.60, 0.80)  # shares of the length: heel | midfoot | ball | toes
_ANKLE_MM = 70.0


def zone_of_points(xyz_world: Floats) -> Ints:
    """Index into `ZONES` for `(n, 3)` points of a foot standing on z = 0."""
    height = xyz_world[:, 2]
    low = xyz_world[height < _LOW_MM] if (height < _LOW_MM).sum() > 10 else xyz_world
    centre = low[:, :2].mean(axis=0)
    axis = np.linalg.svd(low[:, :2] - centre, full_matrices=False)[2][0]
    along = (xyz_world[:, :2] - centre) @ axis
    begin, end = (float(x) for x in np.quantile(along[height < _LOW_MM] if len(low) < len(along) else along, (0, 1)))
    high = along[height > _HIGH_MM]
    heel_first = len(high) == 0 or abs(float(high.mean()) - begin) < abs(float(high.mean()) - end)
    share = (along - begin) / max(end - begin, 1e-9)
    share = share if heel_first else 1.0 - share
    zone = np.searchsorted(_BOUNDS, share)
    return np.where((height > _ANKLE_MM) & (share < 0.5), ZONES.index("ankle"), zone)
