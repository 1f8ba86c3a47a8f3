"""The scanner head's design (Table I) and its poses (eq. 16-19, A.1-A.4)."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.geometry.rigid import rigid


@dataclass(frozen=True)
class Head:
    """Chief geometrical characteristics of the head (paper, Table I, Figures 5b and 5c)."""

    h_mm: float
    g_mm: float
    p_mm: float
    cc_mm: float
    phi_rad: float
    sigma_rad: float


def lens_offset_a_mm(head: Head) -> float:
    """The length a of eq. (18)."""
    return (head.h_mm + head.p_mm / np.cos(head.phi_rad)) / np.tan(head.phi_rad) - head.g_mm


def translation_from_head(head: Head) -> Floats:
    """T_WC `(3,)` of eq. (17): the world origin in the camera system."""
    a, phi, sigma = lens_offset_a_mm(head), head.phi_rad, head.sigma_rad
    t_x = (a + head.g_mm) / np.cos(phi) - a * np.cos(phi) - head.cc_mm
    return np.array([t_x, a * np.sin(sigma) * np.sin(phi), -a * np.cos(sigma) * np.sin(phi)])


def rotation_camera_from_world(theta_rad: float, phi_rad: float, sigma_rad: float) -> Floats:
    """R_WC `(3, 3)` of eq. (16)."""
    ct, st = np.cos(theta_rad), np.sin(theta_rad)
    cp, sp = np.cos(phi_rad), np.sin(phi_rad)
    cs, ss = np.cos(sigma_rad), np.sin(sigma_rad)
    return np.array(
        [
            [-cp * ct, -cp * st, -sp],
            [cs * st + ss * sp * ct, -cs * ct + ss * sp * st, -ss * cp],
            [ss * st - cs * sp * ct, -ss * ct - cs * sp * st, cs * cp],
        ]
    )


def rotation_camera_from_light(alpha_rad: float, phi_rad: float, sigma_rad: float) -> Floats:
    """R_LC `(3, 3)` of eq. (A.2), the ideal sheet; the left laser takes -alpha."""
    ca, sa = np.cos(alpha_rad), np.sin(alpha_rad)
    cp, sp = np.cos(phi_rad), np.sin(phi_rad)
    cs, ss = np.cos(sigma_rad), np.sin(sigma_rad)
    return np.array(
        [
            [cp * ca, -sp, cp * sa],
            [cs * sa - ss * sp * ca, -ss * cp, -cs * ca - ss * sp * sa],
            [ss * sa + cs * sp * ca, cs * cp, -ss * ca + cs * sp * sa],
        ]
    )


def light_from_world_ideal(theta_rad: float, alpha_rad: float) -> Floats:
    """W, 4x4, of eq. (A.4): world to light system of an ideal sheet."""
    c, s = np.cos(theta_rad + alpha_rad), np.sin(theta_rad + alpha_rad)
    return rigid(np.array([[-c, -s, 0.0], [0.0, 0.0, 1.0], [-s, c, 0.0]]), np.zeros(3))


def camera_from_world(theta_rad: float, phi_rad: float, sigma_rad: float, translation_mm: Floats) -> Floats:
    """Q, 4x4, of eq. (19)."""
    return rigid(rotation_camera_from_world(theta_rad, phi_rad, sigma_rad), translation_mm)
