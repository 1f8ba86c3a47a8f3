"""Sightings computed from a known machine, without pictures: for studies and for tests of the estimate itself."""

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from footscan.calibration.charuco import corners_mm, half_size_mm
from footscan.calibration.estimate import Estimate, start_estimate
from footscan.calibration.intake import EMPTY, Intake
from footscan.calibration.sightings import FLOOR_PLACEMENT, Corners, FrameTimes, Sightings, StripePoints
from footscan.config import Board, RecordingInfo
from footscan.coordinates import LASER_NAMES, Floats, Ints
from footscan.geometry.rigid import inverse_rigid, rigid
from footscan.optics import Calibration
from footscan.optics.calibration import camera_from_world, optical_centre_world, theta_from_encoder
from footscan.optics.camera import pixel_from_camera
from footscan.optics.scanner import Scanner
from footscan.scanning.recording import EncoderTrack, FrameRecord, Recording

_STOP_S = 1.0
_SWEEP_COUNTS_PER_S = 600.0
_LEAST_FACING = 0.25


@dataclass(frozen=True)
class SyntheticPlan:
    """What is seen, and how well.

    Attributes:
        placements: Boards, differently headed and leaning.
        stops: Stops of the head in a turn.
        sweep_frames: Frames on the move past the first board; 0 leaves the latency unknown.
        stripe_step_mm: Distance of stripe places on a board; on the footboard four times that.
        corner_noise_px: Standard deviation of corners, along rows and columns.
        stripe_noise_px: The same of stripe places.
        seed: Of the noise.
    """

    placements: int = 6
    stops: int = 24
    sweep_frames: int = 40
    stripe_step_mm: float = 1.0
    corner_noise_px: float = 0.03
    stripe_noise_px: float = 0.06
    seed: int = 0


@dataclass(frozen=True)
class Synthetic:
    """Sightings with the estimate that is exactly true of them."""

    sightings: Sightings
    truth: Estimate


def make_sightings(machine: Calibration, board: Board, plan: SyntheticPlan) -> Synthetic:
    """Everything a camera would see of boards, stripes and footboard, with noise."""
    truth = start_estimate(machine, np.stack([_place_board(p, plan.placements) for p in range(plan.placements)]))
    times = _times(machine, plan)
    random = np.random.default_rng([plan.seed, 0xCA1B])
    theta_rad = theta_from_encoder(times.counts(machine.latency_s), machine.encoder)
    corners = _see_corners(truth, board, plan, times, theta_rad)
    corners = replace(
        corners, yz_pixel=corners.yz_pixel + plan.corner_noise_px * random.standard_normal((len(corners), 2))
    )
    stripes = _see_stripes(truth, board, plan, theta_rad)
    stripes = replace(
        stripes, yz_pixel=stripes.yz_pixel + plan.stripe_noise_px * random.standard_normal((len(stripes), 2))
    )
    names = tuple(str(p) for p in range(plan.placements))
    return Synthetic(Sightings(times, corners, stripes, names), truth)


def make_intake(machine: Calibration, scanner: Scanner, board: Board, plan: SyntheticPlan) -> tuple[Intake, Synthetic]:
    """The same as if frames had been taken and looked at; stripes are those of the sightings."""
    made = make_sightings(machine, board, plan)
    info = RecordingInfo("calibration", "none", "2000-01-01T00:00:00+00:00", "synthetic")
    names = made.sightings.placement_names
    times = made.sightings.times
    records = tuple(_record(k, float(t), plan, names) for k, t in enumerate(times.time_s))
    recording = Recording(Path(), info, scanner, records, times.track, board)
    intake = Intake(recording, board, names, times, made.sightings.corners, (), Counter(), ())
    return intake, made


def _record(number: int, time_s: float, plan: SyntheticPlan, names: tuple[str, ...]) -> FrameRecord:
    setup = number // plan.stops
    moving = setup > plan.placements
    name = names[0] if moving else EMPTY if setup == plan.placements else names[setup]
    return FrameRecord(number, f"frames/{number:06}.png", time_s, "none", "ccw" if moving else "static", name)


