"""A whole simulated calibration: a printed board at several placements, the head at many stops, both lasers.

At every stop one frame without light, one with either laser; then the same without a board (`empty`); at the end two
moving sweeps past the first placement, unlit, which show how late frames are stamped.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from footscan.config import Board, RecordingInfo, board_toml, save_calibration, scanner_toml
from footscan.config.toml_file import write_whole
from footscan.coordinates import WORKING_RADIUS_MM, WORKING_Z_MM, Floats, Frame, Ints
from footscan.errors import InputError
from footscan.geometry.rigid import rotation_z
from footscan.scanning.recorder import RecordingWriter
from footscan.scanning.recording import FrameLaser, FrameSweep
from footscan.sim.board import DEFAULT_BOARD, DEFAULT_PAPER, NO_FAULTS, Paper, Placement, PrintedBoard, PrintFaults
from footscan.sim.machine import TrueMachine
from footscan.sim.motion import HeadMotion, SweepPlan, count_from_theta, speed_profile
from footscan.sim.picture import DEFAULT_PICTURE, Painter, PictureSettings
from footscan.sim.record import make_folder
from footscan.sim.surface import Surface

CALIBRATION_PICTURE = replace(DEFAULT_PICTURE, ambient_board_grey=13.0, read_noise_grey=1.3, electrons_per_grey=35.0)
"""The room is lit, so that the print can be seen; grey values and noise are those of a recording by another tracer."""

EMPTY = "empty"
LASERS: tuple[FrameLaser, ...] = ("none", "right", "left")
_ABOVE_BOARD_MM = 2.0
_FRAME_STEP_S = 0.2
_ENCODER_AT_REST_S = 0.02


def _placement(x: float, y: float, z: float, azimuth: float, elevation: float, roll: float) -> Placement:
    return Placement((x, y, z), *(float(np.deg2rad(angle)) for angle in (azimuth, elevation, roll)))


PLACEMENTS = (
    _placement(15.0, 0.0, 92.0, 0.0, 12.0, 0.0),
    _placement(-10.0, 25.0, 80.0, 95.0, 48.0, 8.0),
    _placement(0.0, -20.0, 92.0, 185.0, 25.0, -6.0),
    _placement(10.0, 10.0, 72.0, 275.0, 62.0, 4.0),
    _placement(70.0, 25.0, 112.0, 40.0, -6.0, 12.0),
    _placement(-40.0, -45.0, 86.0, 225.0, 38.0, -10.0),
)
"""Centres (mm), headings, elevations and rolls (degrees above, radians inside)."""


@dataclass(frozen=True)
class MovedBoard:
    """A board that slips between two stops.

    Attributes:
        setup: Number of the placement.
        from_stop: First stop that sees it at its new place.
        shift_mm: In the world.
        turn_rad: About the vertical through its middle.
    """

    setup: int
    from_stop: int
    shift_mm: tuple[float, float, float] = (1.0, 0.0, 0.0)
    turn_rad: float = 0.0


@dataclass(frozen=True)
class CalibrationPlan:
    """What is recorded, and what is wrong with the board.

    Attributes:
        placements: Of the board, one after the other.
        stops: Of the head, evenly spread over the turn.
        first_stop_rad: Head angle of the first one.
        sweep_rad: The moving sweeps go this far to either side of the heading of the first placement.
        sweep_frames: Frames of each of the two; 0 leaves them out.
        sweep_frames_per_s: Of the camera, while the head moves.
        scatter: How far seeded chance moves the placements: 1 is some millimetres and degrees, 0 not at all.
        board: The pattern as intended.
        paper: Its brightness.
        faults: What is wrong with it.
        moved: A board that slips, if any.
    """

    placements: tuple[Placement, ...] = PLACEMENTS
    stops: int = 24
    first_stop_rad: float = float(np.deg2rad(3.0))
    sweep_rad: float = float(np.deg2rad(50.0))
    sweep_frames: int = 40
    sweep_frames_per_s: float = 10.0
    scatter: float = 1.0
    board: Board = DEFAULT_BOARD
    paper: Paper = DEFAULT_PAPER
    faults: PrintFaults = NO_FAULTS
    moved: MovedBoard | None = None


DEFAULT_CALIBRATION_PLAN = CalibrationPlan()


@dataclass(frozen=True)
class CalibrationFrame:
    """One frame to take: when, where the head is, what is lit, and the board that stands there (None: no board)."""

    exposure_s: float
    theta_rad: float
    laser: FrameLaser
    sweep: FrameSweep
    setup: str
    board: PrintedBoard | None


@dataclass(frozen=True)
class SimulatedCalibration:
    """A calibration recording about to happen: the frames, and the encoder's samples `(n,)` (s, counts)."""

    machine: TrueMachine
    plan: CalibrationPlan
    picture: PictureSettings
    seed: int
    schedule: tuple[CalibrationFrame, ...]
    encoder_time_s: Floats
    encoder_count: Ints

    def frames(self) -> Iterator[tuple[CalibrationFrame, Frame]]:
        """Take the frames, one at a time."""
        painter, stands = self._painter(None), None
        for number, job in enumerate(self.schedule):
            if job.board is not stands:
                painter, stands = self._painter(job.board), job.board
            yield job, painter.paint(job.theta_rad, None if job.laser == "none" else job.laser, number)

    def _painter(self, board: PrintedBoard | None) -> Painter:
        calibration = self.machine.calibration
        if board is None:
            nothing = Surface(np.empty((0, 3)), np.empty((0, 3), dtype=np.int64))
            return Painter(calibration, nothing, self.picture, self.seed)
        return Painter.of_board(calibration, board, self.picture, self.seed)


