"""The paper's slow chain, literally: the oracle for tables and poses."""

import numpy as np

from footscan.optics.calibration import Calibration, camera_from_world
from footscan.optics.sheet import plane_in_camera


def h_matrix(y_i, z_i, f, a, b, c):
    return np.array([[-y_i, -f, 0.0], [-z_i, 0.0, -f], [a, b, c]])  # eq. 8


def slow_chain(calibration: Calibration, laser: str, uv: np.ndarray) -> np.ndarray:
    """World points (theta = 0) of upright frame places by eq. (12), (14), (8), (9), (7) and (20)."""
    camera = calibration.camera
    q_inverse = np.linalg.inv(camera_from_world(calibration))
    a, b, c, d = plane_in_camera(calibration.laser(laser), camera_from_world(calibration))
    c_y, c_z = camera.principal_point_px
    result = []
    for u, v in uv:
        y_f, z_f = u, camera.height_px - 1 - v
        y_d = camera.horizontal_scale * camera.pixel_pitch_y_mm * (y_f - c_y)
        z_d = camera.pixel_pitch_z_mm * (-z_f + c_z)
        rho2 = y_d**2 + z_d**2
        k = 1.0 + camera.k1_per_mm2 * rho2 + camera.k2_per_mm4 * rho2**2
        y_i, z_i, f = y_d * k, z_d * k, camera.focal_length_mm
        xyz_camera = np.linalg.inv(h_matrix(y_i, z_i, f, a, b, c)) @ np.array([-y_i * f, -z_i * f, -d])
        result.append((q_inverse @ np.append(xyz_camera, 1.0))[:3])
    return np.array(result)
