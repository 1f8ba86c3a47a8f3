"""Which skin was seen: decided from the measured points alone, by closing gaps as wide as the stripes lie apart.

A place counts as covered when a measured point lies within a radius; the covered region is then shrunk by most of that
radius along the skin. Gaps between neighbouring stripes close, and the border of the seen region comes to lie up to a
millimetre beyond the last points: a stripe stands for the skin beside it.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from scipy.spatial import KDTree

from footscan.coordinates import Bools, Floats, Ints

_PROBES = 4000
_PROBE_RADIUS = 6.0
_REACH = 0.9  # of the stripe spacing: two stripes whose gap is closed may lie 1.8 spacings apart
_RADIUS_MM = (1.2, 4.0)
_BESIDE, _BESIDE_MM = 0.5, 1.0  # of the radius, and at most: how far beyond the last points skin counts as seen
_HALF_WAY = 0.1  # of a facet: a vertex stands for the facets around it


class Origin(IntEnum):
    """Where a part of the surface comes from."""

    SEEN = 0
    BRIDGED = 1
    ASSUMED_SOLE = 2
    CUT = 3


@dataclass(frozen=True)
class StripeSpacing:
    """Local distance between laser stripes, at some of the points.

    Attributes:
        probes_mm: `(p, 3)` points.
        spacing_mm: `(p,)`.
    """

    probes_mm: Floats
    spacing_mm: Floats

    def at(self, xyz_mm: Floats) -> Floats:
        """Spacing `(n,)` at places: the closest of the three nearest probes, since probes at a border see only half."""
        _, which = KDTree(self.probes_mm).query(xyz_mm, k=min(3, len(self.probes_mm)), workers=-1)
        return self.spacing_mm[which.reshape(len(xyz_mm), -1)].min(axis=1)


def find_stripe_spacing(xyz_mm: Floats, tree: KDTree) -> StripeSpacing:
    """Estimate the stripe spacing from the density of points and their distance along a stripe.

    Args:
        xyz_mm: `(n, 3)` measured points.
        tree: A tree of them.
    """
    step = max(1, len(xyz_mm) // _PROBES)
    probes = xyz_mm[::step]
    along = float(np.median(tree.query(probes, k=2, workers=-1)[0][:, 1]))
    counts = np.asarray(tree.query_ball_point(probes, _PROBE_RADIUS, return_length=True, workers=-1), dtype=np.float64)
    return StripeSpacing(probes, np.pi * _PROBE_RADIUS**2 / (counts * max(along, 1e-3)))


def find_covered(xyz_mm: Floats, tree: KDTree, radius_mm: Floats, facet_mm: float) -> Bools:
    """Whether places of a surface lie on skin that the points of a tree cover, see the module's text.

    Args:
        xyz_mm: `(n, 3)` places.
        tree: Of the measured points.
        radius_mm: `(n,)` closing radius.
        facet_mm: Distance between places; a share of it is added to what the region is shrunk by.
    """
    near = tree.query(xyz_mm, distance_upper_bound=float(radius_mm.max()), workers=-1)[0] <= radius_mm
    if near.all() or not near.any():
        return near
    farthest = float(radius_mm.max()) + facet_mm
    gap = KDTree(xyz_mm[~near]).query(xyz_mm[near], distance_upper_bound=farthest, workers=-1)[0]
    beside = np.minimum(_BESIDE * radius_mm[near], _BESIDE_MM)
    near[near] = gap > radius_mm[near] - beside + _HALF_WAY * facet_mm
    return near


def closing_radius_mm(spacing: StripeSpacing, xyz_mm: Floats) -> Floats:
    """Radius `(n,)` that closes the gaps between neighbouring stripes at places on the surface."""
    return np.clip(_REACH * spacing.at(xyz_mm), *_RADIUS_MM)


def classify(covered: Bools, v: Floats, lowest_v: Floats) -> Ints:
    """Class `(n,)` of skin: seen where covered, else assumed sole below the lowest seen skin, bridged above."""
    unseen = np.where(v < lowest_v, int(Origin.ASSUMED_SOLE), int(Origin.BRIDGED))
    return np.where(covered, int(Origin.SEEN), unseen)
