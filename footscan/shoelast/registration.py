"""Laying a posed foot into a last: back, seat and ball first, then the least loss of room over x, y and yaw.

The seat fixes the height (`foot_pose`). The back of the foot then touches the back of the last with its least room, the
middle of its ball comes near the last's ball break line, and what remains is a hinge loss: room that is missing counts
with its square, room to spare does not count. Toes have no say: heel-to-ball comes before toe length.
"""

from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Bools, Floats
from footscan.foot.shell import Shell
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.shoelast.foot_pose import PosedFoot
from footscan.shoelast.foot_samples import FootSamples
from footscan.shoelast.model import Shoelast
from footscan.shoelast.profile import Profile, room_mm
from footscan.shoelast.skin import Sampling, skin_of
from footscan.shoelast.top_line import FeatherLine, find_top_line

COARSE = Sampling(192, 64, 16)
_TOES_FROM, _BACK_TO = 1.12, 0.2
_BACK_HALVES_MM, _BACK_FEWEST, _BACK_FACES = (5.0, 8.0, 12.0, 18.0), 12, -0.3
"""The back is the strip this wide on either side of the heel's middle that faces backwards more than this; the
narrowest with that many samples, because stripes may lie far apart at the heel; where hardly any was seen, bridged skin
shows where the foot ends."""
_BACK_WEIGHT, _BALL_WEIGHT = 0.6, 0.02
"""Beside the mean square of missing room: of the back's distance from its least room, and of the ball's from the break
line."""
_ROUNDS, _MOST_STEP_MM, _MOST_YAW_RAD = 12, 6.0, np.radians(6.0)
BACK_KEPT_MM = 0.15
"""Room left behind the heel beyond the least: the back curve is held, so nothing may press on it."""


@dataclass(frozen=True)
class Registration:
    """How a posed foot was laid into a last.

    Attributes:
        x_mm: Shift forward.
        y_mm: Shift to medial.
        yaw_rad: Turn to medial about the seat point.
        back_mm: Least room behind the heel.
        ball_mm: How far the foot's ball lies in front of the last's (middle of both ball points).
        toe_mm: Room in front of the longest toe, along the last.
    """

    x_mm: float
    y_mm: float
    yaw_rad: float
    back_mm: float
    ball_mm: float
    toe_mm: float


def register(
    posed: PosedFoot, shoelast: Shoelast, samples: FootSamples, profile: Profile, *, hold_back: bool = True
) -> tuple[PosedFoot, Registration]:
    """Find x, y and yaw.

    Args:
        posed: Set on the last's bottom.
        shoelast: The last.
        samples: Of the posed foot, some thousands.
        profile: Room wanted.
        hold_back: Move the foot forward until all of its back has its least room, so that the back curve can stay.

    Returns:
        The foot where it lies now, and how it got there.
    """
    skin = skin_of(shoelast, COARSE)
    lie = _Lie(posed, shoelast, samples, profile, DistanceMesh(skin.xyz_shoelast, skin.faces))
    state = _least(lie)
    if hold_back:
        state = lie.with_free_back(state)
    moved = _moved(posed, lie.transform(state))
    behind, ball, toe = lie.gaps(state, moved)
    return moved, Registration(float(state[0]), float(state[1]), float(state[2]), behind, ball, toe)


