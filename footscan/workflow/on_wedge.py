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
from footscan.foot.wedge_fit import ending_at, find_wedge, guess_wedge, placed_under
from footscan.geometry.plane import Plane
from footscan.scanning.footboard import BOARD_MARGIN_MM
from footscan.scanning.ramp import Ramp, find_cells, find_ramp, find_wall

_ROUNDS = 4
_USUAL_MM = 260.0
_BALL_SHARE = 0.68
_OFF_MM, _OFF_SHARE = 4.0, 0.1
"""The wedge seen may be so much higher or lower than the declared one."""
_HIGHEST_SHARE = 0.6
_REAR_SHARES, _BELOW_MM, _MOST_BELOW = (0.45, 0.25), 2.0, 0.004
_ENOUGH = 25000
_ABOVE_MM = (12.0, 9.0, 6.0, 6.0)
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
    cells = find_cells(xyz_world, floor)
    ramp = find_ramp(cells, floor)
    try:
        if check_wedge_height(declared_mm or 0.0) <= FLAT_MM:
            return WedgeFinding(None, ramp, _undeclared(ramp, find_wall(cells, floor)))
        assert declared_mm is not None
        if ramp is None:
            wedge = _wedge_from_foot(xyz_world, floor, declared_mm, side, front)
            if find_wall(cells, floor) is None:
                _check_nothing_below(xyz_world, floor, wedge)
            return WedgeFinding(wedge, None, None, ("the wedge's top was not seen: it is taken to end under the ball",))
        return WedgeFinding(_checked(_wedge_from_ramp(xyz_world, ramp, declared_mm, side, front)), ramp)
    except MeshError as refusal:
        return WedgeFinding(None, ramp, refusal)


def _undeclared(ramp: Ramp | None, wall_mm: float | None) -> MeshError | None:
    """Why a scan for which no wedge was declared cannot be measured; None when nothing of one is seen."""
    if ramp is None and wall_mm is None:
        return None
    seen = f"an upright plane of {wall_mm or 0.0:.0f} mm stands on the board under or beside the foot"
    if ramp is not None:
        seen = f"a wedge that rises by {np.degrees(ramp.slope_rad):.0f} degrees is seen"
    return MeshError(
        f"{seen}, but no wedge was declared: measured as standing flat the foot would come out wrong. Declare its "
        "height under the middle of the heel (--wedge MM), or scan on the bare flat board."
    )


def _wedge_from_ramp(xyz_world: Floats, ramp: Ramp, height_mm: float, side: Side | None, front: Front | None) -> Wedge:
    """The wedge whose top and thin edge were seen."""
    wedge, some = _first(ramp, height_mm), _some(xyz_world)
    for _ in range(_ROUNDS):
        flat = _foot_alone(wedge, some)
        found = placed_under(flat, align_foot(flat, side, "A2", None, front), height_mm, ramp.slope_rad)
        wedge = ending_at(found, np.array(ramp.edge_xy), ramp.forward_xy)
    return wedge


def _some(xyz: Floats) -> Floats:
    """Every n-th place: enough to find length and ball."""
    return xyz[:: max(1, len(xyz) // _ENOUGH)]


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
    """The wedge under the ball of a foot of which nothing but skin (and perhaps the wedge's sides) was seen.

    At first only skin well above the wedge counts: what stands out of a wedge behind or beside the foot is no skin.
    """
    body = _some(xyz_world[floor.distance_mm(xyz_world) > BOARD_MARGIN_MM])
    wedge = guess_wedge(Shell(body, _NO_FACES), height_mm)
    for above_mm in _ABOVE_MM:
        xyz = wedge.flat(body)
        near = _standing(xyz, wedge) & (xyz[:, 2] > above_mm)
        wedge = find_wedge(Shell(body[near], _NO_FACES), height_mm, side, front)
    return wedge


def _check_nothing_below(xyz_world: Floats, floor: Plane, wedge: Wedge) -> None:
    """Refuse a wedge where skin was seen: a wedge that shows neither top nor sides hides what is below its top.

    Raises:
        MeshError: The heel stands lower than declared.
    """
    xyz = wedge.flat(_some(xyz_world[floor.distance_mm(xyz_world) > BOARD_MARGIN_MM]))
    away = xyz[:, :2] - np.array(wedge.heel_xy)
    along = away @ np.array(wedge.forward_xy)
    across = away @ np.array([-wedge.forward_xy[1], wedge.forward_xy[0]])
    rear = (along < _REAR_SHARES[0] * wedge.length_mm) & (np.abs(across) < _REAR_SHARES[1] * wedge.length_mm)
    below = rear & (xyz[:, 2] < -_BELOW_MM - 0.1 * wedge.height_mm)
    if below.sum() > _MOST_BELOW * max(int(rear.sum()), 1):
        raise MeshError(
            f"a wedge of {wedge.height_mm:g} mm was declared, but none is seen, and {below.sum() / rear.sum():.1%} "
            "of the rearfoot lies where it would be: declare the height as it is (0 on the flat board), or take "
            "a bright matt wedge wider than the foot."
        )


def _checked(wedge: Wedge) -> Wedge:
    """The wedge that was seen, when it is the declared one.

    Raises:
        MeshError: It is not.
    """
    seen, declared = height_of_slope(wedge), wedge.height_mm
    if abs(seen - declared) > max(_OFF_MM, _OFF_SHARE * declared):
        raise MeshError(
            f"a wedge of {declared:g} mm was declared, but the one that is seen is {seen:.0f} mm high under the middle "
            "of the heel: declare that height, or set the foot with its ball on the wedge's thin edge."
        )
    return wedge


def wedge_report(wedge: Wedge | None) -> dict[str, object] | None:
    """What scan.json says of the wedge: where it lies, and the height that was seen; None for the flat board."""
    content = wedge_json(wedge)
    if content is None or wedge is None:
        return None
    seen = round(height_of_slope(wedge), 2) if wedge.seen else None
    return content | {"slope_deg": round(float(np.degrees(wedge.slope_rad)), 3), "seen_height_mm": seen}
