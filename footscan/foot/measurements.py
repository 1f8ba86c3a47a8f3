"""Foot measurements: `measure(mesh, side)` gives every value with what it is worth; `measurements_json` is its
file form."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import trimesh

from footscan.coordinates import Floats, Side
from footscan.errors import MeshError
from footscan.foot.align import AXIS_WORDS, Alignment, AxisName, Front, align_foot
from footscan.foot.catalogue import CATALOGUE, NOT_MEASURABLE, Entry
from footscan.foot.foot_frame import FootFrame
from footscan.foot.landmarks import BY_HAND, NEEDS_HAND, RULES, Landmark, Landmarks, find_landmarks
from footscan.foot.readings import Reading
from footscan.foot.repair import repair_shell
from footscan.foot.shell import Shell, shell_from_mesh
from footscan.foot.sizes import NORMS, Norm, suggest_sizes, unusual_remark
from footscan.foot.standing import StandingFoot, absent_parts, front_of, stand
from footscan.foot.units import check_foot_length
from footscan.foot.wedge import FLAT_MM, Wedge, check_wedge_height, wedge_json
from footscan.foot.wedge_fit import ball_line, check_level, check_turned_back, find_wedge, flat_shell

FORMAT = "footscan-measurements/1"
ORIGIN_UNKNOWN = "the origin of the skin is unknown: below 8 mm it is taken as not seen"
UNSTATED = "unknown"
ON_WEDGE = (
    "scanned on a wedge of {height:g} mm under the heel: measured with the rearfoot turned back by {slope:.1f} degrees"
)
_BENT_ANKLE = "the ankle was bent on the wedge: its skin does not lie as on the flat board"
_BENT_BALL = "on a wedge the ball is taken to bend square to the foot axis; an oblique one makes this millimetres wrong"
_EDGE_OFF_SHARE = 0.06
"""The wedge's thin edge may lie this share of the length off the ball's line."""
_DOUBTED_ON_WEDGE = {
    **dict.fromkeys(
        (
            "ankle_girth",
            "long_heel_girth",
            "bimalleolar_breadth",
            "malleolus_medialis_height",
            "malleolus_lateralis_height",
        ),
        _BENT_ANKLE,
    ),
    **dict.fromkeys(("ball_length", "outside_ball_length", "waist_girth"), _BENT_BALL),
}


@dataclass(frozen=True)
class Measurement:
    """One value and what it is worth.

    Attributes:
        value: In `unit`, or None when there is none.
        unit: mm, deg, cm3, cm2, or 1 for a ratio.
        reliable: Whether the measuring can be relied on; it says nothing about the foot.
        reason: Why not, or a note; may be empty.
        interval: For girths: hull of the seen points alone ... hull with walls down to the board; for volume and
            surface the same bounds of the sole (`sole_bounds`).
        unusual: A remark against a named norm, None when there is none. It hides and blocks nothing.
        tape: For girths: where the tape runs.
    """

    value: float | None
    unit: str
    reliable: bool
    reason: str
    interval: tuple[float, float] | None = None
    unusual: str | None = None
    tape: "TapePlane | None" = None


@dataclass(frozen=True)
class TapePlane:
    """The plane of a tape: a point `(3,)` of it and its unit normal `(3,)`, in the input's own coordinates (mm)."""

    origin: Floats
    normal: Floats


@dataclass(frozen=True)
class PlacedLandmark:
    """A landmark `xyz` `(3,)` in the input's own coordinates (mm); `source` is auto or manual."""

    xyz: Floats
    source: str
    reason: str = ""


@dataclass(frozen=True)
class Measurements:
    """Everything measured on one foot.

    Attributes:
        side: left or right, as used.
        shape_side: What the shape looks like, None when it does not say.
        axis: The definition of the foot axis used (A1, A2, A4 or A5).
        load: As somebody said, else `unknown`.
        origin_known: Whether the mesh says which skin was seen.
        landmarks: Name -> landmark.
        measurements: Name -> value.
        not_measurable: What no scan on this machine gives, name -> why.
        sizes: Indicative shoe sizes.
        questions: What a person should answer.
        remarks: What was repaired, cut or left out.
        foot_from_input: 4x4 to the foot frame (x heel to toe, y medial, z up); a reflection for a left foot. Of a foot
            on a wedge: from the input with its rearfoot turned back (`frame`).
        wedge: On which it stood; None for the flat board.
    """

    side: Side
    shape_side: Side | None
    axis: AxisName
    load: str
    origin_known: bool
    landmarks: Mapping[str, PlacedLandmark]
    measurements: Mapping[str, Measurement]
    not_measurable: Mapping[str, str]
    sizes: Mapping[str, float | str]
    questions: tuple[str, ...]
    remarks: tuple[str, ...]
    foot_from_input: Floats
    wedge: Wedge | None = None

    @property
    def frame(self) -> FootFrame:
        """Where the foot frame lies, the wedge taken into account."""
        return FootFrame(self.foot_from_input, self.wedge)

    def __getitem__(self, name: str) -> Measurement:
        """One measurement by its name."""
        return self.measurements[name]


