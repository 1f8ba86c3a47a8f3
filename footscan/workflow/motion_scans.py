"""Simulated scans of people for the motion study: stripes kept in memory, so that one scan can be judged with several
calibrations, and nothing is written."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from footscan.coordinates import LASER_NAMES, Floats, Frame, Ints, LaserName, Side
from footscan.optics.calibration import Calibration, theta_from_encoder
from footscan.optics.scanner import Scanner
from footscan.optics.tables import LightTable, build_table
from footscan.scanning.cleaning import foot_body
from footscan.scanning.cloud import cloud_from_matrix
from footscan.scanning.footboard import check_board
from footscan.scanning.matrix import ScanMatrix
from footscan.scanning.motion import FrameTable, MotionResult, judge_motion
from footscan.scanning.stripe import StripeFinder, brightness_histogram
from footscan.scanning.stripe.threshold import threshold_from_histogram
from footscan.sim.machine import workshop_machine
from footscan.sim.motion import SweepPlan
from footscan.sim.objects import build_object
from footscan.sim.person import CALM, Move, Person, PersonSettings
from footscan.sim.picture import Painter
from footscan.sim.record import SimulatedScan, prepare_scan

_THRESHOLD_EVERY = 12


@dataclass(frozen=True)
class Visitor:
    """Who is scanned.

    Attributes:
        thing: The built-in foot, or a mesh file.
        side: Of the built-in foot.
        size: Of the built-in foot.
        unit: Of the mesh file.
        fidgets: How restless.
        moves: What this person does during the scan.
    """

    thing: str = "foot"
    side: Side = "left"
    size: float = 1.0
    unit: str = "mm"
    fidgets: PersonSettings = CALM
    moves: tuple[Move, ...] = ()


@dataclass(frozen=True)
class ScanPlan:
    """Both sweeps of a plan, farther than a full turn where the head can; lasers in turns if asked for."""

    sweeps: SweepPlan = field(default_factory=SweepPlan)
    turn_rad: float = 2.0 * np.pi
    alternating: bool = False

    @property
    def pause_s(self) -> float:
        """When a move in the middle of the pause between the sweeps begins."""
        return self.sweeps.frames_per_sweep / self.sweeps.frames_per_s + self.sweeps.ramp_s + 0.1


@dataclass(frozen=True)
class SeenFrame:
    """What is left of one frame: its stripe `(n, 2)` in the upright frame with weights `(n,)`, and its stamp."""

    laser: LaserName
    sweep: int
    time_s: float
    uv: Floats
    weight: Floats


@dataclass(frozen=True)
class SeenScan:
    """A simulated scan without its pictures, and the machine's true calibration."""

    truth: Calibration
    frames: tuple[SeenFrame, ...]
    encoder_time_s: Floats
    encoder_count: Ints


def see_scan(scanner: Scanner, visitor: Visitor, plan: ScanPlan, seed: int) -> SeenScan:
    """Scan a person on the workshop machine of a seed: the ccw sweep with its laser first, then the other way."""
    surface = build_object(visitor.thing, visitor.unit, visitor.side, visitor.size)
    scan = prepare_scan(workshop_machine(scanner, seed), surface, plan.sweeps, seed=seed)
    motion = replace(scan.motion, theta_rad=scan.motion.theta_rad * (plan.turn_rad / (2.0 * np.pi)))
    scan = replace(scan, motion=motion)
    person = Person(scan.surface, visitor.fidgets, seed, visitor.moves)
    threshold = _threshold(scan, person, plan)
    finder = StripeFinder()
    frames: list[SeenFrame] = []
    for laser, sweep, exposure_s, picture in _pictures(scan, person, plan):
        stripe = finder.find(picture, threshold)
        stamp_s = exposure_s + scan.machine.calibration.latency_s
        frames.append(SeenFrame(laser, sweep, stamp_s, stripe.uv, stripe.weight))
    return SeenScan(scan.machine.calibration, tuple(frames), *scan.counts())


def _pictures(
    scan: SimulatedScan, person: Person, plan: ScanPlan, every: int = 1
) -> Iterator[tuple[LaserName, int, float, Frame]]:
    painter = Painter(scan.machine.calibration, scan.surface, scan.picture, scan.seed)
    lasers = sorted(scan.machine.scanner.lasers, key=lambda laser: laser.sweep == "cw")
    order: list[LaserName] = [laser.name for laser in lasers]
    number = 0
    for sweep, exposure_s in enumerate(scan.motion.exposure_s):
        thetas = scan.motion.theta_at(exposure_s)
        for k in range(0, len(exposure_s), every):
            laser = order[(k // every if plan.alternating else sweep) % 2]
            moment = float(exposure_s[k])
            painter.set_vertices(person.xyz_world_at(moment))
            yield laser, sweep + 1, moment, painter.paint(float(thetas[k]), laser, number)
            number += 1


def _threshold(scan: SimulatedScan, person: Person, plan: ScanPlan) -> int:
    histogram = np.zeros(256, dtype=np.int64)
    for _, _, _, picture in _pictures(scan, person, plan, _THRESHOLD_EVERY):
        histogram += brightness_histogram(picture)
    return threshold_from_histogram(histogram)


def judge_seen(seen: SeenScan, calibration: Calibration) -> MotionResult:
    """What processing with a calibration says of motion, by the steps of `process`."""
    tables: dict[LaserName, LightTable] = {name: build_table(calibration, name) for name in LASER_NAMES}
    matrix = _matrix(seen, calibration, tables)
    whole = cloud_from_matrix(matrix, tables)
    board = check_board(whole, calibration.floor).plane
    body, _ = foot_body(whole, calibration.floor, *(() if board is None else (board,)))
    sweep = np.array([frame.sweep for frame in seen.frames])
    return judge_motion(body, FrameTable(matrix.frame, matrix.theta_rad, sweep[matrix.frame]))


def _matrix(seen: SeenScan, calibration: Calibration, tables: dict[LaserName, LightTable]) -> ScanMatrix:
    matrix = ScanMatrix(tables["right"].calibration_sha256)
    time_s = np.array([frame.time_s for frame in seen.frames])
    count = np.interp(time_s - calibration.latency_s, seen.encoder_time_s, seen.encoder_count.astype(np.float64))
    theta_rad = theta_from_encoder(count, calibration.encoder)
    for number, (frame, theta) in enumerate(zip(seen.frames, theta_rad.tolist(), strict=True)):
        xy_light = tables[frame.laser].lookup(frame.uv)
        inside = np.isfinite(xy_light[:, 0])
        matrix.append(number, frame.laser, theta, xy_light[inside], frame.weight[inside])
    return matrix
