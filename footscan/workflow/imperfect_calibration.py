"""Calibrations as a calibration finds them: a little off the truth everywhere, by a stated amount in millimetres."""

from dataclasses import replace

import numpy as np

from footscan.coordinates import LASER_NAMES, Floats
from footscan.geometry.rigid import transform_points
from footscan.optics import Calibration, Camera, LightPlane, Pose
from footscan.optics.tables import build_table

_TRIAL = 0.1
_EVERY_PX = 10


def imperfect_calibration(truth: Calibration, rms_mm: float, seed: int) -> Calibration:
    """A calibration whose world points lie `rms_mm` (RMS over the working volume of both sheets) off the true ones.

    Camera, pose, sheets and latency are off together, in proportions that seed decides; the footboard stays.
    """
    error = np.random.default_rng([seed, 0xCA11B]).normal(size=_NUMBERS)
    trial_mm = world_points_off_mm(truth, _changed(truth, _TRIAL * error))
    return _changed(truth, (_TRIAL * rms_mm / trial_mm) * error)


_NUMBERS = 19


def _changed(truth: Calibration, e: Floats) -> Calibration:
    """The truth with 19 errors, each in units that move points by a few tenths of a millimetre."""
    camera, pose = truth.camera, truth.pose
    right, left = truth.lasers
    t_x, t_y, t_z = pose.translation_mm
    return replace(
        truth,
        camera=_changed_camera(camera, e[0:4]),
        pose=Pose(
            pose.phi_rad + 1e-3 * float(e[4]),
            pose.sigma_rad + 1e-3 * float(e[5]),
            (t_x + 0.3 * float(e[6]), t_y + 0.3 * float(e[7]), t_z + 0.3 * float(e[8])),
        ),
        lasers=(_changed_sheet(right, e[9:13]), _changed_sheet(left, e[13:17])),
        latency_s=truth.latency_s + 1e-3 * float(e[17]),
        encoder=replace(truth.encoder, eccentricity_rad=truth.encoder.eccentricity_rad + 2e-4 * float(e[18])),
    )


def _changed_camera(camera: Camera, e: Floats) -> Camera:
    c_y, c_z = camera.principal_point_px
    return replace(
        camera,
        focal_length_mm=camera.focal_length_mm * (1.0 + 1e-3 * float(e[0])),
        principal_point_px=(c_y + 0.5 * float(e[1]), c_z + 0.5 * float(e[2])),
        k1_per_mm2=camera.k1_per_mm2 * (1.0 + 0.1 * float(e[3])),
    )


def _changed_sheet(sheet: LightPlane, e: Floats) -> LightPlane:
    normal = np.array(sheet.normal) + 1e-3 * e[:3]
    n_x, n_y, n_z = (normal / np.linalg.norm(normal)).tolist()
    return LightPlane(sheet.name, (n_x, n_y, n_z), sheet.offset_mm + 0.2 * float(e[3]))


def world_points_off_mm(truth: Calibration, changed: Calibration) -> float:
    """RMS distance (mm) between the world points of two calibrations, over the working volume of both sheets."""
    squares = [(_volume(truth, row) - _volume(changed, row)) ** 2 for row in range(len(LASER_NAMES))]
    turn_s = 12.0
    latency_mm = 2.0 * np.pi / turn_s * (changed.latency_s - truth.latency_s) * 80.0
    return float(np.sqrt(np.nanmean(np.concatenate(squares).sum(axis=1)) + latency_mm**2))


def _volume(calibration: Calibration, laser: int) -> Floats:
    table = build_table(calibration, LASER_NAMES[laser])
    xy_light = table.xy_light[::_EVERY_PX, ::_EVERY_PX].reshape(-1, 2).astype(np.float64)
    return transform_points(table.world_from_light, np.column_stack([xy_light, np.zeros(len(xy_light))]))
