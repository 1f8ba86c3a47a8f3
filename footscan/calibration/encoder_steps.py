"""How many counts a turn of the head really has: how far boards turn in the camera's eye between two stops."""

from itertools import combinations

import numpy as np
from scipy.spatial.transform import Rotation

from footscan.calibration.first_guess import camera_from_board_poses
from footscan.calibration.intake import Intake
from footscan.coordinates import Floats
from footscan.optics import Calibration
from footscan.optics.scanner import calibration_from_design

_FEWEST_CORNERS = 8
_LEAST_TURN_RAD = float(np.deg2rad(20.0))
_FEWEST_PAIRS = 6


def counts_per_turn(intake: Intake) -> float | None:
    """Counts of one turn as the pictures show it, to a tenth of a percent or so, whatever scanner.toml says.

    A board that stands still turns in the camera's eye by as much as the head does between two stops; lens and head
    need only be near their design for that.

    Returns:
        Counts, the median over pairs of stops; None where too few stops see a board well.
    """
    machine = calibration_from_design(intake.recording.scanner)
    ratios = [pair for p in range(len(intake.placement_names)) for pair in _ratios(intake, machine, p)]
    return 2.0 * np.pi * float(np.median(ratios)) if len(ratios) >= _FEWEST_PAIRS else None


def _ratios(intake: Intake, machine: Calibration, placement: int) -> list[float]:
    """Counts per radian of each pair of stops that see this placement."""
    counts = intake.times.counts(0.0)
    turns = _turns(intake, machine, placement)
    ratios: list[float] = []
    for one, other in combinations(turns, 2):
        turned_rad = float((Rotation.from_matrix(turns[one]) * Rotation.from_matrix(turns[other]).inv()).magnitude())
        if turned_rad > _LEAST_TURN_RAD:
            ratios.append(abs(float(counts[one] - counts[other])) / turned_rad)
    return ratios


def _turns(intake: Intake, machine: Calibration, placement: int) -> dict[int, Floats]:
    """By frame, how the board is turned in the camera's eye (3x3): the better of OpenCV's two poses."""
    corners = intake.corners
    own = corners.kept((corners.placement == placement) & ~corners.moving)
    frames, number = np.unique(own.frame, return_counts=True)
    seen = [int(frame) for frame, n in zip(frames, number, strict=True) if n >= _FEWEST_CORNERS]
    return {frame: camera_from_board_poses(machine, own.kept(own.frame == frame))[0][:3, :3] for frame in seen}
