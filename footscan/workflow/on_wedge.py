"""Where the wedge lies on which a scanned foot stood: from its top where the scan shows it, else from the foot."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats, Side
from footscan.errors import MeshError
from footscan.foot.align import Front, align_foot
from footscan.foot.shell import Shell
from footscan.foot.wedge import (
    FLAT_MM,
    NEUTRAL_SHARE,
    Wedge,
    check_wedge_height,
    edge_ahead_mm,
    height_of_slope,
    wedge_json,
)
from footscan.foot.wedge_fit import ball_line, find_wedge, placed_under
from footscan.geometry.plane import Plane
from footscan.scanning.footboard import BOARD_MARGIN_MM
from footscan.scanning.ramp import Ramp, find_ramp

_ROUNDS = 4
_USUAL_MM = 260.0
_BALL_SHARE = 0.68
_OFF_MM, _OFF_SHARE = 4.0, 0.1
"""The wedge seen may be so much higher or lower than the declared one."""
_EDGE_SHARES = (0.05, 0.15)
"""The thin edge may lie this far (share of the length) from the ball's line: beyond the first a remark, beyond the
second refused."""
_HIGHEST_SHARE = 0.6
_NO_FACES = np.empty((0, 3), dtype=np.int64)


@dataclass(frozen=True)
class WedgeFinding:
    """What is known of the ground under a foot.

    Attributes:
        wedge: On which it stood; None for the flat board.
        ramp: The top of a wedge that the scan shows.
        refusal: Why the foot cannot be measured as it stands.
        remarks: What a reader must know.
    """

    wedge: Wedge | None = None
    ramp: Ramp | None = None
    refusal: MeshError | None = None
    remarks: tuple[str, ...] = ()


def find_ground(
    xyz_world: Floats, floor: Plane, declared_mm: float | None, side: Side | None, front: Front | None
) -> WedgeFinding:
    """Find the wedge that was declared, and refuse one that was not.

    Args:
        xyz_world: `(n, 3)` all points of the scan.
        floor: The board.
        declared_mm: Height of the wedge under the middle of the heel; None when nobody said.
        side: The operator's word.
        front: What is left of the foot's front.
    """
    ramp = find_ramp(xyz_world, floor)
    try:
        if check_wedge_height(declared_mm or 0.0) <= FLAT_MM:
            return WedgeFinding(None, ramp, None if ramp is None else _undeclared(ramp))
        assert declared_mm is not None
        if ramp is None:
            wedge = _wedge_from_foot(xyz_world, floor, declared_mm, side, front)
            return WedgeFinding(wedge, None, None, ("the wedge's top was not seen: it is taken to end under the ball",))
        wedge, ball_mm = _wedge_from_ramp(xyz_world, ramp, declared_mm, side, front)
        return WedgeFinding(wedge, ramp, None, _checked(wedge, ball_mm))
    except MeshError as refusal:
        return WedgeFinding(None, ramp, refusal)


def _undeclared(ramp: Ramp) -> MeshError:
    return MeshError(
        f"a wedge that rises by {np.degrees(ramp.slope_rad):.0f} degrees is seen, but none was declared: "
        "measured as standing flat the foot would come out wrong. Declare its height under the middle of the heel "
        "(--wedge MM), or scan on the flat board."
    )


def _wedge_from_ramp(
    xyz_world: Floats, ramp: Ramp, height_mm: float, side: Side | None, front: Front | None
) -> tuple[Wedge, float]:
    """The wedge whose top and thin edge were seen, and where along the foot the ball's line lies."""
    forward = np.array(ramp.forward_xy)
    wedge, ball_mm = _first(ramp, height_mm), 0.0
    for _ in range(_ROUNDS):
        flat = _foot_alone(wedge, xyz_world)
        alignment = align_foot(flat, side, "A2", None, front)
        found = placed_under(flat, alignment, height_mm, ramp.slope_rad)
        ball = np.append(ball_line(alignment).mean(axis=0), [0.0, 1.0])
        heel = np.array(found.heel_xy)
        ball_mm = float((np.linalg.inv(alignment.foot_from_input) @ ball)[:2] @ forward - heel @ forward)
        edge_mm = float((np.array(ramp.edge_xy) - heel) @ forward)
        joint = edge_mm - edge_ahead_mm(ramp.slope_rad, found.length_mm, found.neutral_mm)
        place = ramp.slope_rad, found.heel_xy, ramp.forward_xy, joint, found.length_mm, found.neutral_mm
        wedge = Wedge(height_mm, *place)
    return wedge, ball_mm


