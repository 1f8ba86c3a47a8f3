"""How far the skin of each zone went between two looks at it, and how sure that is.

Two looks are two clouds of the same skin. Along its normal a point tells one number: how far it lies from the other
look's surface. Over a zone the normals point many ways, so the numbers of a zone fix a small rigid motion of it, three
shifts and three turns. Three things else can make the two looks differ, and the fit knows them:

* noise and speckle, which neighbouring points share: a patch of 8 mm counts like a few independent points at most;
* an imperfect calibration: each laser's points are misplaced by a smooth field that is fixed to the turning head, so it
  is the same all the way round. That field is fitted along with the motion, kept small by `CALIBRATION_MM`;
* what a zone's normals do not show (sliding along a cylinder): there the prior holds the motion at zero and the
  uncertainty stays large.
"""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats, Ints
from footscan.geometry.nearest import PointTree
from footscan.scanning.facing import Facing, find_facing
from footscan.scanning.zones import ZONES

CALIBRATION_MM = 0.06
"""Expected size (standard deviation) of every coefficient of a laser's misplacement field."""
_SHIFT_MM, _TURN_MM = 2.0, 0.7  # expected motion of a zone; its turn 30 mm from its middle
_LEVER_MM = 30.0
_POINT_MM = 0.05
_PATCH_MM = 8.0
_SHARED_SHARE = 0.8  # of the scatter: error that the points of a patch have in common
_ROUNDS = 3
_NEAR_MM = 0.4
_POINTS_PER_ZONE = 400
_MOST_POINTS = 16000  # of a look, as neighbours: two dozen of them then reach over three stripes
_SAME_SKIN = 0.9
"""Cosine between the normals that both looks have there: across a cleft between toes they differ."""
_FEWEST_POINTS = 40
_FIELD = 6  # 1, x, z, xx, xz, zz in the sheet
_LASER_TERMS = 3 * _FIELD
_CALIBRATION_TERMS = 2 * _LASER_TERMS
_TUKEY = (9.0, 7.0, 5.5, 4.7)
_LEAST_SCALE_MM = 0.06


@dataclass(frozen=True)
class Look:
    """One look at the skin: points of one laser.

    Attributes:
        laser: Its code.
        xyz_world: `(n, 3)`.
        theta_rad: `(n,)` head angle of each point.
        zone: `(n,)` index into `ZONES`.
        outward: `(n, 3)` directions out of the foot.
    """

    laser: int
    xyz_world: Floats
    theta_rad: Floats
    zone: Ints
    outward: Floats


@dataclass(frozen=True)
class ZoneShift:
    """The rigid motion of a zone from the first look to the second.

    Attributes:
        points: That faced the other look.
        centre_world: `(3,)` its middle, mm.
        motion: `(6,)` shift (mm) and turn (mm at 30 mm from the middle).
        spread: `(6, 6)` mean over the points of what the motion does to them, squared.
        shown: `(6, 6)` the same, of their way along the normals: what the looks show directly.
        covariance: `(6, 6)` of the motion.
    """

    points: int
    centre_world: Floats
    motion: Floats
    spread: Floats
    shown: Floats
    covariance: Floats

    @property
    def size_mm(self) -> float:
        """RMS way of the zone's points."""
        return float(np.sqrt(self.motion @ self.spread @ self.motion))

    @property
    def sigma_mm(self) -> float:
        """Standard deviation of that way."""
        return float(np.sqrt(np.trace(self.spread @ self.covariance)))

    @property
    def shown_mm(self) -> float:
        """RMS way along the normals."""
        return float(np.sqrt(self.motion @ self.shown @ self.motion))

    @property
    def shown_sigma_mm(self) -> float:
        """Standard deviation of that way."""
        return float(np.sqrt(np.trace(self.shown @ self.covariance)))

    def at(self, xyz_world: Floats) -> Floats:
        """Ways `(n, 3)` of points."""
        return np.einsum("ndk,k->nd", _rigid_terms(xyz_world - self.centre_world), self.motion)


@dataclass(frozen=True)
class Comparison:
    """The second look against the first.

    Attributes:
        zones: By index into `ZONES`; only zones with enough facing points.
        calibration_mm: RMS distance along the normals that the misplacement fields explain.
        residual_mm: Median distance left.
    """

    zones: dict[int, ZoneShift]
    calibration_mm: float
    residual_mm: float


@dataclass(frozen=True)
class _Facts:
    """One number per facing point: how far the second look lies above the first, and what could explain it."""

    xyz: Floats
    zone: Ints
    value_mm: Floats
    noise_mm: Floats
    terms: Floats


