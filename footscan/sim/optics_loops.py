"""Inner loops of the true picture: projection of single points with distortion. Same mathematics as `optics.camera`."""

import numpy as np

from footscan.compiled import compiled, compiled_inline
from footscan.coordinates import Floats
from footscan.optics import Camera

ImagePlace = tuple[float, float, float]
"""u, v (px, upright frame) and 1 / depth (1/mm); 1 / depth is 0 where the point lies behind the lens."""


def lens_numbers(camera: Camera) -> Floats:
    """The camera as one array for the loops: pitches (mm), principal point in the upright frame (px), K1, K2, f."""
    c_y, c_z = camera.principal_point_px
    return np.array(
        [
            camera.horizontal_scale * camera.pixel_pitch_y_mm,
            camera.pixel_pitch_z_mm,
            c_y,
            camera.height_px - 1 - c_z,
            camera.k1_per_mm2,
            camera.k2_per_mm4,
            camera.focal_length_mm,
        ]
    )


@compiled_inline
def project(x: float, y: float, z: float, camera_from: Floats, lens: Floats) -> ImagePlace:
    """Project one point given in the system that `camera_from` (4x4) comes from (eq. 1-2, 12, 14)."""
    m = camera_from
    depth = m[0, 0] * x + m[0, 1] * y + m[0, 2] * z + m[0, 3] - lens[6]
    y_c = m[1, 0] * x + m[1, 1] * y + m[1, 2] * z + m[1, 3]
    z_c = m[2, 0] * x + m[2, 1] * y + m[2, 2] * z + m[2, 3]
    inverse = 1.0 / depth if depth > 1.0 else 0.0
    y_u, z_u = -lens[6] * y_c * inverse, -lens[6] * z_c * inverse
    k1, k2 = lens[4], lens[5]
    rho2_u = y_u * y_u + z_u * z_u
    # rho_u = rho_d * (1 + k1 rho_d^2 + k2 rho_d^4), solved for stretch = rho_d / rho_u by Newton's method
    stretch = 1.0
    for _ in range(4):
        rho2 = rho2_u * stretch * stretch
        value = stretch * (1.0 + rho2 * (k1 + rho2 * k2)) - 1.0
        slope = 1.0 + rho2 * (3.0 * k1 + 5.0 * rho2 * k2)
        stretch -= value / max(slope, 0.05)
    return lens[2] + y_u * stretch / lens[0], lens[3] + z_u * stretch / lens[1], inverse


@compiled
def project_points(xyz: Floats, camera_from: Floats, lens: Floats, image: Floats) -> None:
    """Write (u, v, 1 / depth) of `(n, 3)` points into `image` `(n, 3)`."""
    for i in range(xyz.shape[0]):
        image[i, 0], image[i, 1], image[i, 2] = project(xyz[i, 0], xyz[i, 1], xyz[i, 2], camera_from, lens)
