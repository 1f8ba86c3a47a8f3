"""Laying a last into its frame, and moving it as a whole."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import trimesh

from footscan.coordinates import Floats
from footscan.foot.nurbs import SplineTube
from footscan.shoelast.design import SEAT_SHARE
from footscan.shoelast.landmarks import TREAD_BAND, axis_yaw_rad, body_of, lowest_bottom_mm
from footscan.shoelast.model import Attachment, Shoelast
from footscan.shoelast.patches import ChordDisc
from footscan.shoelast.skin import Sampling

_ROUNDS, _SMALL_RAD = 6, 1e-5
TREAD_SHARE, _TREAD_SPAN = 0.665, 0.03
"""Where along the bottom a last stands, and over how much of it its slope is taken."""
_COARSE = Sampling(128, 40, 2)


def settled(shoelast: Shoelast) -> Shoelast:
    """The last with its axis on y = 0, its rearmost place at x = 0 and its tread point at z = 0.

    It must stand upright and roughly point along x.
    """
    for _ in range(_ROUNDS):
        body = body_of(shoelast, _COARSE)
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
    is level at `TREAD_SHARE` of its length.
    """
    for _ in range(2 * _ROUNDS):
        line = body_of(shoelast, _COARSE).centre_line
        angle = _slope_at_tread(line) if pitch_mm is None else _pitch_error(line, pitch_mm)
        shoelast = settled(moved(shoelast, _about_y(angle)))
        if abs(angle) < _SMALL_RAD:
            break
    return shoelast


def _slope_at_tread(line: Floats) -> float:
    share = (line[:, 0] - line[0, 0]) / (line[-1, 0] - line[0, 0])
    near = np.abs(share - TREAD_SHARE) < _TREAD_SPAN
    middle = float(np.interp(TREAD_SHARE, share, line[:, 0]))
    return float(np.arctan(np.polyfit(line[near, 0] - middle, line[near, 2], 2)[1]))


def _pitch_error(line: Floats, pitch_mm: float) -> float:
    """Angle (rad) that lowers the seat to the wanted pitch."""
    share = (line[:, 0] - line[0, 0]) / (line[-1, 0] - line[0, 0])
    seat = float(np.interp(SEAT_SHARE, share, line[:, 2]))
    front = (share > TREAD_BAND[0]) & (share < TREAD_BAND[1])
    tread = int(np.flatnonzero(front)[line[front, 2].argmin()])
    away = float(line[tread, 0] - np.interp(SEAT_SHARE, share, line[:, 0]))
    return float(np.arctan2(pitch_mm - (seat - line[tread, 2]), away))


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
