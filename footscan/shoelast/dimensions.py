"""Dimensions of a last and the planes its girths are taken in: the same tapes (convex hulls) as a foot's."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from footscan.coordinates import Floats
from footscan.foot.crossing import convex_hull, hull_perimeter_mm
from footscan.foot.sections import cut_shell, plane_axes
from footscan.foot.shell import Shell, volume_mm3
from footscan.shoelast.landmarks import Body, body_of, bottom_faces, find_points
from footscan.shoelast.model import Shoelast

_Y = np.array([0.0, 1.0, 0.0])
TOE_BOX_SHARE = 0.90
"""The toe box's height is taken here, as a foot's toe height is."""


@dataclass(frozen=True)
class Dimension:
    """A number with its unit (mm or cm3)."""

    value: float
    unit: Literal["mm", "cm3"] = "mm"


@dataclass(frozen=True)
class TapePlane:
    """A point of a plane `(3,)` and its unit normal `(3,)`."""

    origin: Floats
    normal: Floats


DEFINITIONS: dict[str, str] = {
    "stick_length": "rearmost to foremost place along the axis, the last standing at its pitch (no stub)",
    "bottom_length": "along the middle of the bottom, from heel to toe end of the feather edge",
    "ball_length": "rearmost place to the medial ball point, along the axis",
    "outside_ball_length": "rearmost place to the lateral ball point, along the axis",
    "ball_girth": "tape round the upright plane through both ball points",
    "waist_girth": "tape parallel to the ball plane, half-way along the axis between it and the instep plane",
    "instep_girth": "tape round the upright plane across the axis at the instep point",
    "short_heel_girth": "tape round heel point and front of the cone, square to the side view",
    "long_heel_girth": "tape round heel point and instep point, square to the side view",
    "ball_width": "across the axis, medial to lateral ball point",
    "heel_width": "width across the axis at 16 % of the stick length",
    "bottom_ball_width": "between the feather edges, along the ball plane",
    "pitch": "height of the seat point above the tread point",
    "toe_spring": "height of the toe end of the feather edge above the ground",
    "toe_box_height": "upright through the last across 90 % of the stick length",
    "cone_height": "seat point up to the rear of the cone edge",
    "cone_length": "rear to front of the cone edge, along the axis",
    "volume": "everything inside, without stub",
}


def tape_planes(points: Mapping[str, Floats]) -> dict[str, TapePlane]:
    """The planes of all girths from the named points; the same call serves a foot in the last's frame."""
    medial, lateral, instep = points["ball_medial"], points["ball_lateral"], points["instep_point"]
    across = medial - lateral
    ball = np.array([across[1], -across[0], 0.0]) / np.hypot(across[0], across[1])
    ball_x = float(ball @ medial) / ball[0]
    waist = np.array([0.5 * (ball_x + instep[0]), 0.0, 0.0])
    heel = points["heel_point"]
    return {
        "ball_girth": TapePlane(medial, ball),
        "waist_girth": TapePlane(waist, ball),
        "instep_girth": TapePlane(instep, np.array([1.0, 0.0, 0.0])),
        "short_heel_girth": TapePlane(heel, _square_to_side_view(points["cone_front"] - heel)),
        "long_heel_girth": TapePlane(heel, _square_to_side_view(instep - heel)),
    }


def _square_to_side_view(along: Floats) -> Floats:
    normal = np.cross(along, _Y)
    return normal / np.linalg.norm(normal)


def girth_mm(shell: Shell, plane: TapePlane) -> float:
    """Length of a tape round one cut; 0 where the plane misses."""
    cut = cut_shell(shell, plane.origin, plane.normal).xyz.reshape(-1, 3)
    return hull_perimeter_mm(cut @ np.stack(plane_axes(plane.normal), axis=1)) if len(cut) else 0.0


def girths_mm(body: Body, points: Mapping[str, Floats]) -> dict[str, float]:
    """Name -> tape girth."""
    return {name: girth_mm(body.shell, plane) for name, plane in tape_planes(points).items()}


def dimensions(shoelast: Shoelast) -> dict[str, Dimension]:
    """All dimensions of `DEFINITIONS`; attachments are left out of every one."""
    body = body_of(shoelast)
    return body_dimensions(body, find_points(body))


def body_dimensions(body: Body, points: Mapping[str, Floats]) -> dict[str, Dimension]:
    """The same from a sampled last and its points."""
    values = _lengths(body, points) | girths_mm(body, points) | _widths(body, points) | _heights(body, points)
    found = {name: Dimension(values[name]) for name in DEFINITIONS if name != "volume"}
    return found | {"volume": Dimension(volume_mm3(body.shell, np.zeros(3)) / 1000.0, "cm3")}


