"""Find where a declared wedge lies under a foot, and whether a heel stands raised that nobody declared."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Floats, Side
from footscan.errors import MeshError
from footscan.foot.align import Alignment, Front, align_foot
from footscan.foot.outline import MTH1_WINDOW, MTH5_WINDOW, find_bulge, find_outline
from footscan.foot.shape import rough_heading
from footscan.foot.shell import Shell
from footscan.foot.skin_origin import Origin
from footscan.foot.wedge import NEUTRAL_SHARE, Wedge, edge_ahead_mm, slope_of_height

_ROUNDS, _SEEN_ROUNDS = 12, 3
_SETTLED_MM, _SETTLED_RAD = 0.02, 2e-4
_BALL_SHARE = 0.68
"""Where the ball's line is sought first, and where it is taken to be when the ball is missing."""
_BESIDE_SHARE, _HIGH = 0.01, 99.0
"""The ball's height is that of the skin within this share of the length of its line, by this percentile."""
_LOW_SHARE = 0.25
_REAR_SHARE, _BALL_SHARES, _LOW = 0.22, (0.55, 0.85), 0.45
"""Rear part of the foot whose lowest skin is compared with that of the ball, in shares of the length; skin above `_LOW`
of it is leg."""
_QUESTIONED_MM, _REFUSED_MM = 5.0, 15.0
"""The lowest skin of a heel that stands flat lies at most this much higher than the ball's: 0.2 mm in real meshes."""
_TURNED_BACK_MM = 7.0
"""The same of a foot turned back: more means that it stood on another wedge."""
_SEEN_MORE_MM = 5.0
"""Where the sole was not seen, the lowest *seen* skin may differ by this much more (scans: up to 3 mm)."""


@dataclass(frozen=True)
class Lift:
    """By how much the heel's lowest skin lies above the ball's (mm), and whether only seen skin was counted."""

    height_mm: float
    seen_only: bool


def find_wedge(
    shell: Shell,
    height_mm: float,
    side: Side | None = None,
    front: Front | None = None,
    given: Mapping[str, Floats] | None = None,
) -> Wedge:
    """Place a wedge of a declared height under a foot: its thin edge under the ball's line, square to the foot axis.

    Foot axis, ball and length are those of the foot turned back, so they are found again until nothing changes.

    Args:
        shell: Skin in mm as it stood, the ball on z = 0; a cloud is a shell without faces.
        height_mm: Of the wedge under the middle of the heel.
        side: The operator's word.
        front: What is left of the front.
        given: Landmarks by hand, as they stood.

    Raises:
        MeshError: No foot, or the wedge cannot end under its ball.
    """
    wedge = guess_wedge(shell, height_mm)
    if len(shell.faces):
        check_turned_back(flat_shell(shell, wedge), wedge, 0.5 * height_mm)
    for _ in range(_ROUNDS):
        before, wedge = wedge, _again(shell, wedge, side, front, given or {})
        if _settled(before, wedge):
            break
    return wedge


def flat_shell(shell: Shell, wedge: Wedge) -> Shell:
    """The shell with its rearfoot turned back on to the board."""
    return Shell(wedge.flat(shell.xyz), shell.faces, shell.origin)


def ball_line(alignment: Alignment) -> Floats:
    """Both ends `(2, 2)` (medial, lateral) of the ball's line from above, in the foot frame.

    Without a ball it is taken to lie square to the axis where it usually is.
    """
    length = alignment.reference_mm
    if alignment.front == "ball missing":
        return np.array([[_BALL_SHARE * length, 1.0], [_BALL_SHARE * length, -1.0]])
    sides = ((MTH1_WINDOW, 1.0), (MTH5_WINDOW, -1.0))
    return np.array([find_bulge(alignment.outline, length, window, sign).xy for window, sign in sides])


