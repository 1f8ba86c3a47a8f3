"""A calibration recording becomes a calibration, or a refusal with its reason."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from footscan.calibration.board_shape import BoardShape, board_shape, shape_gates
from footscan.calibration.design_gates import design_gates
from footscan.calibration.doubts import explain_corners, explain_jump
from footscan.calibration.gate import Gate, Reason
from footscan.calibration.gates import LIMITS, Limits, corner_gates, joint_gates
from footscan.calibration.holdout import HoldOut, hold_out_each
from footscan.calibration.intake import Intake, Progress, take_in
from footscan.calibration.joint import USUAL, Choices, JointFit, fit_corners, fit_jointly
from footscan.calibration.mislabelled import explain_stripes
from footscan.calibration.picture_jumps import jump_gate, picture_jumps
from footscan.calibration.sightings import StripePoints
from footscan.calibration.stripes import find_stripes
from footscan.config import Board
from footscan.optics import Calibration
from footscan.scanning.recording import Recording

Say = Callable[[str], None]


def _quiet(done: int, total: int) -> None:
    """Nobody looks."""


@dataclass(frozen=True)
class Options:
    """How to calibrate.

    Attributes:
        choices: What to estimate beyond the usual.
        limits: What the gates allow.
        progress: Called with frames done and in all.
        created: When (RFC 3339), for the file.
    """

    choices: Choices = USUAL
    limits: Limits = LIMITS
    progress: Progress = _quiet
    created: str = ""


USUAL_OPTIONS = Options()


@dataclass(frozen=True)
class Calibrated:
    """An accepted calibration and everything it rests on.

    Attributes:
        calibration: The machine as measured.
        intake: What the recording showed.
        joint: The joint fit.
        holdouts: Every placement predicted by a fit that never saw it.
        shape: The board as the pictures show it.
        gates: All gates, every one passed.
        seconds: Time per stage.
    """

    calibration: Calibration
    intake: Intake
    joint: JointFit
    holdouts: list[HoldOut]
    shape: BoardShape
    gates: list[Gate]
    seconds: dict[str, float]


def calibrate_recording(
    recording: Recording, board: Board | None = None, options: Options = USUAL_OPTIONS
) -> Calibrated:
    """Find the machine that made a recording.

    Args:
        recording: A calibration recording.
        board: The board with measured lengths; default: the recording's own.
        options: How.

    Raises:
        RecordingError: The recording is incomplete or shows no board; the reason is named (exit status 2).
        PoorFitError: A gate refused the result; the reason and the placement are named (exit status 4).
    """
    begin = time.perf_counter()
    intake = take_in(recording, board, options.progress)
    seconds = {"corners": round(time.perf_counter() - begin, 2)}
    result = calibrate_intake(intake, None, options)
    return replace(result, seconds=seconds | result.seconds)


def calibrate_intake(
    intake: Intake,
    stripes: StripePoints | None = None,
    options: Options = USUAL_OPTIONS,
) -> Calibrated:
    """Find the machine that made what a recording shows.

    Args:
        intake: Corners and pairs of frames.
        stripes: Stripe places of the lit frames, where they are known already; default: found in the frames.
        options: How.

    Raises:
        PoorFitError: A gate refused the result; the reason and the placement are named (exit status 4).
    """
    choices, limits = options.choices, options.limits
    clock = _Clock()
    corners_fit = fit_corners(intake)
    names = intake.placement_names
    if not all(gate.passed for gate in corner_gates(corners_fit, names, limits)):
        raise explain_corners(intake, corners_fit, limits).refusal()
    shape = board_shape(intake, corners_fit)
    jumps, free = picture_jumps(intake, corners_fit)
    jump = jump_gate(jumps, names)
    early = [*shape_gates(shape, names)[1 if choices.horizontal_scale else 0 :], jump]
    _pass(early[:-1])
    if not jump.passed:
        raise explain_jump(intake, corners_fit, free, jump).refusal()
    clock.mark("corners alone")
    raw = find_stripes(intake, options.progress) if stripes is None else stripes
    clock.mark("stripes")
    joint = fit_jointly(intake, raw, corners_fit, choices)
    clock.mark("joint fit")
    _pass(design_gates(joint.fit.estimate.machine, intake.recording.scanner))
    reason = explain_stripes(joint, limits)
    if reason:
        raise Reason(reason).refusal()
    holdouts = hold_out_each(joint)
    gates = [*early, *joint_gates(joint, holdouts, limits)]
    _pass(gates)
    clock.mark("hold-out and gates")
    calibration = replace(joint.fit.estimate.machine, created=options.created)
    return Calibrated(calibration, intake, joint, holdouts, shape, gates, clock.seconds)


def _pass(gates: list[Gate]) -> None:
    """Refuse with the first gate that fails."""
    for gate in gates:
        if not gate.passed:
            raise gate.reason().refusal()


class _Clock:
    """Seconds per stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def mark(self, name: str) -> None:
        """What passed since the last mark belongs to this stage."""
        now = time.perf_counter()
        self.seconds[name] = round(now - self._last, 2)
        self._last = now