class _Lie:
    """The residuals of a foot's lie `(x, y, yaw)`."""

    def __init__(
        self, posed: PosedFoot, shoelast: Shoelast, samples: FootSamples, profile: Profile, mesh: DistanceMesh
    ) -> None:
        below = find_top_line(shoelast, posed).below(samples.xyz)
        above = FeatherLine(shoelast).has_below(samples.xyz)
        behind = (samples.normal_foot[:, 0] < _BACK_FACES) & (samples.place < _BACK_TO)
        shown = samples.seen | (samples.bridged & behind)
        used = samples.of(shown & below & above & (samples.place < _TOES_FROM))
        self._counts = used.seen
        self._xyz, self._mesh, self._shoelast = used.xyz, mesh, shoelast
        self._least = room_mm(profile, used.place, used.normal_foot)[0]
        behind = (used.normal_foot[:, 0] < _BACK_FACES) & (used.place < _BACK_TO)
        beside_mm = np.abs(used.xyz[:, 1] - posed.points["pternion"][1])
        self._back = _middle_of(behind & used.seen, beside_mm)
        if self._back.sum() < _BACK_FEWEST:
            self._back = _middle_of(behind, beside_mm)
        self._seat = shoelast.points["seat_point"]
        self._ball = 0.5 * (posed.points["metatarsale_tibiale"] + posed.points["metatarsale_fibulare"])
        self._last_ball = 0.5 * (shoelast.points["ball_medial"] + shoelast.points["ball_lateral"])

    def transform(self, state: Floats) -> Floats:
        """4x4: turn about the seat, then shift."""
        c, s = np.cos(state[2]), np.sin(state[2])
        result = np.eye(4)
        result[:2, :2] = [[c, -s], [s, c]]
        result[:2, 3] = self._seat[:2] - result[:2, :2] @ self._seat[:2] + state[:2]
        return result

    def residuals(self, state: Floats) -> tuple[Floats, Floats]:
        """Residuals `(n + 2,)` and their derivatives `(n + 2, 3)`."""
        transform = self.transform(state)
        xyz = self._xyz @ transform[:3, :3].T + transform[:3, 3]
        near = self._mesh.nearest(xyz)
        lack = self._least + near.signed
        arm = xyz[:, :2] - self._seat[:2] - state[:2]
        slope = np.column_stack(
            [near.normal[:, 0], near.normal[:, 1], near.normal[:, 1] * arm[:, 0] - near.normal[:, 0] * arm[:, 1]]
        )
        scale = 1.0 / np.sqrt(max(int(self._counts.sum()), 1))
        lacks = (lack > 0.0) & self._counts
        rows = [scale * np.where(lacks, lack, 0.0)]
        slopes = [scale * slope * lacks[:, None]]
        if self._back.any():
            worst = np.flatnonzero(self._back)[lack[self._back].argmax()]
            rows.append(np.sqrt(_BACK_WEIGHT) * lack[[worst]])
            slopes.append(np.sqrt(_BACK_WEIGHT) * slope[[worst]])
        ball = transform[:3, :3] @ self._ball + transform[:3, 3]
        rows.append(np.sqrt(_BALL_WEIGHT) * (ball - self._last_ball)[:1])
        slopes.append(np.sqrt(_BALL_WEIGHT) * np.array([[1.0, 0.0, -(ball - self._seat)[1]]]))
        return np.concatenate(rows), np.vstack(slopes)

    def with_free_back(self, state: Floats) -> Floats:
        """The foot moved forward until its back has its least room and a little more."""
        for _ in range(8):
            transform = self.transform(state)
            back = self._xyz[self._back] @ transform[:3, :3].T + transform[:3, 3]
            if len(back) == 0:
                return state
            near = self._mesh.nearest(back)
            lack = self._least[self._back] + near.signed + BACK_KEPT_MM
            forward = np.maximum(-near.normal[:, 0], 0.3)
            step = float((lack / forward).max())
            if step <= 1e-3:
                return state
            state = state + np.array([step, 0.0, 0.0])
        return state

    def gaps(self, state: Floats, moved: PosedFoot) -> tuple[float, float, float]:
        """Room behind the heel, ball in front of ball, room in front of the toes."""
        transform = self.transform(state)
        back = self._xyz[self._back] @ transform[:3, :3].T + transform[:3, 3]
        behind = float(-self._mesh.nearest(back).signed.max()) if len(back) else float("nan")
        ball = transform[:3, :3] @ self._ball + transform[:3, 3]
        toe = float(self._shoelast.points["toe_point"][0] - moved.points["foremost_point"][0])
        return behind, float((ball - self._last_ball)[0]), toe


def _middle_of(behind: Bools, beside_mm: Floats) -> Bools:
    """The samples of the back nearest to the middle of the heel: a narrow strip, if enough of it was seen."""
    strips = [behind & (beside_mm < half) for half in _BACK_HALVES_MM]
    return next((strip for strip in strips if strip.sum() >= _BACK_FEWEST), strips[-1])


def _least(lie: _Lie) -> Floats:
    """Levenberg-Marquardt over the three numbers."""
    state = np.zeros(3)
    most = np.array([_MOST_STEP_MM, _MOST_STEP_MM, _MOST_YAW_RAD])
    size = np.array([1.0, 1.0, 100.0])  # a turn of 0.01 weighs like a millimetre
    rows, slopes = lie.residuals(state)
    damping = 1e-3
    for _ in range(_ROUNDS):
        normal = slopes.T @ slopes
        step = -np.linalg.solve(normal + damping * np.diag(1e-2 + size**2 * 1e-2), slopes.T @ rows)
        step = np.clip(step, -most, most)
        after, after_slopes = lie.residuals(state + step)
        if after @ after < rows @ rows:
            gain = float(rows @ rows - after @ after)
            state, rows, slopes, damping = state + step, after, after_slopes, max(0.2 * damping, 1e-6)
            if gain < 1e-5 * float(rows @ rows) or np.abs(step * size).max() < 2e-3:
                break
        else:
            damping *= 10.0
    return state


def _moved(posed: PosedFoot, transform: Floats) -> PosedFoot:
    xyz = posed.shell.xyz @ transform[:3, :3].T + transform[:3, 3]
    points = {name: transform[:3, :3] @ place + transform[:3, 3] for name, place in posed.points.items()}
    return replace(posed, shell=Shell(xyz, posed.shell.faces, posed.shell.origin), points=points)
