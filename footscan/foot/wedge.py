"""A foot scanned with its heel on a wedge, and the same foot with its rearfoot turned back on to the flat board.

The wedge is a ramp: its thin edge lies under the ball's (MTP) line, its top rises straight to under the heel, and ball
and toes stand on the board. The rearfoot is turned back about the ball's line by the beam bend of `sole_bend` (decision
64) in the other direction; ball and toes stay where they are, the top of the ramp becomes z = 0, and the leg, which
stood upright on the wedge, stands upright again.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from footscan.config import MOST_WEDGE_MM
from footscan.coordinates import Floats
from footscan.errors import MeshError
from footscan.foot.sole_bend import Bend, BentFoot

FLAT_MM = 2.0
"""A wedge no higher than this counts as the flat board."""
HEEL_SHARE = 0.13
"""Middle of the heel as a share of the foot length: there the height of a wedge is taken."""
NEUTRAL_SHARE = 0.07
"""Height at which lengths are kept, as a share of the foot length, until the ball's height is known."""
HALF_STEP_SHARE = 0.08
"""The bend is spread over this share of the foot length to either side of the ball's line."""
_MOST_ANKLE_RAD = 0.35
"""The leg is turned by at most this; a wedge that bends the ankle further leaves it leaning back."""


@dataclass(frozen=True)
class Wedge:
    """Where a wedge lies under a foot, in the input's coordinates (mm, z = 0 the board).

    Attributes:
        height_mm: Of its top under the middle of the heel, as declared.
        slope_rad: Of its top.
        heel_xy: The pternion from above, with the rearfoot turned back.
        forward_xy: Unit direction down the ramp, heel to toe.
        joint_mm: The ball's line, from the pternion along the foot turned back.
        length_mm: Of the foot turned back.
        neutral_mm: Height at which lengths are kept: half the ball's.
        seen: Whether slope and thin edge are those of a top that was seen; else it is taken to end under the ball.
    """

    height_mm: float
    slope_rad: float
    heel_xy: tuple[float, float]
    forward_xy: tuple[float, float]
    joint_mm: float
    length_mm: float
    neutral_mm: float
    seen: bool = False

    @property
    def edge_xy(self) -> Floats:
        """A place `(2,)` of the thin edge."""
        return np.array(self.heel_xy) + self.edge_mm * np.array(self.forward_xy)

    @property
    def edge_mm(self) -> float:
        """Where the thin edge lies, from the pternion of the foot turned back."""
        return self.joint_mm + edge_ahead_mm(self.slope_rad, self.length_mm, self.neutral_mm)

    def flat(self, xyz_input: Floats) -> Floats:
        """Places `(n, 3)` with the rearfoot turned back on to the board."""
        return self._to_input(self._bent_foot().flat(self._to_local(xyz_input)))

    def bent(self, xyz_flat: Floats) -> Floats:
        """Places `(n, 3)` as they were on the wedge: the inverse of `flat`."""
        return self._to_input(self._bent_foot()(self._to_local(xyz_flat)))

    def _bent_foot(self) -> BentFoot:
        half = HALF_STEP_SHARE * self.length_mm
        bend = wedge_bend(self.slope_rad, self.joint_mm, self.length_mm)
        return BentFoot(bend, self.joint_mm + half, self.neutral_mm, self.length_mm, self.length_mm + half)

    def _axes(self) -> Floats:
        x, y = self.forward_xy
        return np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]])

    def _to_local(self, xyz: Floats) -> Floats:
        return (np.asarray(xyz, dtype=np.float64) - np.array([*self.heel_xy, 0.0])) @ self._axes().T

    def _to_input(self, xyz_local: Floats) -> Floats:
        return xyz_local @ self._axes() + np.array([*self.heel_xy, 0.0])


def wedge_bend(slope_rad: float, joint_mm: float, length_mm: float) -> Bend:
    """The bend of a foot whose rearfoot stands on a ramp and whose toes lie on the board."""
    ankle = min(slope_rad, _MOST_ANKLE_RAD)
    return Bend(-slope_rad, np.array([slope_rad]), np.array([joint_mm]), HALF_STEP_SHARE * length_mm, -ankle)


