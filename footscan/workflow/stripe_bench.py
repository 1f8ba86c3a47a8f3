"""`footscan bench stripe`: our stripe against the plain way and the paper's, frame by frame in turn in one run."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from threadpoolctl import threadpool_limits

from footscan.coordinates import LASER_NAMES, Floats, Frame
from footscan.optics.calibration import Calibration, EncoderScale, Pose
from footscan.optics.camera import Camera
from footscan.optics.scanner import Scanner, calibration_from_design
from footscan.optics.tables import LightTable, build_table
from footscan.scanning.stripe import StripeFinder

THRESHOLD = 60
SIZES = ((582, 500), (1280, 960), (2448, 2048))
ANGLES_DEG = (0.0, 30.0, 60.0, 90.0)
STEP_PX = 20.0
_SIGMA_PX, _PEAK = 2.0, 200.0


@dataclass(frozen=True)
class LineFrame:
    """A synthetic frame with one line: its unit normal (u, v), a place on it, the sideways step of its lower half."""

    frame: Frame
    normal: Floats
    place: Floats
    step_px: float

    def error_across_px(self, uv: Floats) -> Floats:
        """Signed distance `(n,)` of places `(n, 2)` to the nearer of the two lines."""
        upper = (uv - self.place) @ self.normal
        lower = upper - self.step_px * self.normal[0]
        return np.where(np.abs(upper) < np.abs(lower), upper, lower) if self.step_px else upper


def draw_line(width_px: int, height_px: int, angle_deg: float, seed: int, step_px: float = 0.0) -> LineFrame:
    """A Gaussian line (sigma 2 px, peak 200) on a background uniform in 10..30, drawn independently per pixel.

    `angle_deg` is the direction of the normal: 0 is a line along the columns, 90 one along the rows.
    """
    rng = np.random.default_rng(seed)
    angle = np.radians(angle_deg)
    normal = np.array([np.cos(angle), np.sin(angle)])
    place = np.array([width_px / 2.0, height_px / 2.0]) + rng.uniform(-0.5, 0.5, 2)
    v, u = np.mgrid[0:height_px, 0:width_px].astype(float)
    across = (u - place[0]) * normal[0] + (v - place[1]) * normal[1]
    across = np.where(v < height_px // 2, across, across - step_px * normal[0])
    light = _PEAK * np.exp(-(across**2) / (2.0 * _SIGMA_PX**2)) + rng.uniform(10.0, 30.0, across.shape)
    return LineFrame(np.clip(np.rint(light), 0, 255).astype(np.uint8), normal, place, step_px)


def machine_of_size(scanner: Scanner, width_px: int, height_px: int) -> Calibration:
    """A design with its sensor divided into other pixels."""
    design = calibration_from_design(scanner)
    own = design.camera
    camera = Camera(
        width_px,
        height_px,
        own.pixel_pitch_y_mm * own.width_px / width_px,
        own.pixel_pitch_z_mm * own.height_px / height_px,
        own.focal_length_mm,
        own.horizontal_scale,
        ((width_px - 1) / 2.0, (height_px - 1) / 2.0),
        -4e-4,
        0.0,
    )
    pose = Pose(design.pose.phi_rad, design.pose.sigma_rad, design.pose.translation_mm)
    encoder = EncoderScale(design.encoder.steps_per_rev, 0, 1)
    return Calibration("bench", None, camera, pose, design.lasers, design.floor, encoder, 0.0)


def plain_way(frame: Frame, camera: Camera) -> Floats:
    """Threshold, row centroid, cv2.undistortPoints, ray meets plane: what most open scanners do, vectorised."""
    focal = camera.focal_length_mm / np.array([camera.pixel_pitch_y_mm, camera.pixel_pitch_z_mm])
    matrix = np.array([[focal[0], 0, camera.width_px / 2], [0, focal[1], camera.height_px / 2], [0, 0, 1.0]])
    normal, offset = np.array([0.7, 0.0, 0.7]), 400.0
    lit = np.where(frame > THRESHOLD, frame, 0).astype(np.float32)
    total = lit.sum(1)
    rows = np.nonzero(total)[0]
    u = (lit @ np.arange(frame.shape[1], dtype=np.float32))[rows] / total[rows]
    places = np.column_stack([u, rows]).astype(np.float32)[:, None]
    xy = cv2.undistortPoints(places, matrix, np.array([-0.02, 0.0, 0.0, 0.0, 0.0]))[:, 0]
    rays = np.column_stack([xy, np.ones(len(xy))])
    return np.asarray(rays * (offset / (rays @ normal))[:, None], dtype=np.float64)


def papers_way(frame: Frame, table: LightTable) -> Floats:
    """Every pixel above the threshold through the table."""
    rows, columns = np.nonzero(frame > THRESHOLD)
    return table.xy_light[rows, columns].astype(np.float64)


@dataclass(frozen=True)
class Timing:
    """Minimum and median in milliseconds of three ways, timed in turn on the same frames."""

    size: str
    ours_ms: tuple[float, float]
    plain_ms: tuple[float, float]
    paper_ms: tuple[float, float]

    @property
    def times_as_fast(self) -> float:
        """Median of the plain way over ours."""
        return self.plain_ms[1] / self.ours_ms[1]


def time_sizes(scanner: Scanner, frames: int = 100) -> list[Timing]:
    """Time frame -> stripe -> table look-up, one thread, threshold given, for the three sizes."""
    cv2.setNumThreads(1)
    with threadpool_limits(1):  # the plain way's matrix product would otherwise use all cores
        return [_time_size(machine_of_size(scanner, *size), frames) for size in SIZES]


def _time_size(machine: Calibration, frames: int) -> Timing:
    camera, table, finder = machine.camera, build_table(machine, "right"), StripeFinder()
    lines = [draw_line(camera.width_px, camera.height_px, 10.0, seed).frame for seed in range(4)]
    ways: tuple[Callable[[Frame], Floats], ...] = (
        lambda frame: table.lookup(finder.find(frame, THRESHOLD).uv),
        lambda frame: plain_way(frame, camera),
        lambda frame: papers_way(frame, table),
    )
    ms = np.empty((frames + 3, len(ways)))
    for i in range(len(ms)):
        for k, way in enumerate(ways):
            begin = time.perf_counter()
            way(lines[i % len(lines)])
            ms[i, k] = 1e3 * (time.perf_counter() - begin)
    low, middle = ms[3:].min(axis=0), np.median(ms[3:], axis=0)
    pairs = [(float(a), float(b)) for a, b in zip(low, middle, strict=True)]
    return Timing(f"{camera.width_px}x{camera.height_px}", pairs[0], pairs[1], pairs[2])


@dataclass(frozen=True)
class Accuracy:
    """Errors across a line in one direction."""

    angle_deg: float
    points: int
    rms_px: float
    largest_px: float


def measure_accuracy(angle_deg: float, frames: int = 10) -> Accuracy:
    """Sub-pixel error across a straight line, over several seeds, at 582 x 500."""
    finder = StripeFinder()
    lines = [draw_line(582, 500, angle_deg, seed) for seed in range(frames)]
    error = np.concatenate([line.error_across_px(finder.find(line.frame, THRESHOLD).uv) for line in lines])
    return Accuracy(angle_deg, len(error), float(np.sqrt(np.mean(error**2))), float(np.abs(error).max()))


@dataclass(frozen=True)
class StepResult:
    """At a step of 20 px: error of kept points within 5 rows, rows dropped on a side, points that are on no line."""

    rms_px: float
    share_within_006: float
    largest_px: float
    most_rows_dropped: int
    ghosts: int


def measure_step(frames: int = 50) -> StepResult:
    """How a line that jumps 20 px sideways in the middle of the frame is treated."""
    finder = StripeFinder()
    near: list[Floats] = []
    dropped, ghosts = 0, 0
    for seed in range(frames):
        line = draw_line(582, 500, 0.0, seed, STEP_PX)
        uv = finder.find(line.frame, THRESHOLD).uv
        error = line.error_across_px(uv)
        ghosts += int((np.abs(error) > 1.0).sum())
        near.append(error[np.abs(uv[:, 1] - 249.5) <= 5.5])
        upper = np.abs(uv[:, 0] - line.place[0]) < STEP_PX / 2
        last_upper, first_lower = np.rint(uv[upper, 1].max()), np.rint(uv[~upper, 1].min())
        dropped = max(dropped, int(249 - last_upper), int(first_lower - 250))
    error = np.abs(np.concatenate(near))
    share = float((error <= 0.06).mean())
    return StepResult(float(np.sqrt(np.mean(error**2))), share, float(error.max()), dropped, ghosts)


def time_tables(scanner: Scanner, width_px: int, height_px: int, repeats: int = 15) -> tuple[float, float]:
    """Minimum and median in ms for building both tables of one machine."""
    machine = machine_of_size(scanner, width_px, height_px)
    ms: list[float] = []
    for _ in range(repeats + 1):
        begin = time.perf_counter()
        for laser in LASER_NAMES:
            build_table(machine, laser)
        ms.append(1e3 * (time.perf_counter() - begin))
    return min(ms[1:]), float(np.median(ms[1:]))