def _first(ramp: Ramp, height_mm: float) -> Wedge:
    joint, neutral = _BALL_SHARE * _USUAL_MM, NEUTRAL_SHARE * _USUAL_MM
    edge_mm = joint + edge_ahead_mm(ramp.slope_rad, _USUAL_MM, neutral)
    heel = np.array(ramp.edge_xy) - edge_mm * np.array(ramp.forward_xy)
    place = (float(heel[0]), float(heel[1])), ramp.forward_xy, joint, _USUAL_MM, neutral
    return Wedge(height_mm, ramp.slope_rad, *place)


def _foot_alone(wedge: Wedge, xyz_world: Floats) -> Shell:
    """What stands on board and wedge, the rearfoot turned back."""
    xyz = wedge.flat(xyz_world)
    return Shell(xyz[_standing(xyz, wedge)], _NO_FACES)


def _standing(xyz_flat: Floats, wedge: Wedge) -> Bools:
    """`(n,)` points above the board and near the foot: other bodies stand apart from it."""
    z = xyz_flat[:, 2]
    away = xyz_flat[:, :2] - np.array(wedge.heel_xy)
    along = away @ np.array(wedge.forward_xy)
    across = away @ np.array([-wedge.forward_xy[1], wedge.forward_xy[0]])
    near = (along > -0.5 * wedge.length_mm) & (along < 1.5 * wedge.length_mm) & (np.abs(across) < 0.6 * wedge.length_mm)
    return near & (z > BOARD_MARGIN_MM) & (z < _HIGHEST_SHARE * wedge.length_mm)


def _wedge_from_foot(
    xyz_world: Floats, floor: Plane, height_mm: float, side: Side | None, front: Front | None
) -> Wedge:
    """The wedge under the ball of a foot of which nothing but skin (and perhaps the wedge's sides) was seen."""
    body = xyz_world[floor.distance_mm(xyz_world) > BOARD_MARGIN_MM]
    wedge = find_wedge(Shell(body, _NO_FACES), height_mm, side, front)
    for _ in range(_ROUNDS - 1):
        body = body[_standing(wedge.flat(body), wedge)]
        wedge = find_wedge(Shell(body, _NO_FACES), height_mm, side, front)
    return wedge


def _checked(wedge: Wedge, ball_mm: float) -> tuple[str, ...]:
    """Remarks on the wedge that was seen.

    Raises:
        MeshError: It is not the declared one, or does not end under the ball.
    """
    seen, declared = height_of_slope(wedge), wedge.height_mm
    if abs(seen - declared) > max(_OFF_MM, _OFF_SHARE * declared):
        raise MeshError(
            f"a wedge of {declared:g} mm was declared, but the one that is seen is {seen:.0f} mm high under the middle "
            "of the heel: declare that height, or set the foot with its ball on the wedge's thin edge."
        )
    off = wedge.joint_mm - ball_mm
    where = f"the wedge ends {abs(off):.0f} mm {'in front of' if off > 0.0 else 'behind'} the ball's line"
    if abs(off) > _EDGE_SHARES[1] * wedge.length_mm:
        raise MeshError(
            f"{where}, at most {_EDGE_SHARES[1] * wedge.length_mm:.0f} mm can be measured: set the foot with its ball "
            "on the thin edge and scan again."
        )
    return (where,) if abs(off) > _EDGE_SHARES[0] * wedge.length_mm else ()


def wedge_report(ground: WedgeFinding) -> dict[str, object] | None:
    """What scan.json says of the wedge: where it lies, and the height that was seen; None for the flat board."""
    content = wedge_json(ground.wedge)
    if content is None or ground.wedge is None:
        return None
    seen = None if ground.ramp is None else round(height_of_slope(ground.wedge), 2)
    return content | {"slope_deg": round(float(np.degrees(ground.wedge.slope_rad)), 3), "seen_height_mm": seen}