def placed_under(flat: Shell, alignment: Alignment, height_mm: float, slope_rad: float | None = None) -> Wedge:
    """The wedge of a height (or of a slope) under an aligned foot that was turned back."""
    turn = alignment.foot_from_input
    heel = -turn[:2, :2].T @ turn[:2, 3]
    length, line = alignment.reference_mm, ball_line(alignment)
    joint = float(line[:, 0].mean())
    neutral = _half_ball_height(flat.xyz @ turn[:3, :3].T + turn[:3, 3], line, length)
    slope = slope_of_height(height_mm, joint, length, neutral) if slope_rad is None else slope_rad
    forward = (float(turn[0, 0]), float(turn[0, 1]))
    return Wedge(height_mm, slope, (float(heel[0]), float(heel[1])), forward, joint, length, neutral)


def ending_at(wedge: Wedge, edge_xy: Floats, forward_xy: tuple[float, float]) -> Wedge:
    """A wedge whose top was seen: with its own direction and its thin edge `(2,)`, wherever the ball lies."""
    edge_mm = float((edge_xy - np.array(wedge.heel_xy)) @ np.array(forward_xy))
    joint = edge_mm - edge_ahead_mm(wedge.slope_rad, wedge.length_mm, wedge.neutral_mm)
    return replace(wedge, forward_xy=forward_xy, joint_mm=joint, seen=True)


def settled_under(
    shell: Shell, wedge: Wedge, side: Side | None, front: Front | None, given: Mapping[str, Floats] | None = None
) -> Wedge:
    """A wedge that was found under a cloud, with length and ball of the skin fitted to it.

    Args:
        shell: The fitted skin as it stood.
        wedge: As found before.
        side: The operator's word.
        front: What is left of the front.
        given: Landmarks by hand, as they stood.
    """
    if not wedge.seen:
        return find_wedge(shell, wedge.height_mm, side, front, given)
    for _ in range(_SEEN_ROUNDS):
        flat = flat_shell(shell, wedge)
        back = _flat_marks(wedge, given or {})
        found = placed_under(flat, align_foot(flat, side, "A2", back, front), wedge.height_mm, wedge.slope_rad)
        wedge = ending_at(found, wedge.edge_xy, wedge.forward_xy)
    return wedge


def _flat_marks(wedge: Wedge, given: Mapping[str, Floats]) -> dict[str, Floats]:
    return {name: wedge.flat(np.asarray(xyz, dtype=np.float64)[None])[0] for name, xyz in given.items()}


def _half_ball_height(xyz_foot: Floats, line: Floats, length_mm: float) -> float:
    """Half the height of the skin over the ball's line."""
    along = (line[0] - line[1]) / np.linalg.norm(line[0] - line[1])
    off = np.abs((xyz_foot[:, :2] - line[1]) @ np.array([along[1], -along[0]]))
    z = xyz_foot[off < _BESIDE_SHARE * length_mm, 2]
    return 0.5 * float(np.percentile(z, _HIGH)) if len(z) else NEUTRAL_SHARE * length_mm


def _again(shell: Shell, wedge: Wedge, side: Side | None, front: Front | None, given: Mapping[str, Floats]) -> Wedge:
    flat = flat_shell(shell, wedge)
    return placed_under(flat, align_foot(flat, side, "A2", _flat_marks(wedge, given), front), wedge.height_mm)


def _settled(before: Wedge, now: Wedge) -> bool:
    turn = abs(before.forward_xy[0] * now.forward_xy[1] - before.forward_xy[1] * now.forward_xy[0])
    moved = np.hypot(*(np.array(before.heel_xy) - np.array(now.heel_xy)))
    return (
        max(moved, abs(before.joint_mm - now.joint_mm), abs(before.length_mm - now.length_mm)) < _SETTLED_MM
        and max(turn, abs(before.slope_rad - now.slope_rad)) < _SETTLED_RAD
    )