def _place_board(number: int, of: int) -> Floats:
    """A board around the axis: headed all ways, leaning and rolled by different amounts, at different heights."""
    heading = 2.0 * np.pi * number / of
    lean, roll = np.deg2rad([0.0, 28.0, -20.0, 35.0, 12.0, -30.0][number % 6]), np.deg2rad(7.0 * ((number * 5) % 7 - 3))
    upright = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # seen from +x: x to the right, y down
    turn = Rotation.from_euler("ZYX", [heading, lean, roll]).as_matrix() @ upright
    middle = np.array([20.0 * np.cos(1.7 * number), 20.0 * np.sin(1.7 * number), 62.0 + 6.0 * (number % 4)])
    return rigid(turn, middle)


def _times(machine: Calibration, plan: SyntheticPlan) -> FrameTimes:
    """A frame per placement and stop (also of the bare footboard), then a sweep to and fro past the first board."""
    steps, zero = machine.encoder.steps_per_rev, machine.encoder.zero_count
    stop_counts = zero + np.arange(plan.stops) * steps / plan.stops
    counts = np.tile(np.round(stop_counts), plan.placements + 1)
    time_s = _STOP_S * np.arange(len(counts), dtype=np.float64)
    around = np.repeat(time_s, 2) + np.tile([-0.3, 0.3], len(time_s))
    begin = float(time_s[-1]) + 5.0
    moving_s = begin + 0.1 * np.arange(plan.sweep_frames, dtype=np.float64)
    sweep_s = np.arange(begin - 0.5, begin + 0.1 * plan.sweep_frames + 0.5, 0.02)
    half = 0.05 * plan.sweep_frames
    swept = zero + _SWEEP_COUNTS_PER_S * (half - np.abs(sweep_s - begin - half)) - 0.5 * half * _SWEEP_COUNTS_PER_S
    track = EncoderTrack(np.concatenate([around, sweep_s]), np.concatenate([np.repeat(counts, 2), swept]))
    moving = np.concatenate([np.zeros(len(time_s), dtype=bool), np.ones(plan.sweep_frames, dtype=bool)])
    return FrameTimes(np.concatenate([time_s, moving_s]), moving, track)


def _project(machine: Calibration, xyz_world: Floats, theta_rad: float) -> tuple[Floats, np.ndarray]:
    """Pixels in F, and which of them lie inside the picture."""
    camera, transform = machine.camera, camera_from_world(machine, theta_rad)
    yz_pixel = pixel_from_camera(xyz_world @ transform[:3, :3].T + transform[:3, 3], camera)
    size = np.array([camera.width_px - 1, camera.height_px - 1])
    return yz_pixel, np.all((yz_pixel >= 0.0) & (yz_pixel <= size), axis=1)


def _faces(truth: Estimate, placement: int, theta_rad: float) -> bool:
    """Whether the camera sees the front of a board, not too edge-on."""
    pose = truth.world_from_board[placement]
    sight = optical_centre_world(truth.machine, theta_rad) - pose[:3, 3]
    return float(-pose[:3, 2] @ sight) > _LEAST_FACING * float(np.linalg.norm(sight))


def _frames_of(plan: SyntheticPlan, placement: int) -> Ints:
    stops = np.arange(plan.stops) + placement * plan.stops
    first_moving = (plan.placements + 1) * plan.stops
    sweep = np.arange(plan.sweep_frames) + first_moving if placement == 0 else np.zeros(0, dtype=np.int64)
    return np.concatenate([stops, sweep]).astype(np.int64)


