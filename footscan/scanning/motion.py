"""Was the foot moved? The skin of each zone in one look against the same zone in another (`motion_fit`).

Evidence, from the best to the poorest:

| kind | looks | says |
|---|---|---|
| `same laser` | the first and the last degrees of a sweep of more than a full turn | moved during this sweep |
| `same laser` | one laser in two sweeps | moved between the sweeps, or during one of them |
| `other laser` | right and left, in two sweeps | the same, where both see the skin |
| `other laser` | right and left, in turns within one sweep | moved during this sweep |

A zone without evidence is *not judged*; nothing is still by default.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from threadpoolctl import threadpool_limits

from footscan.coordinates import LASER_NAMES, Bools, Floats, Ints
from footscan.scanning.cloud import Cloud
from footscan.scanning.matrix import ScanMatrix
from footscan.scanning.motion_fit import Comparison, Look, ZoneShift, compare_looks
from footscan.scanning.recording import FrameRecord
from footscan.scanning.zones import ZONES, direction_from_core, zone_of_points

EvidenceKind = Literal["same laser", "other laser", "none"]
WHOLE_FOOT = "whole foot"
MOVED_MM = 0.5
"""A zone counts as moved from here: breathing and pulse move the skin by 0.1 mm, a typical calibration error of 0.1 mm
looks like up to 0.25 mm, and 0.5 mm at either side of a girth changes it by less than the 2 mm of ISO 20685."""
MOVED_SIGMAS = 2.5
LARGEST_DETECTABLE_MM = 1.25
"""A zone in which only larger motions would show is not judged."""
_REACH_MM, _REACH_STRIPES, _LARGEST_REACH_MM = 5.5, 2.2, 9.0
_TYPICAL_RADIUS_MM = 80.0
_MARGIN_FRAMES = 3
_FEWEST_POINTS = 200
_AS_ONE = 0.35
_AS_ONE_ZONES = 3


@dataclass(frozen=True)
class FrameTable:
    """Of the frames behind a cloud, in the order they were taken: number, head angle (rad), sweep (1, 2, ...)."""

    frame: Ints
    theta_rad: Floats
    sweep: Ints


def frame_table(records: Sequence[FrameRecord], matrix: ScanMatrix) -> FrameTable:
    """Angle and sweep of every frame in a matrix; a sweep ends where the direction of the records changes."""
    number, before = 0, ""
    numbers: dict[int, int] = {}
    for record in sorted(records, key=lambda record: record.time_s):
        number += record.sweep != before
        before = record.sweep
        numbers[record.frame] = number
    sweep = np.array([numbers[frame] for frame in matrix.frame.tolist()], dtype=np.int64)
    return FrameTable(matrix.frame, matrix.theta_rad, sweep)


@dataclass(frozen=True)
class ZoneMotion:
    """What one piece of evidence says of one zone.

    Attributes:
        zone: One of `ZONES`.
        evidence: Which looks were compared.
        when: When the motion took place, if there was one.
        points: That faced the other look.
        displacement_mm: RMS way of the zone's skin; None when not judged.
        sigma_mm: Its standard deviation: noise, calibration, and directions that the skin does not show.
        detectable_mm: The smallest motion that would be called one.
        moved: None when not judged.
    """

    zone: str
    evidence: EvidenceKind
    when: str
    points: int
    displacement_mm: float | None
    sigma_mm: float | None
    detectable_mm: float | None
    moved: bool | None


@dataclass(frozen=True)
class MotionFinding:
    """The one thing to say: which zone moved most (or `WHOLE_FOOT`), how far, how sure, when."""

    zone: str
    displacement_mm: float
    sigma_mm: float
    when: str


@dataclass(frozen=True)
class MotionResult:
    """All of it.

    Attributes:
        zones: One entry per zone: its strongest evidence.
        evidence: Every comparison's entry per zone.
        finding: None when no judged zone moved.
        calibration_mm: RMS disagreement of the lasers that is the same all the way round and so the calibration's.
        absent: Zones of which there is hardly any skin at all: a shoelast has no ankle.
    """

    zones: tuple[ZoneMotion, ...]
    evidence: tuple[ZoneMotion, ...]
    finding: MotionFinding | None
    calibration_mm: float | None
    absent: tuple[str, ...] = ()

    @property
    def not_judged(self) -> tuple[str, ...]:
        """Zones that are there, but without sufficient evidence."""
        return tuple(zone.zone for zone in self.zones if zone.moved is None and zone.zone not in self.absent)


@dataclass(frozen=True)
class _Evidence:
    kind: EvidenceKind
    when: str
    revisit: bool
    comparison: Comparison


def judge_motion(cloud: Cloud, frames: FrameTable) -> MotionResult:
    """Compare all looks that a scan holds.

    Args:
        cloud: The foot's points (`foot_body`), before `smooth_skin`: points off the common surface are the evidence.
        frames: All its frames.
    """
    if len(cloud) < _FEWEST_POINTS:
        return MotionResult(tuple(_not_judged(zone) for zone in ZONES), (), None, None)
    with threadpool_limits(1):  # the matrices are small: two BLAS threads wait for each other
        found = list(_evidence(cloud, frames))
    rows = [_row(code, item) for item in found for code in range(len(ZONES))]
    zones = tuple(_strongest(zone, rows) for zone in ZONES)
    across = [item.comparison.calibration_mm for item in found if item.kind == "other laser"]
    finding, shared_mm = _finding(zones, found), max(across, default=None)
    return MotionResult(zones, tuple(rows), finding, shared_mm, _absent(cloud))


def _absent(cloud: Cloud) -> tuple[str, ...]:
    count = np.bincount(zone_of_points(cloud.xyz_world), minlength=len(ZONES))
    return tuple(name for name, points in zip(ZONES, count.tolist(), strict=True) if points < _FEWEST_POINTS)


def _evidence(cloud: Cloud, frames: FrameTable) -> Iterator[_Evidence]:
    row = np.searchsorted(np.sort(frames.frame), cloud.frame)
    order = np.argsort(frames.frame)
    theta, sweep = frames.theta_rad[order][row], frames.sweep[order][row]
    zone, outward = zone_of_points(cloud.xyz_world), direction_from_core(cloud.xyz_world)

    def look(keep: Bools, laser: int) -> Look:
        return Look(laser, cloud.xyz_world[keep], theta[keep], zone[keep], outward[keep])

    passes = [
        (laser, number, (cloud.laser == laser) & (sweep == number))
        for number in np.unique(frames.sweep).tolist()
        for laser in range(len(LASER_NAMES))
        if ((cloud.laser == laser) & (sweep == number)).sum() >= _FEWEST_POINTS
    ]
    reach_mm = _reach_mm([np.unique(theta[own]) for _, _, own in passes])
    for laser, number, own in passes:
        begin, end = _revisited(theta, own, frames, number)
        if end.sum() >= _FEWEST_POINTS:
            comparison = compare_looks(look(begin, laser), look(end, laser), reach_mm)
            yield _Evidence("same laser", f"during sweep {number}", True, comparison)
    for (laser, number, own), (laser_2, number_2, own_2) in combinations(passes, 2):
        twice = any(a == laser and b == number_2 for a, b, _ in passes)
        if laser != laser_2 and number != number_2 and twice:
            continue  # the same laser is there in both sweeps: better evidence
        kind: EvidenceKind = "same laser" if laser == laser_2 else "other laser"
        when = f"during sweep {number}" if number == number_2 else f"between sweeps {number} and {number_2}"
        yield _Evidence(kind, when, False, compare_looks(look(own, laser), look(own_2, laser_2), reach_mm))


def _reach_mm(angles: list[Floats]) -> float:
    steps = [float(np.median(np.diff(theta))) for theta in angles if len(theta) > 1]
    stripe_mm = max(steps, default=0.0) * _TYPICAL_RADIUS_MM
    return float(np.clip(_REACH_STRIPES * stripe_mm, _REACH_MM, _LARGEST_REACH_MM))


def _revisited(theta: Floats, own: Bools, frames: FrameTable, sweep: int) -> tuple[Bools, Bools]:
    """Points of one pass from the first and from the last degrees of a sweep that went on after a full turn."""
    angles = frames.theta_rad[frames.sweep == sweep]
    margin = _MARGIN_FRAMES * float(np.median(np.abs(np.diff(angles)))) if len(angles) > 1 else 0.0
    travel = np.abs(theta - angles[0])
    extra = float(np.abs(angles - angles[0]).max()) - 2.0 * np.pi
    if extra < margin:
        return own & False, own & False
    return own & (travel <= extra + margin), own & (travel >= 2.0 * np.pi - margin)


def _not_judged(zone: str) -> ZoneMotion:
    return ZoneMotion(zone, "none", "", 0, None, None, None, None)


def _row(code: int, item: _Evidence) -> ZoneMotion:
    shift = item.comparison.zones.get(code)
    if shift is None:
        return _not_judged(ZONES[code])
    size, sigma, detectable = shift.size_mm, shift.sigma_mm, _detectable_mm(shift)
    moved = True if _has_moved(shift) else (None if detectable > LARGEST_DETECTABLE_MM else False)
    return ZoneMotion(ZONES[code], item.kind, item.when, shift.points, size, sigma, detectable, moved)


def _has_moved(shift: ZoneShift) -> bool:
    """By its whole way, or by what it shows along the normals: a small patch tells that well and hides the rest."""
    shown = shift.shown_mm >= max(MOVED_MM, MOVED_SIGMAS * shift.shown_sigma_mm)
    return shown or shift.size_mm >= _detectable_mm(shift)


def _detectable_mm(shift: ZoneShift) -> float:
    return max(MOVED_MM, MOVED_SIGMAS * shift.sigma_mm)


def _strongest(zone: str, rows: list[ZoneMotion]) -> ZoneMotion:
    """Moved with the largest way, else the surest still, else the least unsure."""
    own = [row for row in rows if row.zone == zone and row.sigma_mm is not None]
    rank = {True: 2, False: 1, None: 0}
    return max(
        own,
        key=lambda row: (rank[row.moved], (row.displacement_mm or 0.0) if row.moved else -(row.sigma_mm or 0.0)),
        default=_not_judged(zone),
    )


def _finding(zones: tuple[ZoneMotion, ...], found: list[_Evidence]) -> MotionFinding | None:
    moved = [zone for zone in zones if zone.moved]
    if not moved:
        return None
    most = max(moved, key=lambda zone: zone.displacement_mm or 0.0)
    assert most.displacement_mm is not None
    assert most.sigma_mm is not None
    together = any(_moves_as_one(item.comparison) for item in found if not item.revisit)
    name = WHOLE_FOOT if together else most.zone
    return MotionFinding(name, most.displacement_mm, most.sigma_mm, _when(most, together, found))


def _when(most: ZoneMotion, together: bool, found: list[_Evidence]) -> str:
    """A motion between two looks is one between the sweeps only where each sweep was seen to be still in itself."""
    codes = range(len(ZONES)) if together else [ZONES.index(most.zone)]
    within = [_row(code, item) for item in found if item.when.startswith("during") for code in codes]
    for row in within:
        if row.moved:
            return row.when
    still = {row.when for row in within if row.moved is False}
    if most.when.startswith("during") or len(still) >= 2:
        return most.when
    return most.when + ", or during one of them"


def _moves_as_one(comparison: Comparison) -> bool:
    """Whether one rigid motion explains those of all zones, of which several moved."""
    shifts = [shift for shift in comparison.zones.values() if _detectable_mm(shift) <= LARGEST_DETECTABLE_MM]
    moved = [shift for shift in shifts if _has_moved(shift)]
    if len(moved) < _AS_ONE_ZONES:
        return False
    places = [shift.centre_world + 15.0 * np.concatenate([np.eye(3), -np.eye(3)]) for shift in shifts]
    ways = [shift.at(place) for shift, place in zip(shifts, places, strict=True)]
    left = _after_rigid(np.concatenate(places), np.concatenate(ways)).reshape(len(shifts), -1)
    largest = max(shift.size_mm for shift in moved)
    rms = np.sqrt(3.0 * np.mean(left**2, axis=1))
    return bool(np.all(rms <= max(MOVED_MM, _AS_ONE * largest)))


def _after_rigid(xyz: Floats, way: Floats) -> Floats:
    """What the best small rigid motion leaves of `(n, 3)` ways."""
    x, y, z = (xyz - xyz.mean(axis=0)).T
    zero, one = np.zeros(len(x)), np.ones(len(x))
    rows = [[one, zero, zero, zero, z, -y], [zero, one, zero, -z, zero, x], [zero, zero, one, y, -x, zero]]
    design = np.stack([np.stack(row, axis=1) for row in rows], axis=1).reshape(-1, 6)
    solved = np.linalg.lstsq(design, way.ravel(), rcond=None)[0]
    return (way.ravel() - design @ solved).reshape(-1, 3)