def prepare_calibration(
    machine: TrueMachine,
    plan: CalibrationPlan = DEFAULT_CALIBRATION_PLAN,
    picture: PictureSettings = CALIBRATION_PICTURE,
    seed: int = 0,
) -> SimulatedCalibration:
    """Set up a calibration recording.

    Raises:
        InputError: A plan without frames, a board that the machine cannot hold, a slip of a board that is not there.
    """
    _check(plan)
    random = np.random.default_rng([seed, 0xB0A2D])
    boards = [_stand(_scattered(place, plan.scatter, random), plan) for place in plan.placements]
    static = _static_frames(boards, plan, random)
    moving, motion = _moving_frames(boards[0], plan, static[-1].exposure_s + 1.0, seed)
    rest_s = np.array([job.exposure_s for job in static])
    at_rest = np.column_stack([rest_s - _ENCODER_AT_REST_S, rest_s + _ENCODER_AT_REST_S]).ravel()
    time_s, theta = at_rest, np.repeat([job.theta_rad for job in static], 2)
    if motion is not None:
        turning_s = np.arange(motion.time_s[0], motion.time_s[-1], 1.0 / SweepPlan().encoder_hz)
        time_s = np.concatenate([time_s, turning_s])
        theta = np.concatenate([theta, motion.theta_at(turning_s)])
    count = count_from_theta(theta, machine.calibration.encoder)
    return SimulatedCalibration(machine, plan, picture, seed, (*static, *moving), time_s, count)


