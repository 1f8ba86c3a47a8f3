"""Laying a last into its frame, and moving it as a whole."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import trimesh

from footscan.coordinates import Floats
from footscan.foot.nurbs import SplineTube
from footscan.shoelast.landmarks import (
    MARK_SAMPLING,
    Body,
    axis_yaw_rad,
    body_of,
    find_seat,
    find_tread,
    lowest_bottom_mm,
)
from footscan.shoelast.model import Attachment, Shoelast
from footscan.shoelast.patches import ChordDisc
from footscan.shoelast.skin import Sampling

_ROUNDS, _SMALL_RAD = 6, 1e-5
TREAD_SHARE, _TREAD_SPAN = 0.665, 0.03
"""Where along the bottom a last stands, and over how much of it its slope is taken."""
_SEAT = (0.05, 0.14)
_COARSE = Sampling(128, 40, 2)


def settled(shoelast: Shoelast, sampling: Sampling = _COARSE) -> Shoelast:
    """The last with its axis on y = 0, its rearmost place at x = 0 and its tread point at z = 0.

    It must stand upright and roughly point along x. Sampled coarsely, the axis is known to about 0.1 degrees.
    """
    for _ in range(_ROUNDS):
        body = body_of(shoelast, sampling)
        yaw, heel = axis_yaw_rad(body)
        turn = _about_z(-yaw)
        turn[:2, 3] = -(turn[:2, :2] @ heel)
        turn[0, 3] -= float((body.shell.xyz @ turn[0, :3]).min() + turn[0, 3])
        turn[2, 3] = -lowest_bottom_mm(body)
        shoelast = moved(shoelast, turn)
        if abs(yaw) < _SMALL_RAD:
            break
    return shoelast


def levelled(shoelast: Shoelast, pitch_mm: float | None = None) -> Shoelast:
    """The last tipped about y until it stands at a pitch, or until its bottom is level at the tread.

    A mesh does not say at which pitch it stood: unless somebody says it, a last stands where the middle of its bottom
    is level at `TREAD_SHARE` of its length. Across, its seat is level.
    """
    for _ in range(2 * _ROUNDS):
        shoelast = moved(shoelast, _about_x(-_seat_roll_rad(shoelast)))
        body = body_of(shoelast, MARK_SAMPLING)
        angle = _slope_at_tread(body.centre_line) if pitch_mm is None else _pitch_error(body, pitch_mm)
        shoelast = settled(moved(shoelast, _about_y(angle)), MARK_SAMPLING)
        if abs(angle) < _SMALL_RAD:
            break
    return shoelast


def _seat_roll_rad(shoelast: Shoelast) -> float:
    """How far the bottom rises towards medial behind the seat point, over which the shank does not twist yet."""
    lateral, medial = shoelast.bottom.grid(np.linspace(0.0, 1.0, 401), np.array([0.0, 1.0])).swapaxes(0, 1)
    if medial[:, 1].sum() < lateral[:, 1].sum():
        lateral, medial = medial, lateral
    share = (lateral[:, 0] - lateral[0, 0]) / (lateral[-1, 0] - lateral[0, 0])
    across = (medial - lateral)[(share > _SEAT[0]) & (share < _SEAT[1])].sum(axis=0)
    return float(np.arctan2(across[2], across[1]))


def _slope_at_tread(line: Floats) -> float:
    share = (line[:, 0] - line[0, 0]) / (line[-1, 0] - line[0, 0])
    near = np.abs(share - TREAD_SHARE) < _TREAD_SPAN
    middle = float(np.interp(TREAD_SHARE, share, line[:, 0]))
    return float(np.arctan(np.polyfit(line[near, 0] - middle, line[near, 2], 2)[1]))


def _pitch_error(body: Body, pitch_mm: float) -> float:
    """Angle (rad) that lowers the seat to the wanted pitch."""
    seat, tread = find_seat(body), find_tread(body)
    return float(np.arctan2(pitch_mm - (seat[2] - tread[2]), tread[0] - seat[0]))


def _about_x(angle_rad: float) -> Floats:
    turn = np.eye(4)
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    turn[[1, 1, 2, 2], [1, 2, 1, 2]] = [cosine, -sine, sine, cosine]
    return turn


def _about_y(angle_rad: float) -> Floats:
    turn = np.eye(4)
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    turn[[0, 0, 2, 2], [0, 2, 0, 2]] = [cosine, sine, -sine, cosine]
    return turn


def _about_z(angle_rad: float) -> Floats:
    turn = np.eye(4)
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    turn[:2, :2] = [[cosine, -sine], [sine, cosine]]
    return turn


def moved(shoelast: Shoelast, transform: Floats) -> Shoelast:
    """The last under an affine 4x4; patches, lines, points and attachments follow."""
    upper, bottom, cone = shoelast.upper, shoelast.bottom, shoelast.cone_top
    return replace(
        shoelast,
        upper=SplineTube(_apply(transform, upper.net_mm), upper.knots_v),
        bottom=ChordDisc(_apply(transform, bottom.net_mm), bottom.knots_s, bottom.knots_t),
        cone_top=ChordDisc(_apply(transform, cone.net_mm), cone.knots_s, cone.knots_t),
        lines=_moved_all(transform, shoelast.lines),
        points=_moved_all(transform, shoelast.points),
        attachments=tuple(_moved_attachment(transform, part) for part in shoelast.attachments),
    )


def _apply(transform: Floats, xyz: Floats) -> Floats:
    return xyz @ transform[:3, :3].T + transform[:3, 3]


def _moved_all(transform: Floats, named: Mapping[str, Floats]) -> dict[str, Floats]:
    return {name: _apply(transform, xyz) for name, xyz in named.items()}


def _moved_attachment(transform: Floats, part: Attachment) -> Attachment:
    mesh = trimesh.Trimesh(_apply(transform, np.asarray(part.mesh.vertices)), part.mesh.faces, process=False)
    return Attachment(part.kind, mesh)