def measure(
    mesh: trimesh.Trimesh,
    side: Side | None = None,
    *,
    axis: str = "A2",
    landmarks: Mapping[str, Floats] | None = None,
    load: str = UNSTATED,
    absent: tuple[str, ...] = (),
    norm: Norm = "adult",
    wedge: Wedge | float | None = None,
) -> Measurements:
    """Measure a foot.

    Args:
        mesh: In mm, any heading, standing on z = 0 (the board). The vertex attribute `origin` says which skin was seen.
        side: The operator's word; it wins over the shape. None takes the shape's side and asks.
        axis: Foot axis: A1, A2 (default), A4 or A5.
        landmarks: By hand, name -> `(3,)` in the mesh's own coordinates; they win over found ones.
        load: How the foot was loaded; `unknown` unless somebody says so.
        absent: Missing parts (`standing.PARTS`): toe_1 ... toe_5, toes, ray_1, ray_5, forefoot.
        norm: Whom `unusual` compares with: adult, men, women, or none for children and declared deformities.
        wedge: The wedge under the heel: where it lies, or its height in mm under the middle of the heel (it is then
            placed under the ball's line); None or up to 2 mm for the flat board.

    Raises:
        MeshError: The mesh is no foot, its heel stands raised without a wedge, or an argument is not allowed.
    """
    if norm not in NORMS:
        raise MeshError(f"norm {norm!r}: allowed are {', '.join(NORMS)}")
    given = _checked_landmarks(landmarks or {})
    shell = shell_from_mesh(mesh)
    _check_size(shell)
    repaired = repair_shell(shell)
    shell, front = repaired.shell, front_of(absent_parts(absent))
    under = _placed_wedge(shell, wedge, side, front, given)
    if under is not None:
        shell = flat_shell(shell, under)
        check_turned_back(shell, under)
        given = {name: under.flat(xyz[None])[0] for name, xyz in given.items()}
    alignment = align_foot(shell, side, axis, given, front)
    doubt = check_level(shell) if under is None else None
    foot = stand(shell, alignment, given, absent, repaired.bridged)
    marks, missing = find_landmarks(foot)
    values = {entry.name: _measured(entry, foot, marks, missing, norm) for entry in CATALOGUE}
    length = values["foot_length"].value or alignment.length_mm
    found = Measurements(
        side=alignment.side,
        shape_side=alignment.shape_side,
        axis=alignment.axis,
        load=load,
        origin_known=shell.origin is not None,
        landmarks={},
        measurements={},
        not_measurable=NOT_MEASURABLE,
        sizes=suggest_sizes(length),
        questions=alignment.questions,
        remarks=(
            *_wedge_remarks(under, alignment),
            *((doubt,) if doubt else ()),
            *repaired.remarks,
            *foot.remarks,
            *(() if shell.origin is not None else (ORIGIN_UNKNOWN,)),
        ),
        foot_from_input=alignment.foot_from_input,
        wedge=under,
    )
    return replace(
        found,
        landmarks={name: _placed(mark, found) for name, mark in marks.items()},
        measurements={name: _in_pose(name, value, found, doubt) for name, value in values.items()},
    )


def _placed_wedge(
    shell: Shell, wedge: Wedge | float | None, side: Side | None, front: Front | None, given: Mapping[str, Floats]
) -> Wedge | None:
    if wedge is None or isinstance(wedge, Wedge):
        return wedge
    if check_wedge_height(wedge) <= FLAT_MM:
        return None
    return find_wedge(shell, wedge, side, front, given)


def _wedge_remarks(wedge: Wedge | None, alignment: Alignment) -> tuple[str, ...]:
    if wedge is None:
        return ()
    said = ON_WEDGE.format(height=wedge.height_mm, slope=np.degrees(wedge.slope_rad))
    off = wedge.joint_mm - float(ball_line(alignment)[:, 0].mean())
    if abs(off) <= _EDGE_OFF_SHARE * alignment.reference_mm:
        return (said,)
    where = "in front of" if off > 0.0 else "behind"
    return (said, f"the wedge ends {abs(off):.0f} mm {where} the ball's line: the midfoot was bent, not the ball alone")


