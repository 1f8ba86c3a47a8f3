"""Find the foot in a mesh or cloud, whatever its heading: heel, toes, side, foot axis and foot frame.

The foot frame has x from heel to toe along the foot axis, y medial, z up; its origin is the foot of the
vertical through the pternion on the board. z = 0 stays the board of the input: a foot that does not stand flat
is not pushed down.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from footscan.coordinates import Floats, Side
from footscan.errors import MeshError
from footscan.foot.outline import (
    HEEL_BREADTH_SHARE,
    MTH1_WINDOW,
    MTH5_WINDOW,
    Outline,
    find_bulge,
    find_heel,
    find_outline,
    length_from_heel,
    medial_tangent,
    shifted,
    side_at,
    turned,
)
from footscan.foot.shape import (
    check_ankle,
    check_shape,
    check_standing,
    is_stump,
    rough_heading,
    side_score,
    standing_questions,
)
from footscan.foot.shell import Shell

AxisName = Literal["A1", "A2", "A4", "A5"]
AXES: tuple[AxisName, ...] = get_args(AxisName)
AXIS_WORDS: dict[AxisName, str] = {
    "A1": "pternion to the tip of the second toe",
    "A2": "pternion to the middle between metatarsale tibiale and fibulare",
    "A4": "middle of the heel breadth to the tip of the second toe",
    "A5": "medial tangent line from heel to ball (Brannock)",
}

OUTLINE_HEIGHT_SHARE = 0.16
"""The outline from above is that of the skin below this share of the length (43 mm of 270): no ankle, no leg."""
TOE_2_SHARE = 0.42
"""Without a hand the second toe is where the front of the outline lies this share of the ball breadth from the
medial side."""
_SURE_SCORE = 0.06
_STUMP_QUESTION = (
    "The front looks like a closed stump: is it one? What needs toes or the ball is taken as not applicable.",
)

Front = Literal["whole", "toes missing", "ball missing"]
"""Without toes the search windows scale with the heel; without a ball the axis goes to the middle of the stump."""


@dataclass(frozen=True)
class Alignment:
    """Where a foot lies.

    Attributes:
        foot_from_input: 4x4; for a left foot it holds the reflection that makes y medial.
        side: The side used.
        shape_side: The side the shape looks like, None when it does not say.
        axis: The definition of the foot axis used.
        length_mm: Extent along the axis of the skin below `OUTLINE_HEIGHT_SHARE`.
        reference_mm: The length that search windows scale with: the foot's own, or, when its front is missing, at least
            what the heel breadth leads one to expect.
        front: What is left of the front.
        outline: That skin from above, in the foot frame.
        questions: What a person should answer, such as a side that contradicts the shape.
    """

    foot_from_input: Floats
    side: Side
    shape_side: Side | None
    axis: AxisName
    length_mm: float
    reference_mm: float
    front: Front
    outline: Outline
    questions: tuple[str, ...]


def align_foot(
    shell: Shell,
    side: Side | None = None,
    axis: str = "A2",
    given: Mapping[str, Floats] | None = None,
    front: Front | None = None,
) -> Alignment:
    """Find heel, toes, side and axis of a foot standing on z = 0.

    Args:
        shell: Skin in mm; a cloud is a shell without faces.
        side: The operator's word, which wins over the shape; None takes the shape's.
        axis: A1, A2, A4 or A5.
        given: Landmarks by hand, name -> `(3,)` in the input's coordinates.
        front: What is left of the front; None looks for a stump.

    Raises:
        MeshError: No foot, or an unknown axis or side.
    """
    if axis not in AXES:
        raise MeshError(
            f"foot axis {axis!r}: allowed are {', '.join(AXES)} (A6 needs a contact area, which no scan has)"
        )
    if side not in ("left", "right", None):
        raise MeshError(f"side {side!r}: allowed are left and right")
    heading = rough_heading(shell)
    check_standing(shell, heading)
    outline = find_outline(shell, OUTLINE_HEIGHT_SHARE * heading.length_mm)
    check_shape(shell, outline, heading)
    if front != "ball missing":
        check_ankle(shell, heading)
    left = front or ("ball missing" if is_stump(shell, outline, heading) else "whole")
    shape_side = None if left == "ball missing" else _side_of_score(side_score(shell, outline, heading))
    used, questions = _side(side, shape_side)
    questions += standing_questions(shell, heading.length_mm)
    questions += _STUMP_QUESTION if front is None and left == "ball missing" else ()
    mirrored = used == "left"
    marks = {name: np.asarray(xyz, dtype=np.float64)[:2] for name, xyz in (given or {}).items()}
    forward = fit_axis(outline, heading.xy_forward, axis, marks, mirrored=mirrored, front=left)
    in_frame = turned(outline, forward, mirrored=mirrored)
    length = float(np.ptp(in_frame.xy[:, 0]))
    transform = _frame(in_frame, forward, marks, mirrored=mirrored)
    in_frame = shifted(in_frame, transform[:2, 3])
    reference = _reference(in_frame, left)
    return Alignment(transform, used, shape_side, axis, length, reference, left, in_frame, questions)


def fit_axis(
    outline: Outline,
    xy_forward: Floats,
    axis: AxisName,
    marks: Mapping[str, Floats],
    *,
    mirrored: bool,
    front: Front = "whole",
) -> Floats:
    """Unit direction `(2,)` of the foot axis, from a rough one, by turning until pternion and ball agree with it."""
    start = np.stack([xy_forward, _medial(xy_forward, mirrored=mirrored)], axis=1)

    def lean(angle: float) -> float:
        """By how much the axis leans to medial in a frame turned to medial by an angle."""
        turn = start @ np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        in_frame = turned(outline, turn[:, 0], mirrored=mirrored)
        step = _axis_direction(in_frame, axis, {name: xy @ turn for name, xy in marks.items()}, front)
        return float(np.arctan2(step[1], step[0]))

    angle = _fixed_point(lean)
    return start @ np.array([np.cos(angle), np.sin(angle)])


def _fixed_point(lean: Callable[[float], float]) -> float:
    """The angle (rad) at which `lean` is 0: steps of the lean itself, and secants once they have come near."""
    before, lean_before = 0.0, lean(0.0)
    angle = lean_before
    for _ in range(60):
        now = lean(angle)
        if abs(now) < 1e-11:
            break
        slope = (now - lean_before) / (angle - before) if angle != before else -1.0
        step = -now / slope if abs(now) < 0.02 and -2.0 < slope < -0.2 else now
        before, lean_before = angle, now
        angle += step
    return angle


def _reference(outline: Outline, front: Front) -> float:
    length = float(np.ptp(outline.xy[:, 0]))
    return length if front == "whole" else max(length, length_from_heel(outline, length))


def _side_of_score(score: float) -> Side | None:
    if abs(score) < _SURE_SCORE:
        return None
    return "right" if score > 0 else "left"


def _side(side: Side | None, shape_side: Side | None) -> tuple[Side, tuple[str, ...]]:
    if side is None and shape_side is None:
        raise MeshError("the shape does not tell left from right: say which side it is (--side left or --side right)")
    if side is None:
        assert shape_side is not None
        return shape_side, (f"No side was given and the shape looks like a {shape_side} foot: is it?",)
    if shape_side is not None and shape_side != side:
        return side, (f"Given as a {side} foot, but the shape looks like a {shape_side} one: is the side right?",)
    return side, ()


def _medial(forward: Floats, *, mirrored: bool) -> Floats:
    return np.array([forward[1], -forward[0]]) if mirrored else np.array([-forward[1], forward[0]])


def _axis_direction(outline: Outline, axis: AxisName, marks: Mapping[str, Floats], front: Front) -> Floats:
    """Direction `(2,)`, of length 1, of the axis in the outline's own frame."""
    length = _reference(outline, front)
    if axis == "A5":
        return medial_tangent(outline, length)
    heel = marks.get("pternion", find_heel(outline, length).xy)
    if front == "ball missing":
        step = _middle_at(outline, 0.8 * float(np.ptp(outline.xy[:, 0]))) - heel
        return step / np.linalg.norm(step)
    medial = marks.get("metatarsale_tibiale", find_bulge(outline, length, MTH1_WINDOW, 1.0).xy)
    lateral = marks.get("metatarsale_fibulare", find_bulge(outline, length, MTH5_WINDOW, -1.0).xy)
    if axis == "A2":
        step = (medial + lateral) / 2.0 - heel
    else:
        start = heel if axis == "A1" else _middle_at(outline, HEEL_BREADTH_SHARE * length)
        step = marks.get("toe_2_tip", toe_2_place(outline, medial[1], lateral[1])) - start
    return step / np.linalg.norm(step)


