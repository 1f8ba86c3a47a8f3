"""Up to where a last has to hold the foot, and from where on it stands on the bottom: top line and feather line."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats
from footscan.geometry.nearest import PointTree
from footscan.shoelast.fitting_defaults import profile_data
from footscan.shoelast.foot_pose import PosedFoot
from footscan.shoelast.model import Shoelast

_EDGE_STEPS, _NEAR_MM = 720, 3.0


@dataclass(frozen=True)
class TopLine:
    """The plane in which the shoe's opening lies; above it the leg leaves the last and nothing is judged.

    `origin` and unit `normal` `(3,)` in the last's frame; the normal points up.
    """

    origin: Floats
    normal: Floats

    def below(self, xyz: Floats) -> Bools:
        """Which of `(n, 3)` places lie below."""
        return self.height_mm(xyz) < 0.0

    def height_mm(self, xyz: Floats) -> Floats:
        """How far `(n, 3)` places lie above it."""
        return (xyz - self.origin) @ self.normal


def find_top_line(shoelast: Shoelast, posed: PosedFoot) -> TopLine:
    """From the back, at a share of the foot length above the seat, to the dorsum in front of the instep.

    It is lowered where it would come nearer to the cone top than a margin (profiles.json).
    """
    numbers = profile_data()["top_line"]
    seat, rear = shoelast.points["seat_point"], shoelast.points["rear_point"]
    length = posed.foot.value("foot_length")
    throat = _dorsum(posed, numbers["throat_share"] * length)
    back = np.array([rear[0], 0.0, seat[2] + numbers["back_share"] * length])
    along = np.array([throat[0], 0.0, max(throat[2], back[2])]) - back
    normal = np.array([-along[2], 0.0, along[0]]) / np.hypot(along[0], along[2])
    cone = shoelast.upper.grid(np.arange(_EDGE_STEPS) / _EDGE_STEPS, np.array([1.0]))[0]
    cone = cone[cone[:, 0] < throat[0]]
    room = float(((cone - back) @ normal).min()) if len(cone) else np.inf
    return TopLine(back + min(0.0, room - numbers["cone_margin_mm"]) * normal, normal)


def _dorsum(posed: PosedFoot, x_foot: float) -> Floats:
    """The highest skin of the posed foot near a place along the flat one."""
    near = np.abs(posed.foot.shell.xyz[:, 0] - x_foot) < _NEAR_MM
    xyz = posed.shell.xyz[near]
    return xyz[xyz[:, 2].argmax()]


class FeatherLine:
    """The feather edge, for heights above it."""

    def __init__(self, shoelast: Shoelast) -> None:
        """Sample the edge of a last."""
        self.xyz = shoelast.upper.grid(np.arange(_EDGE_STEPS) / _EDGE_STEPS, np.array([0.0]))[0]
        self._tree = PointTree(np.ascontiguousarray(self.xyz[:, :2]))

    def height_mm(self, xyz: Floats) -> Floats:
        """How far `(n, 3)` places lie above the place of the edge that is nearest from above."""
        nearest = self._tree.nearest(np.ascontiguousarray(xyz[:, :2]), 1)[1][:, 0]
        return xyz[:, 2] - self.xyz[nearest, 2]

    def has_below(self, xyz: Floats) -> Bools:
        """Which of `(n, 3)` places lie above that place of the edge: quicker than their heights."""
        above = xyz[:, 2] > self.xyz[:, 2].max()
        low = np.flatnonzero(~above)
        above[low] = self.height_mm(xyz[low]) > 0.0
        return above