def _lengths(body: Body, points: Mapping[str, Floats]) -> dict[str, float]:
    step = np.linalg.norm(np.diff(body.centre_line, axis=0), axis=1)
    return {
        "stick_length": body.stick_mm,
        "bottom_length": float(step.sum()),
        "ball_length": float(points["ball_medial"][0] - body.back_mm),
        "outside_ball_length": float(points["ball_lateral"][0] - body.back_mm),
        "cone_length": float(points["cone_front"][0] - points["cone_back"][0]),
    }


def _widths(body: Body, points: Mapping[str, Floats]) -> dict[str, float]:
    x, reach = body.reach
    ball = tape_planes(points)["ball_girth"]
    bottom = cut_shell(bottom_faces(body), ball.origin, ball.normal).xyz.reshape(-1, 3)
    return {
        "ball_width": float(points["ball_medial"][1] - points["ball_lateral"][1]),
        "heel_width": float(np.interp(points["seat_point"][0], x, np.ptp(reach, axis=1))),
        "bottom_ball_width": float(np.ptp(bottom[:, :2] @ np.array([-ball.normal[1], ball.normal[0]]))),
    }


def _heights(body: Body, points: Mapping[str, Floats]) -> dict[str, float]:
    toe = np.array([body.back_mm + TOE_BOX_SHARE * body.stick_mm, 0.0, 0.0])
    cut = cut_shell(body.shell, toe, np.array([1.0, 0.0, 0.0])).xyz.reshape(-1, 3)
    return {
        "pitch": float(points["seat_point"][2] - points["tread_point"][2]),
        "toe_spring": float(points["toe_feather_point"][2] - points["tread_point"][2]),
        "toe_box_height": float(np.ptp(cut[:, 2])),
        "cone_height": float(points["cone_back"][2] - points["seat_point"][2]),
    }


def with_points_and_lines(shoelast: Shoelast) -> Shoelast:
    """The last with every point of `landmarks.POINTS` and its named lines, found from its shape."""
    return _with_points_and_lines(body_of(shoelast))


def with_dimensions(shoelast: Shoelast) -> tuple[Shoelast, dict[str, Dimension]]:
    """The same, and all dimensions."""
    body = body_of(shoelast)
    found = _with_points_and_lines(body)
    return found, body_dimensions(body, found.points)


def _with_points_and_lines(body: Body) -> Shoelast:
    points = dict(find_points(body))
    planes = tape_planes(points)
    waist = cut_shell(body.shell, planes["waist_girth"].origin, planes["waist_girth"].normal).xyz.reshape(-1, 3)
    points["waist_point"] = waist[waist[:, 2].argmax()]
    return replace(body.shoelast, points=points, lines=find_lines(body, planes))


def find_lines(body: Body, planes: Mapping[str, TapePlane]) -> dict[str, Floats]:
    """Name -> `(n, 3)`: edges (closed), back and front line, middle of the bottom, ball break line, tapes."""
    upper, around = body.shoelast.upper, np.linspace(0.0, 1.0, 361)
    feather, cone = upper.grid(around, np.array([0.0, 1.0]))
    ribs = upper.grid(np.array([0.0, 0.5]), np.linspace(0.0, 1.0, 201))
    lines = {
        "feather_edge": feather,
        "cone_edge": cone,
        "back_line": ribs[:, 0],
        "front_line": ribs[:, 1],
        "bottom_middle": body.centre_line,
        "ball_break_line": _across_bottom(body, planes["ball_girth"]),
    }
    tapes = {f"{name.removesuffix('_girth')}_tape": _tape(body.shell, plane) for name, plane in planes.items()}
    return lines | tapes


def _across_bottom(body: Body, plane: TapePlane) -> Floats:
    cut = cut_shell(bottom_faces(body), plane.origin, plane.normal).xyz.reshape(-1, 3)
    return cut[np.argsort(cut[:, 1])][::2]


def _tape(shell: Shell, plane: TapePlane) -> Floats:
    """The stretched tape `(n, 3)`, closed."""
    cut = cut_shell(shell, plane.origin, plane.normal).xyz.reshape(-1, 3)
    corner = cut[convex_hull(cut @ np.stack(plane_axes(plane.normal), axis=1))]
    return np.vstack([corner, corner[:1]])