def toe_2_place(outline: Outline, y_medial: float, y_lateral: float) -> Floats:
    """Where the second toe ends, `(2,)`: on the front of the outline, `TOE_2_SHARE` of the ball breadth from medial."""
    y = y_medial - TOE_2_SHARE * (y_medial - y_lateral)
    swapped = outline.xy @ np.array([[0.0, -1.0], [1.0, 0.0]])  # quarter turn: the toes point to -y
    return np.array([-side_at(swapped, np.array([y]), -1.0)[0], y])


def _middle_at(outline: Outline, from_rear_mm: float) -> Floats:
    """Middle `(2,)` of the outline's breadth at a distance from its rearmost point."""
    x = np.array([outline.xy[:, 0].min() + from_rear_mm])
    return np.array([x[0], (side_at(outline.xy, x, 1.0)[0] + side_at(outline.xy, x, -1.0)[0]) / 2.0])


def _frame(in_frame: Outline, forward: Floats, marks: Mapping[str, Floats], *, mirrored: bool) -> Floats:
    """4x4 foot_from_input: turn (and reflect), then put the pternion above the origin."""
    medial = _medial(forward, mirrored=mirrored)
    turn = np.stack([forward, medial])
    heel = turn @ marks["pternion"] if "pternion" in marks else find_heel(in_frame, float(np.ptp(in_frame.xy[:, 0]))).xy
    transform = np.eye(4)
    transform[:2, :2] = turn
    transform[:2, 3] = -heel
    return transform
