"""Rigid transforms as 4x4 matrices; names read result-first: `world_from_light @ light_from_camera`."""

import numpy as np

from footscan.coordinates import Floats


def rigid(rotation: Floats, translation: Floats) -> Floats:
    """Assemble a 4x4 from a `(3, 3)` rotation and a `(3,)` translation."""
    result = np.eye(4)
    result[:3, :3] = rotation
    result[:3, 3] = translation
    return result


def inverse_rigid(transform: Floats) -> Floats:
    """Invert a 4x4 rigid transform by its transpose (exact, no matrix inversion)."""
    rotation = transform[:3, :3]
    return rigid(rotation.T, -rotation.T @ transform[:3, 3])


def rotation_z(angle_rad: float) -> Floats:
    """`(3, 3)` rotation about z, counter-clockwise seen from +z."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def turn_z(angle_rad: float) -> Floats:
    """4x4 of `rotation_z`."""
    return rigid(rotation_z(angle_rad), np.zeros(3))


def transform_points(transform: Floats, xyz: Floats) -> Floats:
    """Apply a 4x4 to `(n, 3)` points."""
    return xyz @ transform[:3, :3].T + transform[:3, 3]
