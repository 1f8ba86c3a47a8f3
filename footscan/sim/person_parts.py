"""Parts of a standing foot, found on the mesh itself: how much each vertex takes part in a motion of each of them.

The leg stands over the heel, so the end of the foot that the higher skin lies nearer to is the heel. Borders between
parts are smooth, because skin does not tear.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from footscan.coordinates import Floats

Part = Literal["foot", "heel", "midfoot", "ball", "toes", "ankle"]
PARTS: tuple[Part, ...] = ("foot", "heel", "midfoot", "ball", "toes", "ankle")
"""The whole foot with its leg, four parts of its length below the ankle, and the leg above it."""

_BOUNDS = (0.30, 0.60, 0.80)  # shares of the length from the heel
_BORDER = 0.06  # half width of a border, share of the length
_LOW, _HIGH = 0.18, 0.26  # heights, shares of the length: skin that shows the outline, skin that belongs to the leg
_ANKLE_HEIGHT = 0.27
_PIVOT_HEIGHT = 0.20  # of the ankle joint
_PIVOT_SHARE = 0.21


@dataclass(frozen=True)
class StandingFrame:
    """Where the foot stands: heel `(2,)`, unit axis `(2,)` from heel to toes, length (mm), seen from above."""

    heel_xy_world: Floats
    axis_xy_world: Floats
    length_mm: float

    def share(self, xyz_world: Floats) -> Floats:
        """Shares `(n,)` of the length from the heel."""
        return (xyz_world[:, :2] - self.heel_xy_world) @ self.axis_xy_world / self.length_mm

    @property
    def along(self) -> Floats:
        """`(3,)` from heel to toes."""
        return np.array([*self.axis_xy_world, 0.0])

    @property
    def across(self) -> Floats:
        """`(3,)` level, to the left of `along`."""
        return np.array([-self.axis_xy_world[1], self.axis_xy_world[0], 0.0])

    def place(self, share: float, height_mm: float = 0.0) -> Floats:
        """`(3,)` on the axis at a share of the length and a height above the board."""
        xy = self.heel_xy_world + share * self.length_mm * self.axis_xy_world
        return np.array([xy[0], xy[1], height_mm])


def find_frame(xyz_world: Floats) -> StandingFrame:
    """Heel, axis and length of a foot of `(n, 3)` vertices that stands on z = 0."""
    size = float(np.ptp(xyz_world[:, :2], axis=0).max())
    low = xyz_world[xyz_world[:, 2] < _LOW * size]
    centre = low[:, :2].mean(axis=0)
    axis = np.linalg.eigh(np.cov((low[:, :2] - centre).T))[1][:, -1]
    along = (low[:, :2] - centre) @ axis
    high = (xyz_world[xyz_world[:, 2] > _HIGH * size][:, :2] - centre) @ axis
    middle = 0.5 * (along.min() + along.max())
    if len(high) and high.mean() > middle:
        axis, along = -axis, -along
    begin, length = float(along.min()), float(np.ptp(along))
    return StandingFrame(centre + begin * axis, axis, length)


def part_weights(xyz_world: Floats, frame: StandingFrame) -> dict[Part, Floats]:
    """Per part `(n,)` weights in 0..1; those of heel, midfoot, ball, toes and ankle add up to 1."""
    share, height = frame.share(xyz_world), xyz_world[:, 2] / frame.length_mm
    passed = [np.ones(len(share)), *(smooth_step((share - b) / (2 * _BORDER) + 0.5) for b in _BOUNDS)]
    passed.append(np.zeros(len(share)))
    # the leg begins at the ankle's height over heel and midfoot, never over the forefoot
    leg = smooth_step((height - _ANKLE_HEIGHT) / (2 * _BORDER) + 0.5)
    leg = leg * (1.0 - smooth_step((share - 0.55) / (2 * _BORDER) + 0.5))
    parts: tuple[Part, ...] = ("heel", "midfoot", "ball", "toes")
    weights: dict[Part, Floats] = {name: (passed[i] - passed[i + 1]) * (1.0 - leg) for i, name in enumerate(parts)}
    weights["foot"], weights["ankle"] = np.ones(len(share)), leg
    return weights


def sway_weight(xyz_world: Floats, frame: StandingFrame) -> Floats:
    """`(n,)`: 0 on the foot, growing to 1 from the ankle joint upwards: what turns with the leg."""
    above = (xyz_world[:, 2] / frame.length_mm - _PIVOT_HEIGHT) / 0.16
    over = 1.0 - smooth_step((frame.share(xyz_world) - 0.55) / (2 * _BORDER) + 0.5)
    return smooth_step(above) * over


def pivot(part: Part, frame: StandingFrame) -> Floats:
    """`(3,)` the place a part turns about: heel for the whole foot, ankle joint for the leg, else its middle."""
    bounds = (0.0, *_BOUNDS, 1.0)
    match part:
        case "foot":
            return frame.place(0.12)
        case "ankle":
            return frame.place(_PIVOT_SHARE, _PIVOT_HEIGHT * frame.length_mm)
        case "toes":
            return frame.place(_BOUNDS[-1], 0.05 * frame.length_mm)
        case _:
            i = ("heel", "midfoot", "ball").index(part)
            return frame.place(0.5 * (bounds[i] + bounds[i + 1]), 0.1 * frame.length_mm)


def smooth_step(t: Floats) -> Floats:
    """0 below 0, 1 above 1, with a smooth way between."""
    t = np.clip(t, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)