def compare_looks(first: Look, second: Look, reach_mm: float) -> Comparison:
    """Fit the motion of every zone from the first look to the second."""
    centres = _zone_centres(first, second)
    motions: dict[int, Floats] = {}
    facts = _facts(first, second, motions, centres, reach_mm)
    solved = _solve(facts, centres, robust=False)
    for done in range(_ROUNDS):
        if done and max((shift.size_mm for shift in solved.zones.values()), default=0.0) < _NEAR_MM:
            break  # what lies this near was matched rightly the first time
        motions = {zone: shift.motion for zone, shift in solved.zones.items()}
        facts = _facts(first, second, motions, centres, reach_mm)
        solved = _solve(facts, centres, robust=True)
    return solved


def _zone_centres(first: Look, second: Look) -> dict[int, Floats]:
    xyz, zone = np.concatenate([first.xyz_world, second.xyz_world]), np.concatenate([first.zone, second.zone])
    return {code: xyz[zone == code].mean(axis=0) for code in range(len(ZONES)) if (zone == code).any()}


def _facts(
    first: Look, second: Look, motions: dict[int, Floats], centres: dict[int, Floats], reach_mm: float
) -> _Facts:
    """Both directions: on a convex skin a point tends to lie above its neighbours' surface whichever look it is of,
    which cancels in the mean of second minus first."""
    back = second.xyz_world.copy()
    for code, motion in motions.items():
        own = second.zone == code
        back[own] -= _rigid_terms(back[own] - centres[code]) @ motion
    parts = [
        _one_way(first, second, first.xyz_world, back, -1.0, motions, centres, reach_mm),
        _one_way(second, first, back, first.xyz_world, 1.0, motions, centres, reach_mm),
    ]
    columns = [[getattr(part, name) for part in parts] for name in ("xyz", "zone", "value_mm", "noise_mm", "terms")]
    return _Facts(*(np.concatenate(column) for column in columns))


def _one_way(
    own: Look,
    other: Look,
    xyz: Floats,
    xyz_other: Floats,
    sign: float,
    motions: dict[int, Floats],
    centres: dict[int, Floats],
    reach_mm: float,
) -> _Facts:
    asked = _spread_over_zones(own.zone)
    # points lie much closer along a stripe than stripes lie to each other
    every, every_other = (max(1, round(len(cloud) / _MOST_POINTS)) for cloud in (xyz, xyz_other))
    thinned, thinned_other = xyz[::every], xyz_other[::every_other]
    itself = find_facing(xyz[asked], own.outward[asked], PointTree(thinned), thinned, reach_mm)
    asked = asked[itself.index]
    faced = find_facing(xyz[asked], own.outward[asked], PointTree(thinned_other), thinned_other, reach_mm)
    faced = faced.where(np.sum(itself.normal[faced.index] * faced.normal, axis=1) > _SAME_SKIN)
    at = asked[faced.index]
    place, zone = xyz[at], own.zone[at]
    value = sign * faced.distance_mm
    for code, motion in motions.items():
        there = zone == code
        way = _rigid_terms(place[there] - centres[code]) @ motion
        value[there] += np.sum(faced.normal[there] * way, axis=1)
    # second minus first: the second look's field counts positive
    terms = np.zeros((len(at), _CALIBRATION_TERMS))
    _add_field(terms, faced, place, own.laser, own.theta_rad[at], sign)
    _add_field(terms, faced, place, other.laser, other.theta_rad[::every_other][faced.other], -sign)
    rigid = np.einsum("nd,ndk->nk", faced.normal, _rigid_terms(place - _centre_of(zone, centres)))
    noise = np.sqrt(_POINT_MM**2 + faced.scatter_mm**2)
    return _Facts(place, zone, value, noise, np.concatenate([terms, rigid], axis=1))