def simulate_calibration(
    folder: Path,
    calibration: SimulatedCalibration,
    notes: str = "",
    created: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write a calibration recording, with `truth-calibration.toml` and `truth-board.json` beside the frames.

    Raises:
        RecordingError: The folder already holds a recording.
        StorageError: The folder cannot be written.
    """
    created = created or datetime.now(UTC).isoformat(timespec="seconds")
    info, machine = RecordingInfo("calibration", "none", created, notes), calibration.machine
    make_folder(folder)
    with RecordingWriter(folder, info, scanner_toml(machine.scanner)) as writer:
        write_whole(folder / "board.toml", board_toml(calibration.plan.board))
        writer.add_counts(calibration.encoder_time_s, calibration.encoder_count)
        for done, (job, frame) in enumerate(calibration.frames(), start=1):
            stamp_s = job.exposure_s + machine.calibration.latency_s
            writer.add_frame(frame, stamp_s, job.laser, job.sweep, job.setup)
            if progress is not None:
                progress(done, len(calibration.schedule))
    save_calibration(replace(machine.calibration, created=created), folder / "truth-calibration.toml")
    write_whole(folder / "truth-board.json", json.dumps(_truth(calibration), indent=1).encode())


def _check(plan: CalibrationPlan) -> None:
    if not plan.placements or plan.stops < 1 or plan.sweep_frames < 0:
        raise InputError(
            f"a calibration has at least 1 placement and 1 stop, found {len(plan.placements)} and {plan.stops}."
        )
    if plan.moved is not None and not 0 <= plan.moved.setup < len(plan.placements):
        raise InputError(
            f"the board slips at placement {plan.moved.setup}, but there are placements 0 to "
            f"{len(plan.placements) - 1}; choose one of them."
        )


def stand_board(setup: int, scatter: float = 1.0, seed: int = 0) -> PrintedBoard:
    """The default board as a technician puts it down: the placements of the default plan, again and again."""
    random = np.random.default_rng([seed, setup, 0xB0A2D])
    return _stand(_scattered(PLACEMENTS[setup % len(PLACEMENTS)], scatter, random), DEFAULT_CALIBRATION_PLAN)


def _scattered(place: Placement, scatter: float, random: np.random.Generator) -> Placement:
    shift, turn = random.uniform(-4.0, 4.0, 3) * scatter, np.deg2rad(random.uniform(-2.0, 2.0, 3)) * scatter
    x, y, z = np.array(place.centre_world) + shift
    angles = np.array([place.azimuth_rad, place.elevation_rad, place.roll_rad]) + turn
    return Placement((float(x), float(y), float(z)), *(float(angle) for angle in angles))


def _stand(place: Placement, plan: CalibrationPlan) -> PrintedBoard:
    """The board at a placement, lifted where it would reach into the footboard."""
    board = PrintedBoard(plan.board, np.eye(4), plan.faults, plan.paper)
    pose = place.world_from_board(board.size_mm)
    board = replace(board, world_from_board=pose)
    lift = max(0.0, _ABOVE_BOARD_MM - float(board.surface.xyz_world[:, 2].min()))
    board = replace(board, world_from_board=_shifted(pose, (0.0, 0.0, lift)))
    xyz_world = board.surface.xyz_world
    reach, top = float(np.hypot(xyz_world[:, 0], xyz_world[:, 1]).max()), float(xyz_world[:, 2].max())
    if reach > WORKING_RADIUS_MM or top > WORKING_Z_MM[1]:
        width, height = board.size_mm
        raise InputError(
            f"a board of {width:.0f} x {height:.0f} mm reaches {reach:.0f} mm from the axis and {top:.0f} mm up; the "
            f"machine sees {WORKING_RADIUS_MM:.0f} and {WORKING_Z_MM[1]:.0f} mm: choose a smaller board."
        )
    return board


def _shifted(transform: Floats, shift_mm: tuple[float, float, float]) -> Floats:
    result = transform.copy()
    result[:3, 3] += shift_mm
    return result


def _slipped(board: PrintedBoard, moved: MovedBoard) -> PrintedBoard:
    pose = board.world_from_board.copy()
    middle = pose[:3, :3] @ np.array([0.5 * board.size_mm[0], 0.5 * board.size_mm[1], 0.0]) + pose[:3, 3]
    turn = rotation_z(moved.turn_rad)
    pose[:3, 3] = turn @ (pose[:3, 3] - middle) + middle
    pose[:3, :3] = turn @ pose[:3, :3]
    return replace(board, world_from_board=_shifted(pose, moved.shift_mm))


def _static_frames(
    boards: list[PrintedBoard], plan: CalibrationPlan, random: np.random.Generator
) -> list[CalibrationFrame]:
    stop_rad = plan.first_stop_rad + np.arange(plan.stops) * (2.0 * np.pi / plan.stops)
    jobs: list[CalibrationFrame] = []
    for setup, board in [*((str(k), board) for k, board in enumerate(boards)), (EMPTY, None)]:
        moved = plan.moved if plan.moved is not None and setup == str(plan.moved.setup) else None
        slipped = _slipped(board, moved) if moved is not None and board is not None else board
        for stop, theta in enumerate(stop_rad + np.deg2rad(random.uniform(-0.1, 0.1, plan.stops))):
            here = slipped if moved is not None and stop >= moved.from_stop else board
            for laser in LASERS:
                moment = len(jobs) * _FRAME_STEP_S
                jobs.append(CalibrationFrame(moment, float(theta), laser, "static", setup, here))
    return jobs


def _moving_frames(
    board: PrintedBoard, plan: CalibrationPlan, start_s: float, seed: int
) -> tuple[list[CalibrationFrame], HeadMotion | None]:
    """Two unlit sweeps past a board, there and back, and the head's way through them."""
    if plan.sweep_frames == 0:
        return [], None
    sweep = SweepPlan(plan.sweep_frames, plan.sweep_frames_per_s)
    turn_s = plan.sweep_frames / plan.sweep_frames_per_s
    each_s = turn_s + 2.0 * sweep.ramp_s + sweep.pause_s
    random = np.random.default_rng([seed, 0x5EE9])
    time_s: Floats = np.arange(-sweep.ramp_s - 0.2, 2.0 * each_s, 0.001)
    speed, rate = 2.0 * plan.sweep_rad / turn_s, np.zeros(len(time_s))
    exposures: list[Floats] = []
    for number, sign in enumerate((1.0, -1.0)):
        rate += sign * speed * speed_profile(time_s - number * each_s, turn_s, sweep, random)
        exposures.append(
            number * each_s + (np.arange(plan.sweep_frames, dtype=np.float64) + 0.5) / plan.sweep_frames_per_s
        )
    way = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1])) * 0.001])
    towards = -board.world_from_board[:3, 2]
    heading = float(np.arctan2(towards[1], towards[0]))
    theta = heading - plan.sweep_rad + way - float(np.interp(0.0, time_s, way))
    motion = HeadMotion(time_s + start_s, theta, tuple(moments + start_s for moments in exposures))
    names: tuple[FrameSweep, FrameSweep] = ("ccw", "cw")
    return [
        CalibrationFrame(float(moment), float(angle), "none", name, "0", board)
        for name, moments in zip(names, motion.exposure_s, strict=True)
        for moment, angle in zip(moments, motion.theta_at(moments), strict=True)
    ], motion


def _truth(calibration: SimulatedCalibration) -> dict[str, object]:
    poses: dict[str, list[dict[str, object]]] = {}
    for number, job in enumerate(calibration.schedule):
        if job.board is None:
            continue
        known = poses.setdefault(job.setup, [])
        pose = job.board.world_from_board.tolist()
        if not known or known[-1]["world_from_board"] != pose:
            known.append({"from_frame": number, "world_from_board": pose})
    plan = calibration.plan
    return {
        "format": "footscan-board-truth/1",
        "poses": poses,
        "faults": asdict(plan.faults),
        "moved": asdict(plan.moved) if plan.moved is not None else None,
        "margin_mm": plan.paper.margin_mm,
        "theta_rad": [job.theta_rad for job in calibration.schedule],
    }
