"""A laser's light plane and its own coordinate system L."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats, LaserName
from footscan.geometry.rigid import rigid


@dataclass(frozen=True)
class LightPlane:
    """The sheet `normal . x = offset_mm` of one laser, in W at theta = 0; the normal is Z_L."""

    name: LaserName
    normal: tuple[float, float, float]
    offset_mm: float


def ideal_normal(alpha_rad: float) -> tuple[float, float, float]:
    """Z_L at theta = 0 of a vertical sheet through the axis at angle alpha (third row of W, eq. A.4)."""
    return (-float(np.sin(alpha_rad)), float(np.cos(alpha_rad)), 0.0)


def alpha_from_sheet(sheet: LightPlane) -> float:
    """The angle alpha (rad) of the vertical sheet nearest to this one; inverse of `ideal_normal`."""
    return float(np.arctan2(-sheet.normal[0], sheet.normal[1]))


def world_from_light(sheet: LightPlane) -> Floats:
    """4x4 at theta = 0: origin offset * n, z_L = n, x_L horizontal from the laser through the axis, y_L = z_L x x_L.

    For an ideal sheet this is W^-1 of eq. (22) at theta = 0.
    """
    z_light = np.array(sheet.normal)
    x_light = np.array([-z_light[1], z_light[0], 0.0])
    x_light = x_light / np.linalg.norm(x_light)
    rotation = np.stack([x_light, np.cross(z_light, x_light), z_light], axis=1)
    return rigid(rotation, sheet.offset_mm * z_light)


def plane_in_camera(sheet: LightPlane, camera_from_world_at_zero: Floats) -> tuple[float, float, float, float]:
    """(A, B, C, D) of eq. (6): the third column of R_LC and minus its product with T_LC."""
    camera_from_light = camera_from_world_at_zero @ world_from_light(sheet)
    a, b, c = camera_from_light[:3, 2]
    return float(a), float(b), float(c), -float(camera_from_light[:3, 2] @ camera_from_light[:3, 3])


def camera_from_ray(ray_camera: Floats, focal_length_mm: float, plane: tuple[float, float, float, float]) -> Floats:
    """Where `(n, 3)` rays from the optical centre meet the plane A, B, C, D: closed form of eq. (7)-(9).

    A ray that meets the plane behind the camera, or not at all, gives NaN.
    """
    a, b, c, d = plane
    slope = ray_camera @ np.array([a, b, c])
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = -(a * focal_length_mm + d) / slope
    reach = np.where(np.isfinite(reach) & (reach > 0.0), reach, np.nan)
    return np.array([focal_length_mm, 0.0, 0.0]) + reach[..., None] * ray_camera
