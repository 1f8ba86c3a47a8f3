"""A machine nowhere as designed, its synthetic sightings, and the shared calibration recording, taken in once."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from footscan.calibration.calibrate import Calibrated, Options, calibrate_intake
from footscan.calibration.estimate import sheet_from_angles
from footscan.calibration.intake import Intake, take_in
from footscan.calibration.joint import USUAL, Choices
from footscan.calibration.sightings import StripePoints
from footscan.calibration.stripes import find_stripes
from footscan.calibration.synthetic import Synthetic, SyntheticPlan, make_sightings
from footscan.config import DEFAULT_BOARD, load_calibration
from footscan.geometry.plane import Plane
from footscan.optics import Calibration, Pose
from footscan.scanning.recording import open_recording


@pytest.fixture(scope="session")
def crooked(ideal: Calibration) -> Calibration:
    """The prototype as a workshop may build it."""
    pose = ideal.pose
    t_x, t_y, t_z = pose.translation_mm
    right, left = ideal.lasers
    lean = np.array([2e-4, -3e-4, 1.0]) / np.linalg.norm([2e-4, -3e-4, 1.0])
    return replace(
        ideal,
        camera=replace(
            ideal.camera, focal_length_mm=8.02, principal_point_px=(293.0, 246.5), k1_per_mm2=-8e-4, k2_per_mm4=0.0
        ),
        pose=Pose(pose.phi_rad + 0.006, pose.sigma_rad + 0.002, (t_x + 3.0, t_y + 1.0, t_z - 2.0)),
        lasers=(
            sheet_from_angles(right, np.deg2rad(45.4), np.deg2rad(0.1), 0.3),
            sheet_from_angles(left, np.deg2rad(-44.7), np.deg2rad(-0.12), -0.4),
        ),
        floor=Plane((float(lean[0]), float(lean[1]), float(lean[2])), 0.0),
        latency_s=0.013,
    )


@pytest.fixture(scope="session")
def synthetic(crooked: Calibration) -> Synthetic:
    return make_sightings(crooked, DEFAULT_BOARD, SyntheticPlan(seed=5))


@dataclass(frozen=True)
class Shared:
    """The shared calibration recording: what its frames show, its stripes, and the exact machine."""

    folder: Path
    intake: Intake
    stripes: StripePoints
    truth: Calibration


@pytest.fixture(scope="session")
def shared(shared_dir: Path) -> Shared:
    folder = shared_dir / "data" / "recordings" / "calibration-workshop"
    intake = take_in(open_recording(folder))
    return Shared(folder, intake, find_stripes(intake), load_calibration(folder / "truth-calibration.toml"))


Calibrate = Callable[..., Calibrated]


@pytest.fixture
def calibrate_seen(shared: Shared) -> Calibrate:
    """Calibrate from what the frames showed, changed at will, without looking at the frames again."""

    def run(intake: Intake | None = None, stripes: StripePoints | None = None, choices: Choices = USUAL) -> Calibrated:
        return calibrate_intake(intake or shared.intake, stripes or shared.stripes, Options(choices))

    return run
