"""Up to where a last has to hold the foot, and from where on it stands on the bottom: top line and feather line."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats
from footscan.geometry.nearest import PointTree
from footscan.shoelast.foot_pose import PosedFoot
from footscan.shoelast.model import Shoelast
from footscan.shoelast.profile import profile_data

_EDGE_STEPS = 720


@dataclass(frozen=True)
class TopLine:
    """The plane in which the shoe's opening lies; above it the leg leaves the last and nothing is judged.

    `origin` and unit `normal` `(3,)` in the last's frame; the normal points up.
    """

    origin: Floats
    normal: Floats

    def below(self, xyz: Floats) -> Bools:
        """Which of `(n, 3)` places lie below."""
        return (xyz - self.origin) @ self.normal < 0.0


def find_top_line(shoelast: Shoelast, posed: PosedFoot) -> TopLine:
    """From the back, at a share of the foot length above the seat, through the foot's instep point.

    It is lowered where it would come nearer to the cone top than a margin (profiles.json).
    """
    numbers = profile_data()["top_line"]
    seat, rear = shoelast.points["seat_point"], shoelast.points["rear_point"]
    instep = posed.points["instep_point"]
    back = np.array([rear[0], 0.0, seat[2] + numbers["back_share"] * posed.foot.value("foot_length")])
    along = np.array([instep[0], 0.0, max(instep[2], back[2])]) - back
    normal = np.array([-along[2], 0.0, along[0]]) / np.hypot(along[0], along[2])
    cone = shoelast.upper.grid(np.arange(_EDGE_STEPS) / _EDGE_STEPS, np.array([1.0]))[0]
    cone = cone[cone[:, 0] < instep[0]]
    room = float(((cone - back) @ normal).min()) if len(cone) else np.inf
    return TopLine(back + min(0.0, room - numbers["cone_margin_mm"]) * normal, normal)


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
