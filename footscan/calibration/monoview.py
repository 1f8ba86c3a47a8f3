"""The paper's way: one view of control points in one plane, the light plane itself (Part II, monoview coplanar).

One view of one plane gives the focal length, K1 and the pose of the plane, and nothing more: principal point,
horizontal scale and K2 stay as designed. It is here to compare with, not to work with.
"""

from dataclasses import dataclass, replace

import numpy as np

from footscan.calibration.estimate import Estimate, start_estimate
from footscan.calibration.first_guess import camera_from_board_poses
from footscan.calibration.misfit import corner_misfit_px
from footscan.calibration.sightings import NO_STRIPES, Corners, FrameTimes, Sightings
from footscan.calibration.solve import Fit, fit_estimate
from footscan.calibration.unknowns import POSES_ONLY, Unknowns
from footscan.coordinates import Floats
from footscan.geometry.rigid import inverse_rigid
from footscan.optics import Calibration
from footscan.optics.calibration import camera_from_world
from footscan.optics.camera import ray_from_pixel
from footscan.scanning.recording import EncoderTrack

HELD = ("principal point", "horizontal scale", "K2")
"""What one coplanar view cannot give and what therefore stays as designed."""
_MONOVIEW = Unknowns(("focal_length_mm", "k1_per_mm2"))


@dataclass(frozen=True)
class Monoview:
    """A camera and the plane of the control points as one view shows them; `HELD` stays as designed."""

    fit: Fit

    def places_mm(self, yz_pixel: Floats) -> Floats:
        """Where the rays of pixels `(n, 2)` meet the control plane: `(n, 2)` mm in its own coordinates."""
        return plane_places_mm(self.fit.estimate, yz_pixel)


def plane_places_mm(estimate: Estimate, yz_pixel: Floats) -> Floats:
    """Where rays of pixels `(n, 2)` at theta = 0 meet the first board's plane: `(n, 2)` mm on it."""
    machine = estimate.machine
    board_from_camera = inverse_rigid(estimate.world_from_board[0]) @ inverse_rigid(camera_from_world(machine))
    ray = ray_from_pixel(yz_pixel, machine.camera) @ board_from_camera[:3, :3].T
    lens = (board_from_camera @ np.array([machine.camera.focal_length_mm, 0.0, 0.0, 1.0]))[:3]
    return (lens - (lens[2] / ray[:, 2])[:, None] * ray)[:, :2]


def fit_monoview(design: Calibration, xy_plane: Floats, yz_pixel: Floats) -> Monoview:
    """Fit focal length, K1 and the pose of the plane to one view.

    Args:
        design: What is held, and the first guess.
        xy_plane: `(n, 2)` control points in their plane, mm.
        yz_pixel: `(n, 2)` where they were seen, in F.

    Raises:
        ValueError: Fewer than four points.
    """
    if len(xy_plane) < 4:
        raise ValueError(f"one view needs at least 4 control points, found {len(xy_plane)}")
    number = len(xy_plane)
    none = np.zeros(number, dtype=np.int64)
    corners = Corners(none, none, xy_plane, yz_pixel, np.zeros(number, dtype=bool))
    zero = float(design.encoder.zero_count)
    times = FrameTimes(np.zeros(1), np.zeros(1, dtype=bool), EncoderTrack(np.array([0.0]), np.array([zero])))
    still = replace(design, encoder=replace(design.encoder, eccentricity_rad=0.0))
    sightings = Sightings(times, corners, NO_STRIPES, ("plane",))
    starts = [
        start_estimate(still, (inverse_rigid(camera_from_world(still)) @ pose)[None])
        for pose in camera_from_board_poses(still, corners)
    ]
    start = min(starts, key=lambda estimate: float(np.abs(corner_misfit_px(estimate, corners, np.zeros(1))).sum()))
    posed = fit_estimate(start, sightings, POSES_ONLY)
    return Monoview(fit_estimate(posed.estimate, sightings, _MONOVIEW))
