"""From the scan matrix to a cloud in the world, after the scan (eq. 22), and what every point knows about itself."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import LASER_NAMES, Bools, Floats, Floats32, Ints, LaserName
from footscan.geometry.rigid import transform_points
from footscan.optics.tables import LightTable
from footscan.scanning.matrix import ScanMatrix


@dataclass(frozen=True)
class Cloud:
    """`(n, 3)` points in W (mm), `(n,)` laser codes (0 right, 1 left), weights in 0..1 and frame numbers."""

    xyz_world: Floats
    laser: Ints
    weight: Floats32
    frame: Ints

    def __len__(self) -> int:
        return len(self.weight)

    def where(self, keep: Bools) -> "Cloud":
        """The points for which `keep` `(n,)` holds."""
        return Cloud(self.xyz_world[keep], self.laser[keep], self.weight[keep], self.frame[keep])

    def at(self, xyz_world: Floats) -> "Cloud":
        """The same points at other places `(n, 3)`."""
        return Cloud(xyz_world, self.laser, self.weight, self.frame)

    def with_weight(self, weight: Floats32) -> "Cloud":
        """The same points with other weights."""
        return Cloud(self.xyz_world, self.laser, weight, self.frame)


def cloud_from_matrix(matrix: ScanMatrix, tables: dict[LaserName, LightTable]) -> Cloud:
    """Carry every light-plane point to the world by its laser's fixed transform and its frame's angle (eq. 22)."""
    counts = matrix.points_per_frame
    laser = np.repeat(matrix.laser, counts)
    theta_rad = np.repeat(matrix.theta_rad, counts)
    xy_light = matrix.xy_light.astype(np.float64)
    at_home = np.empty((len(laser), 3))
    for code, name in enumerate(LASER_NAMES):
        own = laser == code
        flat = np.column_stack([xy_light[own], np.zeros(int(own.sum()))])
        at_home[own] = transform_points(tables[name].world_from_light, flat)
    c, s = np.cos(theta_rad), np.sin(theta_rad)
    x, y, z = at_home.T
    xyz_world = np.column_stack([c * x - s * y, s * x + c * y, z])
    return Cloud(xyz_world, laser, matrix.weight.copy(), np.repeat(matrix.frame, counts))
