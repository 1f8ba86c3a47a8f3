"""The bent line of a foot's sole, and where every place of the flat foot goes with it."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_simpson

from footscan.coordinates import Floats
from footscan.shoelast.foot_pose_joints import Bend, smooth_step

_ANKLE_BAND = (0.26, 0.42)
"""Heights, as shares of the length, over which the leg's own direction takes over."""
_ANKLE = (0.22, 0.26)
"""Place and height of the ankle's axis, as shares of the length."""
_LEG_FRONT = (0.44, 0.66)
"""Along the foot, as shares of the length, over which the turn of the leg fades out."""
_LINE = 801


class BentFoot:
    """Places of the flat foot carried along its bent sole; the ball's neutral place stays where it is.

    A place (x, y, z) goes to the place x of the bent line, z above it. A section across the foot stays congruent to
    itself, so its area is kept exactly; distances between sections change by 1 - (z - neutral height) times the bend.
    """

    def __init__(self, bend: Bend, ball_mm: float, neutral_mm: float, length_mm: float, reach_mm: float) -> None:
        """Build the line.

        Args:
            bend: Its directions.
            ball_mm: Place that stays.
            neutral_mm: Height at which lengths are kept.
            length_mm: Of the foot.
            reach_mm: Largest x to be carried.
        """
        self._bend, self._neutral, self._length = bend, neutral_mm, length_mm
        self._x = np.linspace(-40.0, reach_mm + 20.0, _LINE)
        theta = bend.direction(self._x)
        run, rise = (cumulative_simpson(f(theta), x=self._x, initial=0.0) for f in (np.cos, np.sin))
        self._run = run - np.interp(ball_mm, self._x, run) + ball_mm
        self._rise = rise - np.interp(ball_mm, self._x, rise)

    def __call__(self, xyz: Floats) -> Floats:
        """Places `(n, 3)` of the bent foot."""
        bent = self._with_turned_leg(xyz)
        x, up = bent[:, 0], bent[:, 2] - self._neutral
        theta = self._bend.direction(x)
        run, rise = np.interp(x, self._x, self._run), np.interp(x, self._x, self._rise)
        return np.column_stack([run - up * np.sin(theta), bent[:, 1], self._neutral + rise + up * np.cos(theta)])

    def _with_turned_leg(self, xyz: Floats) -> Floats:
        """The leg turned about the ankle against what the heel's direction will do to it."""
        share = xyz[:, [0, 2]] / self._length
        fade = 1.0 - smooth_step((share[:, 0] - _LEG_FRONT[0]) / (_LEG_FRONT[1] - _LEG_FRONT[0]))
        turn = -self._bend.ankle_rad * fade * smooth_step((share[:, 1] - _ANKLE_BAND[0]) / np.ptp(_ANKLE_BAND))
        x, z = xyz[:, 0] - _ANKLE[0] * self._length, xyz[:, 2] - _ANKLE[1] * self._length
        return xyz + np.column_stack([turned(x, z, turn)[0] - x, np.zeros_like(x), turned(x, z, turn)[1] - z])


def turned(x: Floats, z: Floats, angle_rad: Floats | float) -> tuple[Floats, Floats]:
    """Places turned in the plane of x and z by an angle that lifts +x."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return c * x - s * z, s * x + c * z


@dataclass(frozen=True)
class PlacedFoot:
    """The bent foot turned about y (rad, +x lifted) and shifted `(3,)` into the last's frame."""

    bent: BentFoot
    turn_rad: float
    shift: Floats

    def __call__(self, xyz: Floats) -> Floats:
        """Places `(n, 3)` in the last's frame of places of the flat foot."""
        bent = self.bent(xyz)
        x, z = turned(bent[:, 0], bent[:, 2], self.turn_rad)
        return np.column_stack([x, bent[:, 1], z]) + self.shift
