"""From the input's own coordinates to the foot frame and back, also for a foot that stood on a wedge."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.foot.wedge import Wedge
from footscan.geometry.plane import fit_plane

_HALF_WIDTH_MM, _HEIGHT_MM = 50.0, 80.0
_LEVEL = 0.1


@dataclass(frozen=True)
class FootFrame:
    """Where the foot frame (x heel to toe, y medial, z up from the board) lies.

    Attributes:
        foot_from_input: 4x4; a reflection for a left foot. Of a foot on a wedge: from the input with its rearfoot
            turned back.
        wedge: On which it stood; None for the flat board.
    """

    foot_from_input: Floats
    wedge: Wedge | None = None

    def to_foot(self, xyz_input: Floats) -> Floats:
        """Places `(n, 3)` in the foot frame, the rearfoot turned back when it stood on a wedge."""
        flat = xyz_input if self.wedge is None else self.wedge.flat(xyz_input)
        return flat @ self.foot_from_input[:3, :3].T + self.foot_from_input[:3, 3]

    def to_input(self, xyz_foot: Floats) -> Floats:
        """Places `(n, 3)` of the foot frame in the input's own coordinates: the inverse of `to_foot`."""
        flat = (xyz_foot - self.foot_from_input[:3, 3]) @ self.foot_from_input[:3, :3]
        return flat if self.wedge is None else self.wedge.bent(flat)

    def plane_to_input(self, origin_foot: Floats, normal_foot: Floats) -> tuple[Floats, Floats]:
        """Origin and unit normal `(3,)` in the input's coordinates of a plane of the foot frame.

        A section across the foot axis stays plane on a wedge; of another plane, the nearest one at the foot is taken.
        """
        normal = self.foot_from_input[:3, :3].T @ normal_foot
        if self.wedge is None:
            return self.to_input(origin_foot[None])[0], normal
        xyz = self.to_input(_around(origin_foot, normal_foot))
        bent = fit_plane(xyz).normal_array
        return xyz.mean(axis=0), bent if float(bent @ normal) > 0.0 else -bent


def _around(origin: Floats, normal: Floats) -> Floats:
    """Places `(25, 3)` of a plane across the foot, as broad and high as a foot."""
    across = np.cross(np.array([0.0, 0.0, 1.0]), normal)
    level = float(np.linalg.norm(across)) < 1e-6
    across = np.array([0.0, 1.0, 0.0]) if level else across / np.linalg.norm(across)
    up = np.cross(normal, across)
    up = up if up[2] >= 0.0 else -up
    sides = np.linspace(-_HALF_WIDTH_MM, _HALF_WIDTH_MM, 5) - float(origin @ across)
    rises = np.linspace(0.0, _HEIGHT_MM, 5) - (float(origin[2]) / float(up[2]) if up[2] > _LEVEL else 0.0)
    return (origin + sides[:, None, None] * across + rises[None, :, None] * up).reshape(-1, 3)