def guess_wedge(shell: Shell, height_mm: float) -> Wedge:
    """A wedge of a height under a foot, to a centimetre or two, from its outline alone.

    Raises:
        MeshError: No foot, or the wedge cannot end under its ball.
    """
    heading = rough_heading(shell, height_mm)
    low = find_outline(shell, float(shell.xyz[:, 2].min()) + height_mm + _LOW_SHARE * heading.length_mm)
    along = low.xy @ heading.xy_forward
    across = np.array([-heading.xy_forward[1], heading.xy_forward[0]])
    middle = 0.5 * float((low.xy @ across).max() + (low.xy @ across).min())
    length = heading.length_mm
    slope = slope_of_height(height_mm, _BALL_SHARE * length, length, NEUTRAL_SHARE * length)
    shortened = (_BALL_SHARE * length) * (1.0 / np.cos(slope) - 1.0)
    heel = (float(along.min()) - shortened) * heading.xy_forward + middle * across
    length = length + shortened
    slope = slope_of_height(height_mm, _BALL_SHARE * length, length, NEUTRAL_SHARE * length)
    forward = (float(heading.xy_forward[0]), float(heading.xy_forward[1]))
    place = (float(heel[0]), float(heel[1])), forward, _BALL_SHARE * length, length, NEUTRAL_SHARE * length
    return Wedge(height_mm, slope, *place)


def heel_lift(shell: Shell) -> Lift | None:
    """By how much the heel's lowest skin lies higher than the ball's; None where one of them has no skin."""
    known = shell.origin is not None
    heading = rough_heading(shell)
    xyz = shell.xyz[shell.origin == Origin.SEEN] if shell.origin is not None else shell.xyz
    z = xyz[:, 2]
    low = z < float(shell.xyz[:, 2].min()) + _LOW * heading.length_mm
    x, z = xyz[low, :2] @ heading.xy_forward, z[low]
    if not len(x):
        return None
    share = (x - x.min()) / max(float(np.ptp(x)), 1.0)
    rear, ball = z[share < _REAR_SHARE], z[(share > _BALL_SHARES[0]) & (share < _BALL_SHARES[1])]
    if not len(rear) or not len(ball):
        return None
    return Lift(float(rear.min() - ball.min()), known)


def check_turned_back(flat: Shell, wedge: Wedge, within_mm: float = 0.0) -> None:
    """Refuse a wedge on which the foot did not stand: turned back its heel lies below or above the ball.

    Args:
        flat: The skin turned back.
        wedge: The wedge.
        within_mm: How well the wedge is placed, when worse than usual.

    Raises:
        MeshError: Saying how high the heel stood, and what to do.
    """
    lift = heel_lift(flat)
    if lift is None or abs(lift.height_mm) <= max(within_mm, _TURNED_BACK_MM + _SEEN_MORE_MM * lift.seen_only):
        return
    raise MeshError(
        f"a wedge of {wedge.height_mm:g} mm was declared, but the heel stands about "
        f"{max(wedge.height_mm + lift.height_mm, 0.0):.0f} mm above the ball: declare the height under the middle of "
        "the heel as it is, 0 on the flat board."
    )


def check_level(shell: Shell) -> str | None:
    """Refuse a foot whose heel visibly stands raised though no wedge was declared; a doubt where it may.

    Returns:
        Why nothing that was measured can be relied on, or None.

    Raises:
        MeshError: Saying by how much, and what to do.
    """
    lift = heel_lift(shell)
    if lift is None:
        return None
    more = _SEEN_MORE_MM if lift.seen_only else 0.0
    what = "the lowest seen skin of the heel" if lift.seen_only else "the heel"
    if lift.height_mm > _REFUSED_MM + more:
        raise MeshError(
            f"{what} lies {lift.height_mm:.0f} mm higher than the ball: as on a wedge, but none was declared, and "
            "measured as standing flat it would come out too short. Declare the wedge (its height under the middle of "
            "the heel: --wedge MM), or set the foot flat on z = 0."
        )
    if lift.height_mm > _QUESTIONED_MM + more:
        return f"{what} lies {lift.height_mm:.0f} mm higher than the ball, and no wedge was declared"
    return None
