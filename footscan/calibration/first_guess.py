"""First guess: the machine as designed, and per placement the pose that OpenCV finds in its clearest frame."""

import cv2
import numpy as np

from footscan.calibration.estimate import Estimate, start_estimate
from footscan.calibration.intake import Intake
from footscan.calibration.misfit import corner_misfit_px, head_angles
from footscan.calibration.sightings import NO_STRIPES, Corners, Sightings
from footscan.coordinates import Floats
from footscan.geometry.rigid import inverse_rigid, rigid
from footscan.optics import Calibration
from footscan.optics.calibration import camera_from_world
from footscan.optics.camera import image_from_pixel, undistorted_from_distorted
from footscan.optics.scanner import calibration_from_design

_CANDIDATES = 5
CAMERA_FROM_OPENCV = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""OpenCV's camera looks along z, with x to the right and y down; ours looks along x, with y to the left and z up."""


def guess_estimate(intake: Intake, machine: Calibration | None = None) -> Estimate:
    """A machine (default: as designed) with all boards where OpenCV's planar pose puts them."""
    machine = machine or calibration_from_design(intake.recording.scanner)
    sightings = Sightings(intake.times, intake.corners, NO_STRIPES, intake.placement_names)
    poses = [_guess_board(machine, sightings.only(p), p) for p in range(len(intake.placement_names))]
    return start_estimate(machine, np.stack(poses))


def _guess_board(machine: Calibration, own: Sightings, placement: int) -> Floats:
    """Of the poses from the frames with most corners, the one under which all frames of the placement fit best."""
    corners = own.corners.kept(~own.corners.moving)
    theta_rad = head_angles(start_estimate(machine, np.eye(4)[None]), own)
    frames, count = np.unique(corners.frame, return_counts=True)
    clearest = frames[np.argsort(-count, kind="stable")][:_CANDIDATES]
    candidates = [
        inverse_rigid(camera_from_world(machine, float(theta_rad[frame]))) @ camera_from_board
        for frame in clearest
        for camera_from_board in camera_from_board_poses(machine, corners.kept(corners.frame == frame))
    ]
    return min(candidates, key=lambda pose: _median_misfit_px(machine, pose, corners, placement, theta_rad))


def _median_misfit_px(machine: Calibration, pose: Floats, corners: Corners, placement: int, theta_rad: Floats) -> float:
    estimate = start_estimate(machine, np.repeat(pose[None], placement + 1, axis=0))
    misfit = np.hypot(*corner_misfit_px(estimate, corners, theta_rad).T)
    return float(np.median(np.where(np.isfinite(misfit), misfit, np.inf)))


def camera_from_board_poses(machine: Calibration, corners: Corners) -> list[Floats]:
    """Both 4x4 poses under which a plane may show these corners in one frame (OpenCV's IPPE)."""
    camera = machine.camera
    undistorted = undistorted_from_distorted(image_from_pixel(corners.yz_pixel, camera), camera)
    xyz_board = np.column_stack([corners.xy_board, np.zeros(len(corners))])
    _, turns, shifts, _ = cv2.solvePnPGeneric(
        xyz_board, undistorted / camera.focal_length_mm, np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
    )
    lens = np.array([camera.focal_length_mm, 0.0, 0.0])
    return [
        rigid(
            CAMERA_FROM_OPENCV @ np.asarray(cv2.Rodrigues(turn)[0], dtype=np.float64),
            CAMERA_FROM_OPENCV @ np.asarray(shift, dtype=np.float64).ravel() + lens,
        )
        for turn, shift in zip(turns, shifts, strict=True)
    ]
