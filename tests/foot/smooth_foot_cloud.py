"""A cloud of a smooth closed-form foot, with what a scanner would not see left out, and distances to its true skin."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats, Ints

LENGTH_MM = 262.0
LOWEST_SEEN_MM = 6.0


@dataclass(frozen=True)
class FootCloud:
    xyz: Floats
    weight: Floats
    laser: Ints


def _sections(z: Floats) -> tuple[Floats, Floats, Floats]:
    """Middle, half length and half width of the oval horizontal sections."""
    below = np.sqrt(np.clip(1.0 - ((12.0 - np.minimum(z, 12.0)) / 16.0) ** 2, 0.05, 1.0))
    front = -22.0 + 152.0 * np.exp(-((np.maximum(z - 12.0, 0.0) / 42.0) ** 2))
    back = -112.0 - 20.0 * np.exp(-(((z - 15.0) / 40.0) ** 2))
    width = 31.0 + 15.0 * np.exp(-(((z - 14.0) / 45.0) ** 2)) + 4.0 * np.exp(-(((z - 78.0) / 12.0) ** 2))
    return 0.5 * (front + back), 0.5 * (front - back) - 8.0 * (1.0 - below), width - 8.0 * (1.0 - below)


def distance_mm(xyz: Floats) -> Floats:
    """Signed distance to the true skin, to first order, positive outside."""

    def oval(points: Floats) -> Floats:
        middle, half_length, half_width = _sections(points[:, 2])
        return ((points[:, 0] - middle) / half_length) ** 2 + (points[:, 1] / half_width) ** 2 - 1.0

    steps = 1e-4 * np.eye(3)
    slope = np.stack([(oval(xyz + step) - oval(xyz - step)) / 2e-4 for step in steps], axis=1)
    return oval(xyz) / np.linalg.norm(slope, axis=1)


def foot_cloud(noise_mm: float = 0.03, top_mm: float = 150.0, stripes: int = 240) -> FootCloud:
    """Stripes of both lasers from 6 mm above the board up to the top; the leg's front is seen less high."""
    rng = np.random.default_rng(7)
    turn, z = np.meshgrid(
        np.linspace(0, 2 * np.pi, stripes, endpoint=False), np.arange(LOWEST_SEEN_MM, top_mm, 0.9), indexing="ij"
    )
    turn, z = turn.ravel(), z.ravel() + rng.uniform(-0.3, 0.3, z.size)
    seen = z < top_mm - 12.0 * (np.cos(turn) > 0.3)
    turn, z = turn[seen], z[seen]
    middle, half_length, half_width = _sections(z)
    xyz = np.stack([middle + half_length * np.cos(turn), half_width * np.sin(turn), z], axis=1)
    laser = (np.round(turn / (2 * np.pi) * stripes).astype(np.int64)) % 2
    return FootCloud(xyz + rng.normal(0.0, noise_mm, xyz.shape), rng.uniform(0.2, 1.0, len(xyz)), laser)


def turned(xyz: Floats, angle_rad: float, shift_mm: tuple[float, float] = (0.0, 0.0)) -> Floats:
    """Points turned about Z and shifted."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.column_stack([xyz[:, :2] @ np.array([[c, s], [-s, c]]) + np.array(shift_mm), xyz[:, 2]])
