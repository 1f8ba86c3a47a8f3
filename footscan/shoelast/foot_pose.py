"""A flat foot set on a last: insole stack, articulated bend, and what of sections and lengths changed.

The foot is bent along its sole: a place (x, y, z) of the flat foot goes to the place x of the bent line, z above it. A
section across the foot stays congruent to itself, so its area is kept exactly; only the distances between sections
change, by 1 - (z - neutral height) times the bend. The neutral height is half the ball's.
"""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.errors import QualityError
from footscan.foot.foot_frame import FootFrame
from footscan.foot.sections import cut_shell, measure_cut, plane_through_points
from footscan.foot.shell import Shell, volume_mm3
from footscan.foot.sole_bend import Bend, BentFoot
from footscan.shoelast.foot_pose_joints import JOINTS, Joints, fit_bend
from footscan.shoelast.foot_pose_mapping import PlacedFoot
from footscan.shoelast.model import Shoelast
from footscan.shoelast.pitch_of_scan import pitch_reason
from footscan.shoelast.prepared_foot import PreparedFoot

UNPROVEN = "A scan on the flat board does not prove the shape of the foot on its pitch: the bend is a model."
ON_WEDGE = (
    "The foot was scanned on a wedge of {wedge:.0f} mm and the last lifts its heel by {pitch:.0f} mm: only the "
    "difference is bent, and only that is a model."
)
_HEEL, _MIDFOOT, _HALLUX, _TOES = 0.13, 0.45, 0.86, 0.95
"""Middle of the heel, midfoot joint, hallux joint and middle of the toes, as shares of the foot length."""
_BACK_HEIGHT_MM = 20.0
_LINE = 801
_THROUGH_MM = 1.0
"""A sole that stands further below the bottom than this is told."""


@dataclass(frozen=True)
class InsoleStack:
    """Thickness (mm) of what lies between foot and last: at heel, midfoot, ball and toes."""

    heel_mm: float = 3.0
    midfoot_mm: float = 3.0
    ball_mm: float = 3.0
    toe_mm: float = 3.0

    def at(self, share: Floats) -> Floats:
        """Thickness `(n,)` at shares of the foot length."""
        return np.interp(
            share, [_HEEL, _MIDFOOT, 0.7, _TOES], [self.heel_mm, self.midfoot_mm, self.ball_mm, self.toe_mm]
        )


@dataclass(frozen=True)
class PosedFoot:
    """A foot on a last, in the last's frame.

    Attributes:
        foot: As it was scanned.
        shell: Its skin, bent and set down; same vertices and faces.
        points: Its landmarks, moved likewise.
        bend: The joints' angles.
        stack: The insole under it.
        changes: What the bend changed, in words and numbers.
        remarks: What a reader must know: that a flat scan does not prove the pitched shape, or on which wedge the foot
            was scanned.
    """

    foot: PreparedFoot
    shell: Shell
    points: dict[str, Floats]
    bend: Bend
    stack: InsoleStack
    changes: dict[str, float]
    remarks: tuple[str, ...]


def bottom_line(shoelast: Shoelast) -> Floats:
    """The middle of the bottom from heel to toe, `(n, 3)`."""
    return shoelast.bottom.grid(np.linspace(0.0, 1.0, _LINE), np.array([0.5]))[:, 0]


