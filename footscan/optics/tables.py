"""Calibration tables: every pixel of the frame to millimetres in one laser's light plane (paper, section 4).

A table is built once per calibration; while scanning, a stripe place costs one read between its neighbours.
"""

from dataclasses import dataclass

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import LASER_NAMES, WORKING_RADIUS_MM, WORKING_Z_MM, Floats, Floats32, LaserName
from footscan.geometry.rigid import inverse_rigid
from footscan.optics.calibration import Calibration, camera_from_world, fingerprint
from footscan.optics.sheet import world_from_light


@dataclass(frozen=True)
class LightTable:
    """One laser's table.

    Attributes:
        laser: Its name.
        xy_light: `(height, width, 2)` float32, mm in the sheet; NaN outside the working volume.
        world_from_light: 4x4 at theta = 0.
        calibration_sha256: `fingerprint` of the calibration it was built from.
    """

    laser: LaserName
    xy_light: Floats32
    world_from_light: Floats
    calibration_sha256: str

    def lookup(self, uv: Floats) -> Floats:
        """Light-plane millimetres `(n, 2)` of places `(n, 2)` (u, v) of the upright frame, between pixels allowed.

        Read by a 4x4 cubic (Keys, a = -1/2; error below 1e-4 mm), at the rim of the working volume by a 2x2 linear
        one; NaN where the volume or the frame ends.

        Raises:
            ValueError: `uv` is not `(n, 2)`.
        """
        uv = np.asarray(uv, dtype=np.float64)
        if uv.ndim != 2 or uv.shape[1] != 2:
            raise ValueError(f"places are (n, 2), found {uv.shape}")
        result = np.empty((len(uv), 2))
        _read_between_pixels(self.xy_light, np.ascontiguousarray(uv), result)
        return result


def build_tables(calibration: Calibration) -> dict[LaserName, LightTable]:
    """Both calibration tables."""
    return {name: build_table(calibration, name) for name in LASER_NAMES}


def build_table(calibration: Calibration, laser: LaserName) -> LightTable:
    """Compute one laser's table from the closed form of eq. (7) and eq. (21), every pixel once."""
    camera = calibration.camera
    sheet_in_world = world_from_light(calibration.laser(laser))
    light_from_camera = inverse_rigid(sheet_in_world) @ inverse_rigid(camera_from_world(calibration))
    centre = light_from_camera @ np.array([camera.focal_length_mm, 0.0, 0.0, 1.0])
    xy_light = np.empty((camera.height_px, camera.width_px, 2), dtype=np.float32)
    _fill_table(
        xy_light,
        np.array(
            [
                camera.horizontal_scale * camera.pixel_pitch_y_mm,
                camera.pixel_pitch_z_mm,
                *camera.principal_point_px,
                camera.k1_per_mm2,
                camera.k2_per_mm4,
                camera.focal_length_mm,
            ]
        ),
        np.ascontiguousarray(light_from_camera[:3, :3]),
        np.ascontiguousarray(centre[:3]),
        sheet_in_world,
        np.array([WORKING_RADIUS_MM**2, *WORKING_Z_MM]),
    )
    return LightTable(laser, xy_light, sheet_in_world, fingerprint(calibration))


@compiled
def _fill_table(
    xy_light: Floats32, lens: Floats, turn: Floats, centre: Floats, world_from_light: Floats, limits: Floats
) -> None:
    height, width = xy_light.shape[0], xy_light.shape[1]
    pitch_y, pitch_z, c_y, c_z, k1, k2, f = lens[0], lens[1], lens[2], lens[3], lens[4], lens[5], lens[6]
    t, w = turn, world_from_light
    for row in range(height):
        z_d = pitch_z * (c_z - (height - 1 - row))
        for column in range(width):
            y_d = pitch_y * (column - c_y)
            rho2 = y_d * y_d + z_d * z_d
            k = 1.0 + rho2 * (k1 + rho2 * k2)
            y_u, z_u = y_d * k, z_d * k
            reach = -centre[2] / (t[2, 0] * f - t[2, 1] * y_u - t[2, 2] * z_u)
            x = centre[0] + reach * (t[0, 0] * f - t[0, 1] * y_u - t[0, 2] * z_u)
            y = centre[1] + reach * (t[1, 0] * f - t[1, 1] * y_u - t[1, 2] * z_u)
            x_w = w[0, 0] * x + w[0, 1] * y + w[0, 3]
            y_w = w[1, 0] * x + w[1, 1] * y + w[1, 3]
            z_w = w[2, 0] * x + w[2, 1] * y + w[2, 3]
            inside = x_w * x_w + y_w * y_w <= limits[0] and limits[1] < z_w < limits[2] and reach > 0.0
            xy_light[row, column, 0] = x if inside else np.nan
            xy_light[row, column, 1] = y if inside else np.nan


@compiled
def _read_between_pixels(table: Floats32, uv: Floats, result: Floats) -> None:
    height, width = table.shape[0], table.shape[1]
    for i in range(uv.shape[0]):
        u, v = uv[i, 0], uv[i, 1]
        result[i, 0] = np.nan
        result[i, 1] = np.nan
        if not (0.0 <= u <= width - 1 and 0.0 <= v <= height - 1):
            continue
        column, row = int(u), int(v)
        a, b = u - column, v - row
        if 1 <= column < width - 2 and 1 <= row < height - 2:
            wa0, wa1 = ((2.0 - a) * a - 1.0) * a * 0.5, ((3.0 * a - 5.0) * a * a + 2.0) * 0.5
            wa2, wa3 = ((4.0 - 3.0 * a) * a + 1.0) * a * 0.5, (a - 1.0) * a * a * 0.5
            wb0, wb1 = ((2.0 - b) * b - 1.0) * b * 0.5, ((3.0 * b - 5.0) * b * b + 2.0) * 0.5
            wb2, wb3 = ((4.0 - 3.0 * b) * b + 1.0) * b * 0.5, (b - 1.0) * b * b * 0.5
            x, y = 0.0, 0.0
            for j in range(4):
                line = table[row - 1 + j]
                c = column - 1
                weight = wb0 if j == 0 else wb1 if j == 1 else wb2 if j == 2 else wb3
                x += weight * (wa0 * line[c, 0] + wa1 * line[c + 1, 0] + wa2 * line[c + 2, 0] + wa3 * line[c + 3, 0])
                y += weight * (wa0 * line[c, 1] + wa1 * line[c + 1, 1] + wa2 * line[c + 2, 1] + wa3 * line[c + 3, 1])
            if np.isfinite(x) and np.isfinite(y):
                result[i, 0], result[i, 1] = x, y
                continue
        right, below = (1 if a > 0.0 else 0), (1 if b > 0.0 else 0)  # a neighbour of weight 0 may be NaN
        for k in range(2):
            top = (1.0 - a) * table[row, column, k] + a * table[row, column + right, k]
            bottom = (1.0 - a) * table[row + below, column, k] + a * table[row + below, column + right, k]
            result[i, k] = (1.0 - b) * top + b * bottom
