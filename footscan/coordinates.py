"""The coordinate systems, as array types, and the conversions between neighbours that need no calibration.

| suffix | system | unit |
|---|---|---|
| `xyz_world`  | W: axis of rotation meets the footboard; Z up, X towards the camera at home | mm |
| `xy_light`   | L: in one laser's sheet; y up, x horizontal, from the laser through the axis | mm |
| `xyz_camera` | C: x along the optical axis into the scene, optical centre at (f, 0, 0) | mm |
| `yz_image`   | I: on the image plane, origin at the principal point | mm |
| `yz_pixel`   | F: the paper's computer image (rows counted from the bottom) | px |
| `uv`         | the upright frame: u column from the left, v row from the top, integer = pixel centre | px |
| `xyz_foot`   | heel -> toe along the foot axis, y medial, z up from the board | mm |
| `xyz_shoelast` | heel -> toe, y medial, z up from the ground, the seat at its heel height | mm |
"""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Bytes = NDArray[np.uint8]

Frame = NDArray[np.uint8]
"""`(height, width)` 8-bit grey video frame, upright."""

LaserName = Literal["right", "left"]
LASER_NAMES: tuple[LaserName, LaserName] = ("right", "left")
"""Order used in files and arrays: 0 is the right laser, 1 the left one."""

Side = Literal["right", "left"]

WORKING_RADIUS_MM = 200.0
WORKING_Z_MM = (-10.0, 260.0)
"""Working volume: within the radius of the axis and between these heights above the board."""


def pixel_from_uv(uv: Floats, height_px: int) -> Floats:
    """Turn `(n, 2)` upright frame places (u, v) into the paper's computer image (y_F, z_F).

    Eq. (8)-(12) put a higher scene point at a larger z_F, so F is the upright frame with its rows reversed.
    """
    return np.stack([uv[..., 0], height_px - 1 - uv[..., 1]], axis=-1)


def uv_from_pixel(yz_pixel: Floats, height_px: int) -> Floats:
    """Inverse of `pixel_from_uv`; the same reflection."""
    return pixel_from_uv(yz_pixel, height_px)


def theta_from_count(count: Floats, zero_count: int, steps_per_rev: int, direction: int) -> Floats:
    """Head angle theta (rad, counter-clockwise seen from above) of encoder counts, which may be interpolated."""
    return 2.0 * np.pi * direction * (np.asarray(count, dtype=np.float64) - zero_count) / steps_per_rev
