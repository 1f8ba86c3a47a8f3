"""Two clouds of one foot: how far apart their points are, frame by frame, and how far apart their skins."""

import numpy as np

from footscan.coordinates import Bools, Floats
from footscan.geometry.nearest import PointTree
from footscan.scanning.cloud import Cloud

HEIGHTS_MM = (3.0, 95.0)
"""Above the board: where clouds are compared."""
_NEIGHBOURS = 12
_REACH_MM = 5.0
_FRAME_APART_MM = 1000.0
_SAME_POINT_MM = 0.5


def points_apart(one: Cloud, other: Cloud) -> tuple[float, float]:
    """RMS distance (mm) of points of the same frame, and the share of the first cloud's points that have a partner."""
    distance, _ = PointTree(_by_frame(other)).nearest(_by_frame(one), 1, _SAME_POINT_MM)
    paired = distance[np.isfinite(distance)]
    return rms(paired), len(paired) / max(len(one), 1)


def skins_apart(one: Cloud, other: Cloud) -> float:
    """RMS distance (mm) of the middles of 12 neighbours of one cloud to the planes through 12 of the other.

    The noise of single points is mostly gone in such middles; what two scans do to the skin is not.
    """
    middles, _, whole = _patches(one.xyz_world, one.xyz_world[::3])
    z = middles[:, 2]
    middles = middles[whole & (z > HEIGHTS_MM[0]) & (z < HEIGHTS_MM[1])]
    others, normals, whole = _patches(other.xyz_world, middles)
    return rms(np.sum((middles - others) * normals, axis=1)[whole])


def rms(values: Floats) -> float:
    """Root of the mean square; NaN of nothing."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")


def _by_frame(cloud: Cloud) -> Floats:
    """`(n, 4)`: points of different frames are far apart."""
    frame: Floats = _FRAME_APART_MM * cloud.frame.astype(np.float64)
    return np.concatenate([cloud.xyz_world, frame[:, None]], axis=1)


def _patches(xyz: Floats, queries: Floats) -> tuple[Floats, Floats, Bools]:
    """Middles `(m, 3)` and normals `(m, 3)` of the points around some places, and where 12 of them are near."""
    distance, index = PointTree(xyz).nearest(queries, _NEIGHBOURS, _REACH_MM)
    whole: Bools = np.asarray(np.all(np.isfinite(distance), axis=1))
    near: Floats = xyz[np.where(np.isfinite(distance), index, 0)]
    middle: Floats = near.mean(axis=1)
    centred = near - middle[:, None]
    normal: Floats = np.linalg.eigh(np.swapaxes(centred, 1, 2) @ centred)[1][:, :, 0]
    return middle, normal, whole
