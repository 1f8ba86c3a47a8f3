"""The camera of the paper: pixel <-> image plane (eq. 12, 13), radial distortion both ways (eq. 14), rays (eq. 1-2)."""

from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Floats

_WIDEST = 4.0  # a distorted radius more than this times the undistorted one is no lens


@dataclass(frozen=True)
class Camera:
    """Internal parameters; the paper's symbols stand behind each field.

    `horizontal_scale` is s_y of eq. (12); `estimate_horizontal_scale` is eq. (13). K1 and K2 map distorted to
    undistorted image millimetres, the opposite way from OpenCV's model.
    """

    width_px: int
    height_px: int
    pixel_pitch_y_mm: float  # d_y
    pixel_pitch_z_mm: float  # d_z
    focal_length_mm: float  # f
    horizontal_scale: float  # s_y
    principal_point_px: tuple[float, float]  # (C_y, C_z), in F
    k1_per_mm2: float  # K_1
    k2_per_mm4: float  # K_2
    image_rotation_deg: int = 0

    def coarser(self, times: int) -> "Camera":
        """The same field of view in fewer pixels, `times` as large both ways."""
        c_y, c_z = self.principal_point_px
        return replace(
            self,
            width_px=self.width_px // times,
            height_px=self.height_px // times,
            pixel_pitch_y_mm=self.pixel_pitch_y_mm * times,
            pixel_pitch_z_mm=self.pixel_pitch_z_mm * times,
            principal_point_px=(c_y / times, c_z / times),
        )


def estimate_horizontal_scale(sensor_elements_per_line: int, picture_elements_per_line: int) -> float:
    """s_y = N_y / M_y (eq. 13)."""
    return sensor_elements_per_line / picture_elements_per_line


def image_from_pixel(yz_pixel: Floats, camera: Camera) -> Floats:
    """Distorted image-plane millimetres `(n, 2)` of computer-image places `(n, 2)` (eq. 12)."""
    c_y, c_z = camera.principal_point_px
    y = camera.horizontal_scale * camera.pixel_pitch_y_mm * (yz_pixel[..., 0] - c_y)
    z = camera.pixel_pitch_z_mm * (c_z - yz_pixel[..., 1])
    return np.stack([y, z], axis=-1)


def pixel_from_image(yz_image: Floats, camera: Camera) -> Floats:
    """Inverse of `image_from_pixel`."""
    c_y, c_z = camera.principal_point_px
    y = yz_image[..., 0] / (camera.horizontal_scale * camera.pixel_pitch_y_mm) + c_y
    z = c_z - yz_image[..., 1] / camera.pixel_pitch_z_mm
    return np.stack([y, z], axis=-1)


def undistorted_from_distorted(yz_image: Floats, camera: Camera) -> Floats:
    """Remove radial distortion from `(n, 2)` image-plane millimetres (eq. 14)."""
    rho2 = np.sum(yz_image**2, axis=-1, keepdims=True)
    return yz_image * (1.0 + camera.k1_per_mm2 * rho2 + camera.k2_per_mm4 * rho2**2)


def distorted_from_undistorted(yz_image: Floats, camera: Camera) -> Floats:
    """Apply radial distortion: invert eq. (14) along the radius by Newton's method, to rounding.

    Raises:
        ValueError: The distortion folds over before this radius, so no distorted place exists.
    """
    radius_u = np.sqrt(np.sum(yz_image**2, axis=-1, keepdims=True))
    radius_d = radius_u.copy()
    k1, k2 = camera.k1_per_mm2, camera.k2_per_mm4
    for _ in range(30):
        r2 = radius_d**2
        slope = 1.0 + 3.0 * k1 * r2 + 5.0 * k2 * r2**2
        step = (radius_d * (1.0 + k1 * r2 + k2 * r2**2) - radius_u) / np.where(slope > 0.05, slope, 0.05)
        radius_d = np.clip(radius_d - step, 0.0, _WIDEST * radius_u)
        if np.all(np.abs(step) <= 1e-15 * (1.0 + radius_u)):
            break
    residual = radius_d * (1.0 + k1 * radius_d**2 + k2 * radius_d**4) - radius_u
    if np.any(np.abs(residual) > 1e-9 * (1.0 + radius_u)):
        raise ValueError("the radial distortion folds over inside the picture; check K1 and K2")
    return yz_image * np.where(radius_u > 0.0, radius_d / np.where(radius_u > 0.0, radius_u, 1.0), 1.0)


def ray_from_undistorted(yz_image: Floats, camera: Camera) -> Floats:
    """Directions `(n, 3)` in C of the rays from the optical centre (f, 0, 0) through the scene (eq. 1-2, 10-11)."""
    f = np.full(yz_image.shape[:-1], camera.focal_length_mm)
    return np.stack([f, -yz_image[..., 0], -yz_image[..., 1]], axis=-1)


def ray_from_pixel(yz_pixel: Floats, camera: Camera) -> Floats:
    """Directions `(n, 3)` in C of the rays of computer-image places `(n, 2)` (eq. 12, 14)."""
    return ray_from_undistorted(undistorted_from_distorted(image_from_pixel(yz_pixel, camera), camera), camera)


def pixel_from_camera(xyz_camera: Floats, camera: Camera) -> Floats:
    """Project `(n, 3)` camera points to computer-image places `(n, 2)`; points behind the lens give NaN."""
    depth = xyz_camera[..., 0] - camera.focal_length_mm
    scale = np.where(depth > 0.0, -camera.focal_length_mm / np.where(depth > 0.0, depth, 1.0), np.nan)
    undistorted = xyz_camera[..., 1:] * scale[..., None]
    finite = np.isfinite(undistorted).all(axis=-1)
    result = np.full(undistorted.shape, np.nan)
    result[finite] = pixel_from_image(distorted_from_undistorted(undistorted[finite], camera), camera)
    return result