def _spread_over_zones(zone: Ints) -> Ints:
    """Indices of at most so many points of every zone, evenly picked: toes and heel have few, and count as much."""
    parts = [np.flatnonzero(zone == code) for code in range(len(ZONES))]
    return np.concatenate([part[:: max(1, len(part) // _POINTS_PER_ZONE)] for part in parts])


def _centre_of(zone: Ints, centres: dict[int, Floats]) -> Floats:
    table = np.zeros((len(ZONES), 3))
    for code, centre in centres.items():
        table[code] = centre
    return table[zone]


def _rigid_terms(from_centre: Floats) -> Floats:
    """`(n, 3, 6)`: the way of points at `(n, 3)` from the middle, per unit of shift and turn."""
    x, y, z = (from_centre / _LEVER_MM).T
    terms = np.zeros((len(x), 3, 6))
    terms[:, 0, 0] = terms[:, 1, 1] = terms[:, 2, 2] = 1.0
    terms[:, 1, 3], terms[:, 2, 3] = -z, y
    terms[:, 0, 4], terms[:, 2, 4] = z, -x
    terms[:, 0, 5], terms[:, 1, 5] = -y, x
    return terms


def _add_field(terms: Floats, faced: Facing, xyz: Floats, laser: int, theta_rad: Floats, sign: float) -> None:
    """What each coefficient of a laser's misplacement field, fixed to the head, does along the normals."""
    c, s = np.cos(theta_rad), np.sin(theta_rad)
    place, normal = xyz, faced.normal
    head = np.stack([c * place[:, 0] + s * place[:, 1], c * place[:, 1] - s * place[:, 0]], axis=1)
    normal_head = np.stack([c * normal[:, 0] + s * normal[:, 1], c * normal[:, 1] - s * normal[:, 0], normal[:, 2]], 1)
    sheet = head.mean(axis=0)
    x = head @ (sheet / max(float(np.linalg.norm(sheet)), 1e-9)) / 100.0
    z = (xyz[:, 2] - 50.0) / 100.0
    field = np.stack([np.ones_like(x), x, z, x * x, x * z, z * z], axis=1)
    begin = laser * _LASER_TERMS
    terms[:, begin : begin + _LASER_TERMS] += sign * np.einsum("nd,nf->ndf", normal_head, field).reshape(len(x), -1)


def _solve(facts: _Facts, centres: dict[int, Floats], robust: bool) -> Comparison:
    codes = [code for code in centres if (facts.zone == code).sum() >= _FEWEST_POINTS]
    used = np.isin(facts.zone, codes)
    zone, value, xyz = facts.zone[used], facts.value_mm[used], facts.xyz[used]
    if not len(value):
        return Comparison({}, 0.0, 0.0)
    size = _CALIBRATION_TERMS + 6 * len(codes)
    design = np.zeros((len(value), size))
    design[:, :_CALIBRATION_TERMS] = facts.terms[used, :_CALIBRATION_TERMS]
    for place, code in enumerate(codes):
        begin = _CALIBRATION_TERMS + 6 * place
        design[zone == code, begin : begin + 6] = facts.terms[used][zone == code, _CALIBRATION_TERMS:]
    prior = np.diag([1.0 / CALIBRATION_MM**2] * _CALIBRATION_TERMS + _zone_prior() * len(codes))
    every = np.ones(len(value))
    weight = _patch_weight(xyz, facts.noise_mm[used], _LEAST_SCALE_MM * every, every)
    solution, information = _weighted(design, value, weight, prior)
    for times in _TUKEY if robust else ():
        residual = value - design @ solution
        scatter = _scatter(residual, zone)
        calm = np.clip(1.0 - (residual / (times * scatter)) ** 2, 0.0, 1.0) ** 2  # Tukey's weights
        weight = _patch_weight(xyz, np.hypot(facts.noise_mm[used], scatter), _SHARED_SHARE * scatter, calm)
        solution, information = _weighted(design, value, weight, prior)
    covariance = np.asarray(np.linalg.inv(information), dtype=np.float64)
    zones: dict[int, ZoneShift] = {}
    for place, code in enumerate(codes):
        block = slice(_CALIBRATION_TERMS + 6 * place, _CALIBRATION_TERMS + 6 * place + 6)
        own = _rigid_terms(xyz[zone == code] - centres[code])
        spread = np.einsum("ndk,ndl->kl", own, own) / len(own)
        along = design[zone == code, block]
        shown = along.T @ along / len(own)
        zones[code] = ZoneShift(len(own), centres[code], solution[block], spread, shown, covariance[block, block])
    pattern = design[:, :_CALIBRATION_TERMS] @ solution[:_CALIBRATION_TERMS]
    left = float(np.median(np.abs(value - design @ solution)))
    return Comparison(zones, float(np.sqrt(np.mean(pattern**2))), left)


def _zone_prior() -> list[float]:
    return [1.0 / _SHIFT_MM**2] * 3 + [1.0 / _TURN_MM**2] * 3


def _weighted(design: Floats, value: Floats, weight: Floats, prior: Floats) -> tuple[Floats, Floats]:
    information = design.T @ (weight[:, None] * design) + prior
    return np.asarray(np.linalg.solve(information, design.T @ (weight * value)), np.float64), information


def _scatter(residual: Floats, zone: Ints) -> Floats:
    """Scatter `(n,)` (mm) of the point's own zone: toes scatter more than a shin."""
    scale = np.full(len(ZONES), _LEAST_SCALE_MM)
    for code in np.unique(zone):
        scale[code] = max(1.4826 * float(np.median(np.abs(residual[zone == code]))), _LEAST_SCALE_MM)
    return scale[zone]


def _patch_weight(xyz: Floats, noise_mm: Floats, shared_mm: Floats, calm: Floats) -> Floats:
    """Weights `(n,)` of points that share part of their error with the others of their patch."""
    cell = np.floor((xyz - xyz.min(axis=0)) / _PATCH_MM).astype(np.int64)
    patch = np.ravel_multi_index((cell[:, 0], cell[:, 1], cell[:, 2]), tuple(cell.max(axis=0) + 1))
    own = calm / noise_mm**2
    total = np.bincount(patch, weights=own)[patch]
    return own / (1.0 + total * shared_mm**2)