def _see_corners(truth: Estimate, board: Board, plan: SyntheticPlan, times: FrameTimes, theta_rad: Floats) -> Corners:
    xy_board = corners_mm(board)
    parts: list[tuple[int, int, Floats, Floats]] = []
    for placement in range(plan.placements):
        pose = truth.world_from_board[placement]
        xyz_world = np.column_stack([xy_board, np.zeros(len(xy_board))]) @ pose[:3, :3].T + pose[:3, 3]
        for frame in _frames_of(plan, placement):
            if _faces(truth, placement, float(theta_rad[frame])):
                yz_pixel, inside = _project(truth.machine, xyz_world, float(theta_rad[frame]))
                parts.append((int(frame), placement, xy_board[inside], yz_pixel[inside]))
    count = [len(part[2]) for part in parts]
    frame = np.repeat([part[0] for part in parts], count).astype(np.int64)
    return Corners(
        frame,
        np.repeat([part[1] for part in parts], count).astype(np.int64),
        np.concatenate([part[2] for part in parts]),
        np.concatenate([part[3] for part in parts]),
        times.moving[frame],
    )


def _see_stripes(truth: Estimate, board: Board, plan: SyntheticPlan, theta_rad: Floats) -> StripePoints:
    parts: list[tuple[int, int, int, Floats]] = []
    for placement in (*range(plan.placements), FLOOR_PLACEMENT):
        for stop in range(plan.stops):
            frame = stop + (placement if placement >= 0 else plan.placements) * plan.stops
            for code in range(len(LASER_NAMES)):
                seen = _see_stripe(truth, board, plan, placement, code, float(theta_rad[frame]))
                parts += [(frame, placement, code, seen)] if len(seen) else []
    count = [len(part[3]) for part in parts]
    keys = np.array([part[:3] for part in parts], dtype=np.int64)
    frame, placement, laser = np.repeat(keys, count, axis=0).T
    return StripePoints(frame, placement, laser, np.concatenate([p[3] for p in parts]), np.ones(len(frame), dtype=bool))


def _see_stripe(
    truth: Estimate, board: Board, plan: SyntheticPlan, placement: int, code: int, theta_rad: float
) -> Floats:
    """Pixels of the line in which a sheet crosses a board's front or the footboard."""
    machine, sheet = truth.machine, truth.machine.lasers[code]
    c, s = np.cos(theta_rad), np.sin(theta_rad)
    n_x, n_y, n_z = sheet.normal
    normal = np.array([c * n_x - s * n_y, s * n_x + c * n_y, n_z])
    if placement == FLOOR_PLACEMENT:
        pose, half, step = _floor_pose(machine), np.array([150.0, 150.0]), 4.0 * plan.stripe_step_mm
    else:
        if not _faces(truth, placement, theta_rad):
            return np.zeros((0, 2))
        pose, half, step = truth.world_from_board[placement], half_size_mm(board), plan.stripe_step_mm
    in_board = inverse_rigid(pose)[:3, :3] @ normal
    offset = sheet.offset_mm - float(normal @ pose[:3, 3])
    length = float(np.hypot(in_board[0], in_board[1]))
    if length < 0.05:
        return np.zeros((0, 2))
    across = in_board[:2] / length
    reach = np.arange(-250.0, 250.0, step)[:, None] * np.array([-across[1], across[0]]) + across * offset / length
    xy = reach[np.all(np.abs(reach) < half, axis=1)]
    xyz_world = np.column_stack([xy, np.zeros(len(xy))]) @ pose[:3, :3].T + pose[:3, 3]
    if not len(xy):
        return np.zeros((0, 2))
    yz_pixel, inside = _project(machine, xyz_world, theta_rad)
    return yz_pixel[inside]


def _floor_pose(machine: Calibration) -> Floats:
    up = machine.floor.normal_array
    x = np.array([up[2], 0.0, -up[0]]) / np.hypot(up[0], up[2])
    y = np.array([up[1] * x[2] - up[2] * x[1], up[2] * x[0] - up[0] * x[2], up[0] * x[1] - up[1] * x[0]])
    return rigid(np.stack([x, y, up], axis=1), machine.floor.offset_mm * up)
