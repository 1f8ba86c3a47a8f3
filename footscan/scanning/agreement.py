"""The two lasers against each other: where both saw the skin, how far apart they put it, and how they are merged."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats, Ints
from footscan.geometry.nearest import PointTree
from footscan.scanning.cloud import Cloud
from footscan.scanning.zones import ZONES, direction_from_core, zone_of_points

_REACH_MM = 4.0
_MERGE_REACH_MM = 3.0
_SPREAD_MM2 = 0.5  # neighbours of a single stripe do not fix a plane
_BESIDE_MM = 1.5
_EVERY = 2
_NEIGHBOURS = 24
_FEWEST = 6
_FLAT_MM = 0.5
_FEWEST_PER_ZONE = 50


@dataclass(frozen=True)
class ZoneAgreement:
    """Signed distance right minus left along the outward normal in one zone, and the area it was measured on."""

    zone: str
    points: int
    overlap_area_mm2: float
    median_mm: float | None
    rms_mm: float | None
    p95_mm: float | None


@dataclass(frozen=True)
class Overlap:
    """Points where the other laser's skin lies beside, right minus left along the outward normal, and their area."""

    index: Ints
    distance_mm: Floats
    area_mm2: Floats


def find_overlap(cloud: Cloud) -> Overlap:
    """Distances of each laser's points to the plane of the other's neighbours (within 4 mm, flat to 0.5 mm).

    Both directions are taken: on a convex skin a point lies above the plane of its neighbours whichever laser it
    belongs to, which cancels in the mean of right minus left.
    """
    right, left = np.flatnonzero(cloud.laser == 0), np.flatnonzero(cloud.laser == 1)
    if len(right) < _NEIGHBOURS or len(left) < _NEIGHBOURS:
        return Overlap(np.empty(0, np.int64), np.empty(0), np.empty(0))
    from_core = direction_from_core(cloud.xyz_world)
    one, two = (_beside(cloud.xyz_world, from_core, *pair) for pair in ((right, left), (left, right)))
    distance = np.concatenate([one.distance_mm, -two.distance_mm])
    # every point was used from its own side: an area seen by both is counted by each, hence the half
    area = 0.5 * np.concatenate([one.area_mm2, two.area_mm2])
    return Overlap(np.concatenate([one.index, two.index]), distance, area)


def _beside(xyz_world: Floats, from_core: Floats, own: Ints, other: Ints) -> Overlap:
    used = own[::_EVERY]
    xyz, xyz_other = xyz_world[used], xyz_world[other]
    reach, index = PointTree(xyz_other).nearest(xyz, _NEIGHBOURS, _REACH_MM)
    found = np.isfinite(reach)
    some = found.sum(axis=1) >= _FEWEST
    near = xyz_other[np.where(found[some], index[some], 0)]
    distance_mm, good = _plane_distance(xyz[some], near, found[some], from_core[used[some]])
    own_reach = PointTree(xyz_world[own]).nearest(xyz[some][good], 9)[0][:, -1]
    return Overlap(used[some][good], distance_mm[good], _EVERY * np.pi * own_reach**2 / 8.0)


def _plane_distance(xyz: Floats, near: Floats, found: Bools, from_core: Floats) -> tuple[Floats, Bools]:
    """Signed distances `(n,)` to the planes of `(n, k, 3)` neighbours, outward positive, and which can be trusted:
    neighbours that are flat, spread both ways, and surround the point."""
    share = found / found.sum(axis=1, keepdims=True)
    centre = np.einsum("nk,nkd->nd", share, near)
    offset = (near - centre[:, None]) * found[..., None]
    covariance = np.einsum("nk,nkd,nke->nde", share, offset, offset)
    spread, axes = np.linalg.eigh(covariance)
    normal = axes[:, :, 0]
    outward = np.sign(np.sum(normal * from_core, axis=1) + 1e-12)
    height = np.sum((xyz - centre) * normal, axis=1)
    beside = np.linalg.norm(xyz - centre - height[:, None] * normal, axis=1)
    good = (spread[:, 0] < _FLAT_MM**2) & (spread[:, 1] > _SPREAD_MM2) & (beside < _BESIDE_MM)
    return height * outward, good


def agreement_by_zone(cloud: Cloud, overlap: Overlap) -> list[ZoneAgreement]:
    """The disagreement of the two lasers per zone; a zone with too little overlap says so by `None`."""
    zone = zone_of_points(cloud.xyz_world)[overlap.index] if len(overlap.index) else np.empty(0, np.int64)
    return [_zone(name, overlap, zone == code) for code, name in enumerate(ZONES)]


def _zone(name: str, overlap: Overlap, own: Bools) -> ZoneAgreement:
    distance, area = overlap.distance_mm[own], float(overlap.area_mm2[own].sum())
    if len(distance) < _FEWEST_PER_ZONE:
        return ZoneAgreement(name, len(distance), area, None, None, None)
    rms, p95 = float(np.sqrt(np.mean(distance**2))), float(np.percentile(np.abs(distance), 95))
    return ZoneAgreement(name, len(distance), area, float(np.median(distance)), rms, p95)


def merge_lasers(cloud: Cloud) -> Cloud:
    """Share the weight where both lasers see the same skin: the better-lit one counts more.

    A point's weight is multiplied by own / (own + other), the mean weights of its own and of the other laser's points
    within 3 mm; where the other laser saw nothing the weight stays.
    """
    weight = cloud.weight.astype(np.float64)
    trees = [np.flatnonzero(cloud.laser == code) for code in (0, 1)]
    if min(len(part) for part in trees) == 0:
        return cloud
    mean = np.zeros((2, len(cloud)))
    for code, part in enumerate(trees):
        reach, index = PointTree(cloud.xyz_world[part]).nearest(cloud.xyz_world, 4, _MERGE_REACH_MM)
        near = np.isfinite(reach)
        held = np.append(weight[part], 0.0)[np.where(near, index, len(part))]
        mean[code] = held.sum(axis=1) / np.maximum(near.sum(axis=1), 1)
    own = np.where(cloud.laser == 0, mean[0], mean[1])
    other = np.where(cloud.laser == 0, mean[1], mean[0])
    return cloud.with_weight((weight * own / np.maximum(own + other, 1e-9)).astype(np.float32))
