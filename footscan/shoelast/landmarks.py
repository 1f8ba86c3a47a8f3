"""Points of a last, found from its shape alone, and the axis that its frame is laid along.

The same rules serve a built-in last and an imported one. Everything is in the last's frame: x heel to toe, y medial,
z up from the ground.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footscan.coordinates import Floats
from footscan.foot.crossing import find_silhouette
from footscan.foot.sections import cut_shell
from footscan.foot.shell import Shell
from footscan.shoelast.design import SEAT_SHARE
from footscan.shoelast.model import Shoelast
from footscan.shoelast.skin import BOTTOM, UPPER, LastSkin, Sampling, skin_of

MEDIAL_BAND, LATERAL_BAND = (0.62, 0.75), (0.50, 0.70)
"""Shares of the stick length within which the widest places of the ball lie (a foot's MTH1 and MTH5: 73 and 62 %)."""
INSTEP_SHARE = 0.676
"""The instep point over the heel-to-ball length: 50 % of a foot's length, where its ball lies at 74 %."""
TREAD_BAND = (0.5, 0.85)
_STEPS, _NEAR_SHARE = 170, 6e-4
MARK_SAMPLING = Sampling(256, 96, 24)


@dataclass(frozen=True)
class Body:
    """What landmarks and dimensions are taken from.

    Attributes:
        shoelast: The last.
        skin: Its sampled surface.
        shell: The same for cuts.
        centre_line: `(k, 3)` the middle of the bottom from heel to toe.
    """

    shoelast: Shoelast
    skin: LastSkin
    shell: Shell
    centre_line: Floats

    @cached_property
    def reach(self) -> tuple[Floats, Floats]:
        """How far the upper reaches to either side: `(k,)` x and `(k, 2)` lowest and highest y there."""
        step = self.stick_mm / _STEPS
        faces = np.ascontiguousarray(self.skin.faces[self.skin.patch == UPPER])
        xy = np.ascontiguousarray(self.shell.xyz[:, :2])
        x = self.back_mm + step * np.arange(1, _STEPS, dtype=np.float64)
        return x, find_silhouette(xy, faces, float(x[0]), step, _STEPS - 1)

    @cached_property
    def stick_mm(self) -> float:
        """Extent along x."""
        return float(np.ptp(self.shell.xyz[:, 0]))

    @cached_property
    def back_mm(self) -> float:
        """X of the rearmost skin."""
        return float(self.shell.xyz[:, 0].min())


def body_of(shoelast: Shoelast, sampling: Sampling = MARK_SAMPLING) -> Body:
    """Sample a last for measuring."""
    skin = skin_of(shoelast, sampling)
    middle = shoelast.bottom.grid(np.linspace(0.0, 1.0, 401), np.array([0.5]))[:, 0]
    return Body(shoelast, skin, Shell(skin.xyz_shoelast, np.ascontiguousarray(skin.faces)), middle)


def find_points(body: Body) -> Mapping[str, Floats]:
    """Name -> `(3,)` of every point; see `POINTS`."""
    upper, cone = body.shoelast.upper, np.arange(512) / 512
    feather, edge = upper.grid(cone, np.array([0.0, 1.0]))
    medial, lateral = find_ball(body)
    ends = body.shell.xyz[[body.shell.xyz[:, 0].argmin(), body.shell.xyz[:, 0].argmax()]]
    instep_x = body.back_mm + INSTEP_SHARE * (medial[0] - body.back_mm)
    return {
        "heel_point": feather[feather[:, 0].argmin()],
        "rear_point": ends[0],
        "toe_point": ends[1],
        "toe_feather_point": feather[feather[:, 0].argmax()],
        "seat_point": find_seat(body),
        "tread_point": find_tread(body),
        "ball_medial": medial,
        "ball_lateral": lateral,
        "instep_point": _top_of_cut(body, np.array([instep_x, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])),
        "cone_front": edge[edge[:, 0].argmax()],
        "cone_back": edge[edge[:, 0].argmin()],
    }


POINTS = {
    "heel_point": "rearmost place of the feather edge",
    "rear_point": "rearmost place of the last",
    "toe_point": "foremost place of the last",
    "toe_feather_point": "foremost place of the feather edge",
    "seat_point": "middle of the bottom at 16 % of the stick length",
    "tread_point": "lowest place of the bottom's middle between 50 and 85 % of the stick length",
    "ball_medial": "most medial place of the upper at 62-75 % of the stick length",
    "ball_lateral": "most lateral place of the upper at 50-70 % of the stick length",
    "instep_point": "top of the cut across the axis at 67.6 % of the heel-to-ball length",
    "waist_point": "top of the cut by the waist plane",
    "cone_front": "foremost place of the cone edge",
    "cone_back": "rearmost place of the cone edge",
}


def find_ball(body: Body) -> tuple[Floats, Floats]:
    """The widest places of the upper at the ball, medial and lateral, `(3,)` each."""
    return _widest(body, MEDIAL_BAND, 1.0), _widest(body, LATERAL_BAND, -1.0)


def _widest(body: Body, band: tuple[float, float], sign: float) -> Floats:
    """The middle of where the outline is widest in a band, places weighted by how near they come to the widest.

    The weights make it move smoothly with the shape, also where the outline is nearly straight.
    """
    x, reach = body.reach
    y = sign * reach[:, 1 if sign > 0 else 0]
    share = (x - body.back_mm) / body.stick_mm
    inside = (share > band[0]) & (share < band[1])
    weight = np.exp((y[inside] - y[inside].max()) / (_NEAR_SHARE * body.stick_mm))
    at = float((x[inside] * weight).sum() / weight.sum())
    cut = cut_shell(body.shell, np.array([at, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])).xyz.reshape(-1, 3)
    return np.array([at, *cut[(sign * cut[:, 1]).argmax()][1:]])


def find_tread(body: Body) -> Floats:
    """The tread point `(3,)`, where the last stands."""
    share = (body.centre_line[:, 0] - body.back_mm) / body.stick_mm
    band = body.centre_line[(share > TREAD_BAND[0]) & (share < TREAD_BAND[1])]
    return band[band[:, 2].argmin()]


def find_seat(body: Body) -> Floats:
    """The seat point `(3,)`, whose height is the pitch."""
    x, line = body.back_mm + SEAT_SHARE * body.stick_mm, body.centre_line
    return np.array([np.interp(x, line[:, 0], line[:, k]) for k in range(3)])


def _top_of_cut(body: Body, origin: Floats, normal: Floats) -> Floats:
    cut = cut_shell(body.shell, origin, normal).xyz.reshape(-1, 3)
    return cut[cut[:, 2].argmax()]


def axis_yaw_rad(body: Body) -> tuple[float, Floats]:
    """How far the last's axis is turned from x, counter-clockwise seen from above, and where it passes the heel.

    The axis runs from the middle of the heel's width (16 % of the stick length) to the middle of the ball's.
    """
    x, reach = body.reach
    heel_x = body.back_mm + SEAT_SHARE * body.stick_mm
    heel = np.array([heel_x, np.interp(heel_x, x, reach.mean(axis=1))])
    medial, lateral = find_ball(body)
    along = 0.5 * (medial + lateral)[:2] - heel
    return float(np.arctan2(along[1], along[0])), heel


def lowest_bottom_mm(body: Body) -> float:
    """Z of the tread point."""
    return float(find_tread(body)[2])


def bottom_faces(body: Body) -> Shell:
    """The bottom alone."""
    return Shell(body.shell.xyz, np.ascontiguousarray(body.shell.faces[body.skin.patch == BOTTOM]))
