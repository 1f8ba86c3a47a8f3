"""Planes n.x = offset."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats


@dataclass(frozen=True)
class Plane:
    """The plane `normal . x = offset_mm` with a unit normal `(3,)`."""

    normal: tuple[float, float, float]
    offset_mm: float

    @property
    def normal_array(self) -> Floats:
        """The unit normal as an array `(3,)`."""
        return np.array(self.normal)

    def distance_mm(self, xyz: Floats) -> Floats:
        """Signed distance `(n,)` of `(n, 3)` points, positive on the side the normal points to."""
        return xyz @ self.normal_array - self.offset_mm


def fit_plane(xyz: Floats) -> Plane:
    """Total least squares plane of `(n, 3)` points, n >= 3; the normal points to +z (or +y, +x when level).

    Raises:
        ValueError: Fewer than three points, or all on one line.
    """
    if len(xyz) < 3:
        raise ValueError(f"a plane needs 3 points, found {len(xyz)}")
    centre = xyz.mean(axis=0)
    _, singular, axes = np.linalg.svd(xyz - centre, full_matrices=False)
    if singular[1] < 1e-9 * max(float(singular[0]), 1e-300):
        raise ValueError("the points lie on one line, they do not fix a plane")
    normal = axes[2]
    leading = normal[-1 - np.flatnonzero(np.abs(normal[::-1]) > 1e-12)[0]]
    normal = normal if leading > 0 else -normal
    return Plane((float(normal[0]), float(normal[1]), float(normal[2])), float(normal @ centre))