def edge_ahead_mm(slope_rad: float, length_mm: float, neutral_mm: float) -> float:
    """How far ahead of the bent joint's place the ramp's top meets the board (mostly negative: behind it)."""
    half = HALF_STEP_SHARE * length_mm
    t = np.linspace(-half, half, 401)
    theta = wedge_bend(slope_rad, 0.0, length_mm).direction(t)
    run = float(np.trapezoid(np.cos(theta), t))
    rise = float(np.trapezoid(np.sin(theta), t))
    meets = half - run - rise / float(np.tan(slope_rad))
    return meets - neutral_mm * float(np.tan(0.5 * slope_rad))


def slope_of_height(height_mm: float, joint_mm: float, length_mm: float, neutral_mm: float) -> float:
    """Slope (rad) of a ramp from the ball's line to a height under the middle of the heel.

    Raises:
        MeshError: No ramp of that length rises so high.
    """
    reach, slope = joint_mm - HEEL_SHARE * length_mm, 0.2
    for _ in range(50):
        along = reach + neutral_mm * float(np.tan(0.5 * slope))
        if height_mm >= 0.9 * along:
            raise MeshError(
                f"a wedge of {height_mm:g} mm under a foot of {length_mm:.0f} mm cannot end under its ball: "
                f"at most {0.9 * along:.0f} mm; say the height under the middle of the heel."
            )
        slope = float(np.arcsin(height_mm / along))
    return slope


def height_of_slope(wedge: Wedge) -> float:
    """Height of the ramp's top under the middle of the heel: the inverse of `slope_of_height`."""
    along = wedge.joint_mm - HEEL_SHARE * wedge.length_mm + wedge.neutral_mm * float(np.tan(0.5 * wedge.slope_rad))
    return along * float(np.sin(wedge.slope_rad))


def check_wedge_height(height_mm: float) -> float:
    """A height somebody declared.

    Raises:
        MeshError: Not between 0 and `MOST_WEDGE_MM`.
    """
    if not 0.0 <= height_mm <= MOST_WEDGE_MM:
        raise MeshError(f"a wedge of {height_mm:g} mm was declared, allowed are 0 (flat board) to {MOST_WEDGE_MM:g} mm")
    return height_mm


def wedge_json(wedge: Wedge | None) -> dict[str, object] | None:
    """What files say of a wedge; None for the flat board."""
    if wedge is None:
        return None
    content: dict[str, object] = asdict(wedge)
    return content | {"heel_xy": list(wedge.heel_xy), "forward_xy": list(wedge.forward_xy)}


def wedge_from_json(content: Mapping[str, Any] | None) -> Wedge | None:
    """The inverse of `wedge_json`.

    Raises:
        KeyError: Something is missing; ValueError or TypeError: something is no number.
    """
    if content is None:
        return None
    heel, forward = (tuple(float(x) for x in content[name]) for name in ("heel_xy", "forward_xy"))
    (heel_x, heel_y), (forward_x, forward_y) = heel, forward
    return Wedge(
        height_mm=float(content["height_mm"]),
        slope_rad=float(content["slope_rad"]),
        heel_xy=(heel_x, heel_y),
        forward_xy=(forward_x, forward_y),
        joint_mm=float(content["joint_mm"]),
        length_mm=float(content["length_mm"]),
        neutral_mm=float(content["neutral_mm"]),
        seen=bool(content["seen"]),
    )


def set_flat(xyz: Floats, wedge: Wedge | None) -> Floats:
    """Places `(n, 3)` as if the foot stood on the flat board."""
    return xyz if wedge is None else wedge.flat(xyz)


def set_on_wedge(xyz: Floats, wedge: Wedge | None) -> Floats:
    """The inverse of `set_flat`."""
    return xyz if wedge is None else wedge.bent(xyz)
