"""The bend of a foot along its sole, and where every place of the flat foot goes with it, there and back.

The foot is bent as a beam: its direction theta(x) is that of the heel plus the angles of the joints, each spread over a
smooth step. A place (x, y, z) of the flat foot goes to the place x of the bent line, z above it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_simpson

from footscan.coordinates import Floats

_ANKLE_BAND = (0.26, 0.42)
"""Heights, as shares of the length, over which the leg's own direction takes over."""
_ANKLE = (0.22, 0.26)
"""Place and height of the ankle's axis, as shares of the length."""
_LEG_FRONT = (0.44, 0.66)
"""Along the foot, as shares of the length, over which the turn of the leg fades out."""
_LINE = 801
_BEHIND_MM, _AHEAD_MM = 40.0, 20.0
"""The line goes on by this much behind the heel and ahead of the toes."""
_ROUNDS = 40
_NEAR_MM = 1e-7
_LEAST_SLOPE = 0.2
"""Newton's steps are never longer than this allows: above the inside of a sharp bend places fold over one another."""


@dataclass(frozen=True)
class Bend:
    """Directions along the sole, in the plane of x and z (rad, positive rising to the toes).

    Attributes:
        heel_rad: Direction of the heel.
        joint_rad: `(k,)` angles of the joints, such as midfoot, MTP and hallux.
        place_mm: `(k,)` their places along the foot.
        half_step_mm: Half the length over which each is spread.
        ankle_rad: By how much the leg is turned back.
    """

    heel_rad: float
    joint_rad: Floats
    place_mm: Floats
    half_step_mm: float
    ankle_rad: float

    def direction(self, x: Floats) -> Floats:
        """Directions `(n,)` at places `(n,)` along the foot."""
        step = smooth_step((x[:, None] - self.place_mm) / (2.0 * self.half_step_mm) + 0.5)
        return self.heel_rad + step @ self.joint_rad


def smooth_step(t: Floats) -> Floats:
    """0 up to t = 0, 1 from t = 1 on, twice differentiable."""
    t = np.clip(t, 0.0, 1.0)
    return t**3 * (10.0 - 15.0 * t + 6.0 * t**2)


