"""Two clouds of one foot: how far apart their points are, and how far apart the skins they show."""

import numpy as np

from footscan.coordinates import Floats
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.geometry.nearest import PointTree
from footscan.scanning.cloud import Cloud
from footscan.sim.surface import Surface

HEIGHTS_MM = (3.0, 95.0)
"""Above the board: where clouds are compared."""
_NEIGHBOURS = 12
_REACH_MM = 5.0


def rms_apart(one: Cloud, other: Cloud) -> float:
    """RMS distance (mm) of the same points in two clouds of the same pictures."""
    return rms(np.linalg.norm(one.xyz_world - other.xyz_world, axis=1))


def clouds_apart(one: Cloud, other: Cloud, skin: Surface) -> float:
    """RMS difference (mm) of how far two clouds lie off the skin they are of, each as the mean of 12 neighbours.

    The noise of single points is mostly gone in such means, and where the stripes happened to fall does not matter;
    what two scans do to the skin is left.
    """
    tree = DistanceMesh(skin.xyz_world, skin.faces)
    z = one.xyz_world[:, 2]
    places = one.xyz_world[(z > HEIGHTS_MM[0]) & (z < HEIGHTS_MM[1])][::3]
    first, second = (_mean_off_mm(cloud, tree, places) for cloud in (one, other))
    known = np.isfinite(first) & np.isfinite(second)
    return rms((first - second)[known])


def rms(values: Floats) -> float:
    """Root of the mean square; NaN of nothing."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")


def _mean_off_mm(cloud: Cloud, tree: DistanceMesh, places: Floats) -> Floats:
    """Mean signed distance `(m,)` off the skin of the 12 points around each place; NaN where fewer are near."""
    off_mm = tree.nearest(cloud.xyz_world).signed
    distance, index = PointTree(cloud.xyz_world).nearest(places, _NEIGHBOURS, _REACH_MM)
    whole = np.all(np.isfinite(distance), axis=1)
    mean: Floats = off_mm[np.where(whole[:, None], index, 0)].mean(axis=1)
    return np.where(whole, mean, np.nan)