def pose_foot(
    foot: PreparedFoot, shoelast: Shoelast, stack: InsoleStack | None = None, joints: Joints | None = None
) -> PosedFoot:
    """Bend a foot on to a last and set it on the insole, its back at the last's back.

    Args:
        foot: As scanned.
        shoelast: With its points (`shoelast.points`).
        stack: Insole; None for 3 mm everywhere.
        joints: What each joint may do; None for all free.

    Raises:
        QualityError: The pitch is beyond what the scan, on the flat board or on a wedge, may be bent to.
    """
    stack, joints = stack or InsoleStack(), joints or Joints()
    line = bottom_line(shoelast)
    pitch = _checked_pitch(foot, shoelast, stack)
    length, ball = foot.value("foot_length"), ball_place(foot)
    places = np.array([_MIDFOOT * length, ball, max(_HALLUX * length, ball + 0.06 * length)])
    ends = (_HEEL * length, max(_TOES * length, places[2] + 0.03 * length))
    back = float(shoelast.points["rear_point"][0])
    ground = _ground(line, back, stack, length)
    wanted, raised = _wanted(ground, places, ends)
    bend = fit_bend(joints, places, ends, length, wanted, raised)
    neutral = _neutral_mm(foot)
    bent = BentFoot(bend, ball, neutral, length, float(foot.shell.xyz[:, 0].max()))
    placed = _set_down(bent, ground, back, ends[0], ball)
    shell = Shell(placed(foot.shell.xyz), foot.shell.faces, foot.shell.origin)
    points = {name: placed(xyz[None])[0] for name, xyz in foot.points.items()}
    under = foot.wedge
    said = UNPROVEN if under is None else ON_WEDGE.format(wedge=under.height_mm, pitch=pitch)
    remarks = (said, *(_stiff_remarks(joints, ground, placed, length, stack)))
    return PosedFoot(foot, shell, points, bend, stack, _changes(foot, placed, shell), remarks)


def ball_place(foot: PreparedFoot) -> float:
    """Where along the foot the middle lies between both metatarsal heads."""
    return float(0.5 * (foot.points["metatarsale_tibiale"][0] + foot.points["metatarsale_fibulare"][0]))


def _checked_pitch(foot: PreparedFoot, shoelast: Shoelast, stack: InsoleStack) -> float:
    """By how much last and insole lift the heel; refuses a bend further than the scan allows."""
    wanted = float(shoelast.points["seat_point"][2] - shoelast.points["tread_point"][2]) + stack.heel_mm - stack.ball_mm
    if reason := pitch_reason(foot, wanted):
        raise QualityError(f"on the last {shoelast.name} {reason}.")
    return wanted


def _neutral_mm(foot: PreparedFoot) -> float:
    """Half the ball's height; that of the wedge's bend where the foot stood on one, so that both bends cancel."""
    if foot.wedge is not None:
        return foot.wedge.neutral_mm
    return 0.5 * (foot.measurements["ball_height"].value or 0.14 * foot.value("foot_length"))


@dataclass(frozen=True)
class _Ground:
    """What the sole is to lie on: height of bottom and insole over places along the foot."""

    x: Floats
    z: Floats

    def height(self, x: Floats) -> Floats:
        return np.interp(x, self.x, self.z)


def _ground(line: Floats, back: float, stack: InsoleStack, length: float) -> _Ground:
    order = np.argsort(line[:, 0])
    x, z = line[order, 0], line[order, 2]
    return _Ground(x, z + stack.at((x - back) / length))


def _wanted(ground: _Ground, places: Floats, ends: tuple[float, float]) -> tuple[Floats, float]:
    """Directions under the four segments, and how much higher than the ball the heel is to lie."""
    knots = np.concatenate([[ends[0]], places, [ends[1]]])
    z = ground.height(ground.x[0] + knots)
    near = ground.height(ground.x[0] + np.array([0.4 * ends[0], 2.0 * ends[0]]))
    wanted = np.arctan(np.diff(z) / np.diff(knots))
    wanted[0] = np.arctan((near[1] - near[0]) / (1.6 * ends[0]))
    return wanted, float(z[0] - z[2])


def _set_down(bent: BentFoot, ground: _Ground, back: float, heel: float, ball: float) -> PlacedFoot:
    """Lay the sole's places under heel and ball on the insole, the back of the foot at the last's back."""
    places = np.array([[heel, 0.0, 0.0], [ball, 0.0, 0.0], [0.0, 0.0, _BACK_HEIGHT_MM]])
    turn, shift = 0.0, np.array([back, 0.0, 0.0])
    for _ in range(6):
        at = PlacedFoot(bent, turn, shift)(places)
        gap = ground.height(at[:, 0]) - at[:, 2]
        turn += float((gap[1] - gap[0]) / (at[1, 0] - at[0, 0]))
        at = PlacedFoot(bent, turn, shift)(places)
        lift = float(ground.height(at[1:2, 0])[0] - at[1, 2])
        shift = shift + np.array([back - at[2, 0], 0.0, lift])
    return PlacedFoot(bent, turn, shift)