class BentFoot:
    """Places of the flat foot carried along its bent sole, and back; the neutral place above `stays_mm` stays.

    A place (x, y, z) goes to the place x of the bent line, z above it. A section across the foot stays congruent to
    itself, so its area is kept exactly; distances between sections change by 1 - (z - neutral height) times the bend.
    """

    def __init__(self, bend: Bend, stays_mm: float, neutral_mm: float, length_mm: float, reach_mm: float) -> None:
        """Build the line.

        Args:
            bend: Its directions.
            stays_mm: Place that stays, usually the ball's.
            neutral_mm: Height at which lengths are kept.
            length_mm: Of the foot.
            reach_mm: Largest x to be carried.
        """
        self._bend, self._neutral, self._length = bend, neutral_mm, length_mm
        self._x = np.linspace(-_BEHIND_MM, reach_mm + _AHEAD_MM, _LINE)
        theta = bend.direction(self._x)
        run, rise = (cumulative_simpson(f(theta), x=self._x, initial=0.0) for f in (np.cos, np.sin))
        self._run = run - np.interp(stays_mm, self._x, run) + stays_mm
        self._rise = rise - np.interp(stays_mm, self._x, rise)

    def __call__(self, xyz: Floats) -> Floats:
        """Places `(n, 3)` of the bent foot."""
        bent = self._with_turned_leg(xyz)
        x, up = bent[:, 0], bent[:, 2] - self._neutral
        theta = self._bend.direction(x)
        run, rise = self._line_at(x)
        return np.column_stack([run - up * np.sin(theta), bent[:, 1], self._neutral + rise + up * np.cos(theta)])

    def flat(self, xyz_bent: Floats) -> Floats:
        """Places `(n, 3)` of the flat foot whose bent places these are: the inverse of the call."""
        x = np.interp(xyz_bent[:, 0], self._run, self._x)
        up = xyz_bent[:, 2] - self._neutral
        for _ in range(_ROUNDS):
            theta = self._bend.direction(x)
            run, rise = self._line_at(x)
            ahead, above = xyz_bent[:, 0] - run, xyz_bent[:, 2] - self._neutral - rise
            up = above * np.cos(theta) - ahead * np.sin(theta)
            off = ahead * np.cos(theta) + above * np.sin(theta)
            slope = 1.0 - up * (self._bend.direction(x + 0.5) - self._bend.direction(x - 0.5))
            x = x + off / np.maximum(slope, _LEAST_SLOPE)
            if float(np.abs(off).max(initial=0.0)) < _NEAR_MM:
                break
        return self._with_leg_back(np.column_stack([x, xyz_bent[:, 1], self._neutral + up]))

    def _line_at(self, x: Floats) -> tuple[Floats, Floats]:
        """Run and rise of the neutral line `(n,)`, straight on beyond its ends."""
        low, high = float(self._x[0]), float(self._x[-1])
        beyond = x - np.clip(x, low, high)
        theta = self._bend.direction(np.where(beyond < 0.0, low, high)) if np.any(beyond) else np.zeros_like(x)
        run, rise = np.interp(x, self._x, self._run), np.interp(x, self._x, self._rise)
        return run + beyond * np.cos(theta), rise + beyond * np.sin(theta)

    def _with_turned_leg(self, xyz: Floats) -> Floats:
        """The leg turned about the ankle against what the heel's direction will do to it."""
        return xyz + self._turn_of_leg(xyz)

    def _turn_of_leg(self, xyz: Floats) -> Floats:
        """By how much places `(n, 3)` move when the leg is turned."""
        share = xyz[:, [0, 2]] / self._length
        fade = 1.0 - smooth_step((share[:, 0] - _LEG_FRONT[0]) / (_LEG_FRONT[1] - _LEG_FRONT[0]))
        turn = -self._bend.ankle_rad * fade * smooth_step((share[:, 1] - _ANKLE_BAND[0]) / np.ptp(_ANKLE_BAND))
        x, z = xyz[:, 0] - _ANKLE[0] * self._length, xyz[:, 2] - _ANKLE[1] * self._length
        x_turned, z_turned = turned(x, z, turn)
        return np.column_stack([x_turned - x, np.zeros_like(x), z_turned - z])

    def _with_leg_back(self, xyz: Floats) -> Floats:
        """The inverse of `_with_turned_leg`, by Newton's method from where the turn about the ankle alone leads."""
        if self._bend.ankle_rad == 0.0:
            return xyz
        found = xyz.copy()
        for _ in range(_ROUNDS):
            off = xyz - self._with_turned_leg(found)
            todo = np.abs(off).max(axis=1) > _NEAR_MM
            if not todo.any():
                break
            found[todo] += self._leg_step(found[todo], off[todo])
        return found

    def _leg_step(self, xyz: Floats, off: Floats) -> Floats:
        """Newton's step `(n, 3)` in the plane of x and z, at most 10 mm long."""
        h = 1e-3
        here = self._with_turned_leg(xyz)
        by_x = (self._with_turned_leg(xyz + np.array([h, 0.0, 0.0])) - here) / h
        by_z = (self._with_turned_leg(xyz + np.array([0.0, 0.0, h])) - here) / h
        det = by_x[:, 0] * by_z[:, 2] - by_z[:, 0] * by_x[:, 2]
        det = np.maximum(det, _LEAST_SLOPE)
        dx = (by_z[:, 2] * off[:, 0] - by_z[:, 0] * off[:, 2]) / det
        dz = (by_x[:, 0] * off[:, 2] - by_x[:, 2] * off[:, 0]) / det
        shorten = np.minimum(1.0, 10.0 / np.maximum(np.hypot(dx, dz), 1e-12))
        return np.column_stack([dx * shorten, np.zeros(len(xyz)), dz * shorten])


def turned(x: Floats, z: Floats, angle_rad: Floats | float) -> tuple[Floats, Floats]:
    """Places turned in the plane of x and z by an angle that lifts +x."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return c * x - s * z, s * x + c * z