def _in_pose(name: str, value: Measurement, found: Measurements, doubt: str | None) -> Measurement:
    """The value as of the input: its tape's plane there, and the doubts that the pose itself gives."""
    doubts = [doubt] if doubt else []
    if found.wedge is not None and name in _DOUBTED_ON_WEDGE:
        doubts.append(_DOUBTED_ON_WEDGE[name])
    tape = None if value.tape is None else TapePlane(*found.frame.plane_to_input(value.tape.origin, value.tape.normal))
    reason = "; ".join([*doubts, *([value.reason] if value.reason else [])])
    return replace(value, tape=tape, reliable=value.reliable and not doubts, reason=reason)


def definitions() -> dict[str, str]:
    """Name -> one line of definition, of every landmark and measurement."""
    return {item.name: item.definition for item in (*RULES, *CATALOGUE)}


def measurements_json(result: Measurements) -> dict[str, object]:
    """The file form (`footscan-measurements/1`): plain numbers, strings, lists and dictionaries."""
    return {
        "format": FORMAT,
        "side": result.side,
        "shape_side": result.shape_side,
        "axis": result.axis,
        "axis_definition": AXIS_WORDS[result.axis],
        "load": result.load,
        "origin_of_skin": "known" if result.origin_known else UNSTATED,
        "landmarks": {
            name: {"xyz": [float(x) for x in mark.xyz], "source": mark.source, "reason": mark.reason}
            for name, mark in result.landmarks.items()
        },
        "measurements": {name: _measurement_json(value) for name, value in result.measurements.items()},
        "not_measurable": dict(result.not_measurable),
        "sizes": dict(result.sizes),
        "questions": list(result.questions),
        "remarks": list(result.remarks),
        "foot_from_input": result.foot_from_input.tolist(),
        "wedge": wedge_json(result.wedge),
    }


def _measurement_json(value: Measurement) -> dict[str, object]:
    return {
        "value": value.value,
        "unit": value.unit,
        "reliable": value.reliable,
        "reason": value.reason,
        "interval": None if value.interval is None else list(value.interval),
        "unusual": value.unusual,
    }


def _measured(
    entry: Entry, foot: StandingFoot, marks: Landmarks, missing: Mapping[str, str], norm: Norm
) -> Measurement:
    for name in entry.needs:
        if name not in marks:
            return Measurement(None, entry.unit, False, missing.get(name, f"{NEEDS_HAND}: {name} was not given"))
    reading = entry.measure(foot, marks)
    if not isinstance(reading, Reading):
        return Measurement(None, entry.unit, False, reading)
    doubts = [doubt for name in entry.needs for doubt in _doubts(marks[name], exempt=name in entry.exempt)]
    doubts = list(dict.fromkeys([*doubts, *reading.doubts]))
    notes = [ORIGIN_UNKNOWN] if reading.interval is not None and foot.shell.origin is None else []
    unusual = unusual_remark(entry.name, reading.value, foot.alignment.length_mm, norm)
    tape = None if reading.tape is None else TapePlane(*reading.tape)
    reason = "; ".join([*doubts, *notes])
    return Measurement(reading.value, entry.unit, not doubts, reason, reading.interval, unusual, tape)


def _doubts(mark: Landmark, *, exempt: bool) -> list[str]:
    return [doubt for doubt in mark.doubts if not (exempt and doubt.startswith(NEEDS_HAND))]


def _placed(mark: Landmark, found: Measurements) -> PlacedLandmark:
    return PlacedLandmark(found.frame.to_input(mark.xyz_foot[None])[0], mark.source, "; ".join(mark.doubts))


def _check_size(shell: Shell) -> None:
    """Refuse a mesh in another unit before anything of it is joined or repaired."""
    finite = shell.xyz[np.isfinite(shell.xyz).all(axis=1)]
    if len(finite):
        check_foot_length(float(np.ptp(finite[:, :2], axis=0).max()))


def _checked_landmarks(landmarks: Mapping[str, Floats]) -> dict[str, Floats]:
    known = {rule.name for rule in RULES} | set(BY_HAND)
    given: dict[str, Floats] = {}
    for name, xyz in landmarks.items():
        point = np.asarray(xyz, dtype=np.float64)
        if name not in known:
            raise MeshError(f"landmark {name!r}: not known; allowed are {', '.join(sorted(known))}")
        if point.shape != (3,) or not np.isfinite(point).all():
            raise MeshError(f"landmark {name!r}: 3 finite numbers in the mesh's coordinates are needed")
        given[name] = point
    return given