def _stiff_remarks(
    joints: Joints, ground: _Ground, placed: PlacedFoot, length: float, stack: InsoleStack
) -> tuple[str, ...]:
    """Where the sole stands off or dips in because joints could not bend far enough."""
    stiff = [f"{name} {getattr(joints, name)}" for name in (*JOINTS, "ankle") if getattr(joints, name) != "free"]
    if not stiff:
        return ()
    x = np.linspace(0.05, 0.95, 46) * length
    sole = placed(np.column_stack([x, np.zeros_like(x), np.zeros_like(x)]))
    gap = sole[:, 2] - ground.height(sole[:, 0])
    worst = int(np.abs(gap).argmax())
    where = "above" if gap[worst] > 0 else "below"
    said = f"{', '.join(stiff)}: at {x[worst]:.0f} mm the sole lies {abs(gap[worst]):.1f} mm {where} the insole"
    through = -gap - stack.at(x / length)
    deepest = int(through.argmax())
    if through[deepest] <= _THROUGH_MM:
        return (f"{said}.",)
    return (
        f"{said}; at {x[deepest]:.0f} mm it would stand {through[deepest]:.1f} mm below the last's bottom. Take a last "
        "with less toe spring or pitch, or a thicker insole there: the bottom is held and the sole is not proved.",
    )


def _as_scanned(foot: PreparedFoot, xyz_flat: Floats) -> Floats:
    """Places `(n, 3)` of the foot turned back where the scan had them, in the foot frame without the turn back."""
    frame = foot.frame
    return FootFrame(frame.foot_from_input).to_foot(frame.to_input(xyz_flat))


def _changes(foot: PreparedFoot, placed: PlacedFoot, shell: Shell) -> dict[str, float]:
    """What the bend changed of the foot as scanned: sections across, the dorsum over the ball, length, volume."""
    length = foot.value("foot_length")
    share = np.linspace(0.45, 0.85, 13)
    dorsum = np.array([_top(foot.shell, x * length) for x in share])
    sole = np.column_stack([np.linspace(0.0, length, 101), np.zeros(101), np.zeros(101)])
    tips = np.array([foot.points["pternion"], foot.points["foremost_point"]])
    areas = {f"section_area_{s:.0%}": _area_change(foot, placed, shell, s * length) for s in (0.55, 0.65, 0.75, 0.85)}
    scanned = foot.shell.xyz if foot.wedge is None else _as_scanned(foot, foot.shell.xyz)
    before = volume_mm3(Shell(scanned, foot.shell.faces), scanned.mean(axis=0))
    return {
        **{name.replace("%", "_percent_share"): value for name, value in areas.items()},
        "dorsum_over_ball_mm": _path_mm(placed(dorsum)) - _path_mm(_as_scanned(foot, dorsum)),
        "sole_mm": _path_mm(placed(sole)) - _path_mm(_as_scanned(foot, sole)),
        "length_along_last_mm": float(np.ptp(placed(tips)[:, 0]) - np.ptp(_as_scanned(foot, tips)[:, 0])),
        "volume_share": volume_mm3(shell, shell.xyz.mean(axis=0)) / before - 1,
    }


def _top(shell: Shell, x: float) -> Floats:
    cut = cut_shell(shell, np.array([x, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])).xyz.reshape(-1, 3)
    return cut[cut[:, 2].argmax()]


def _area_change(foot: PreparedFoot, placed: PlacedFoot, shell: Shell, x: float) -> float:
    """Relative change of the area of the section across the flat foot at x."""
    corners = np.array([[x, 0.0, 10.0], [x, 10.0, 10.0], [x, 0.0, 20.0]])
    origin, normal = plane_through_points(placed(corners))
    before = measure_cut(foot.shell, corners[0], np.array([1.0, 0.0, 0.0])).area_mm2
    return measure_cut(shell, origin, normal).area_mm2 / before - 1.0


def _path_mm(xyz: Floats) -> float:
    return float(np.linalg.norm(np.diff(xyz, axis=0), axis=1).sum())
