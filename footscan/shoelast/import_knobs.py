"""Chuck stub and toe centre: narrow knobs at the ends of a last, on which it was turned, and separate bodies."""

from dataclasses import dataclass

import numpy as np
import trimesh

from footscan.coordinates import Floats, Ints
from footscan.foot.sections import cut_shell
from footscan.foot.shell import Shell
from footscan.shoelast.mesh_topology import face_normals, pieces
from footscan.shoelast.model import Attachment

_STEP_MM = 0.5
_BASE_MM = 1.0
"""The last bit of a knob is left out of its outline: it may widen into the last there."""
_AROUND_MM, _ROOM_MM, _BEYOND_MM = 25.0, 0.8, 1.0
_LEANS_RAD = np.radians([0.0, 8.0, -8.0, 16.0, -16.0, 24.0, -24.0])
"""A last was turned about its heel-to-toe axis, which leans against seat and ball by its heel."""
_NEARER_RAD = np.radians([-6.0, -4.0, -2.0, 2.0, 4.0, 6.0])
_AS_LONG = 0.85
_X = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class _Kind:
    """What is looked for at one end (mm); `sign` is 1 at the heel, -1 at the toe."""

    name: str
    where: str
    sign: float
    least: float
    most: float
    widest: float
    under: float
    """So deep below its base the skin of the last is hidden, since that bends away."""
    surer: float
    """So much longer than the least must a knob be that leans, and that is therefore looked for in many ways."""


_KINDS = (
    _Kind("stub", "behind the heel", 1.0, 8.0, 40.0, 20.0, 12.0, 3.0),
    _Kind("toe_centre", "at the toe", -1.0, 2.5, 15.0, 13.0, 4.0, 1.5),
)


@dataclass(frozen=True)
class _Knob:
    """A knob at an end: its outline from `low` to `top` `(3,)` in its own heading, and that heading."""

    turn: Floats
    low: Floats
    top: Floats
    length_mm: float
    width_mm: float


@dataclass(frozen=True)
class Trimmed:
    """A last without what is no part of it, in the rough frame; `remarks` say what went."""

    xyz: Floats
    faces: Ints
    attachments: tuple[Attachment, ...]
    remarks: tuple[str, ...]


def without_attachments(xyz: Floats, faces: Ints, bodies: tuple[trimesh.Trimesh, ...]) -> Trimmed:
    """Cut off stub and toe centre where they are grown on, and name separate bodies.

    Args:
        xyz: `(n, 3)` in the rough frame.
        faces: `(m, 3)` outward.
        bodies: Other bodies, in the rough frame.
    """
    parts: list[Attachment] = []
    remarks: list[str] = []
    for kind in _KINDS:
        knob = _find_knob(xyz, faces, kind)
        if knob is None:
            continue
        part, faces = _parted(xyz, faces, knob)
        parts.append(Attachment(kind.name, trimesh.Trimesh(xyz, part, process=True)))
        remarks.append(
            f"a {kind.name.replace('_', ' ')} {kind.where}, {knob.width_mm:.0f} mm wide and {knob.length_mm:.0f} mm "
            "long, was cut off and kept apart; the skin under it is bridged"
        )
    ends = xyz[np.unique(faces), 0]
    for body in bodies:
        named = _named(body, float(ends.min()), float(ends.max()))
        if named is None:
            remarks.append(
                f"a separate body of {len(body.faces)} faces, neither behind the heel nor at the toe, was left out"
            )
            continue
        parts.append(Attachment(named, body))
        remarks.append(f"a separate body of {len(body.faces)} faces was kept apart as {named.replace('_', ' ')}")
    return Trimmed(xyz, faces, tuple(parts), tuple(remarks))


def _named(body: trimesh.Trimesh, back_mm: float, front_mm: float) -> str | None:
    """What a separate body is, by the end of the last beyond which it reaches."""
    low, high = float(body.bounds[0][0]), float(body.bounds[1][0])
    if low < back_mm - _BEYOND_MM:
        return "stub"
    return "toe_centre" if high > front_mm + _BEYOND_MM else None


def _find_knob(xyz: Floats, faces: Ints, kind: _Kind) -> _Knob | None:
    """The knob at an end, looked for along several ways: along the one that it fills most closely."""
    along = kind.sign * xyz[:, 0]
    near = faces[along[faces].min(axis=1) < along.min() + kind.most + _AROUND_MM]
    vertex, place = np.unique(near, return_inverse=True)
    end, corner = xyz[vertex], np.ascontiguousarray(place.reshape(-1, 3))
    found = [(lean, _knob_along(end, corner, kind, lean)) for lean in _LEANS_RAD]
    sure = [
        (lean, knob)
        for lean, knob in found
        if knob is not None and (lean == 0.0 or knob.length_mm > kind.least + kind.surer)
    ]
    if not sure:
        return None
    longest = max(knob.length_mm for _, knob in sure)
    lean, knob = next(one for one in sure if one[1].length_mm >= _AS_LONG * longest)
    nearer = [_knob_along(end, corner, kind, lean + turn) for turn in _NEARER_RAD]
    as_long = [one for one in nearer if one is not None and one.length_mm >= _AS_LONG * longest]
    return min([knob, *as_long], key=lambda one: float(one.top[2] - one.low[2]))


def _knob_along(xyz: Floats, faces: Ints, kind: _Kind, lean_rad: float) -> _Knob | None:
    """A knob whose cuts across one way stay narrow and alike, and widen suddenly where the last begins."""
    cosine, sine = np.cos(lean_rad), np.sin(lean_rad)
    turn = np.array([[kind.sign * cosine, 0.0, kind.sign * sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    turned = xyz @ turn.T
    tip = float(turned[:, 0].min())
    steps = np.arange(_STEP_MM, kind.most + 2.0, _STEP_MM)
    shell = Shell(np.ascontiguousarray(turned), faces)
    cuts = [cut_shell(shell, (tip + step) * _X, _X).xyz.reshape(-1, 3) for step in steps]
    wide, high = (np.array([np.ptp(cut[:, k]) if len(cut) else 0.0 for cut in cuts]) for k in (1, 2))
    least = int(kind.least / _STEP_MM)
    if wide[least] > kind.widest or high[least] > 3.0 * kind.widest:
        return None
    usual = float(np.median(wide[1:least])), float(np.median(high[1:least]))
    beyond = np.flatnonzero((wide[least:] > 1.35 * usual[0] + 1.0) | (high[least:] > 1.35 * usual[1] + 1.0))
    if len(beyond) == 0:
        return None
    length = float(steps[least + beyond[0]]) - 0.5 * _STEP_MM
    inside = np.vstack([cut for cut, step in zip(cuts, steps, strict=True) if step < length - _BASE_MM])
    low, top = inside.min(axis=0) - _ROOM_MM, inside.max(axis=0) + _ROOM_MM
    low[0], top[0] = -np.inf, tip + length + kind.under
    return _Knob(turn, low, top, length, usual[0])


def _parted(xyz: Floats, faces: Ints, knob: _Knob) -> tuple[Ints, Ints]:
    """Faces of the knob, and those of the last without what lies under it."""
    turned = xyz @ knob.turn.T
    within = np.logical_and.reduce((turned > knob.low) & (turned < knob.top), axis=1)
    gone = within[faces].any(axis=1)
    count, label = pieces(faces[~gone])
    area = np.bincount(label, weights=face_normals(xyz, faces[~gone])[1], minlength=count)
    kept = np.zeros(len(faces), dtype=np.bool_)
    kept[np.flatnonzero(~gone)[label == area.argmax()]] = True
    return faces[~kept], faces[kept]


def turned_attachments(parts: tuple[Attachment, ...], turn: Floats) -> tuple[Attachment, ...]:
    """Attachments under a 4x4."""
    return tuple(Attachment(part.kind, part.mesh.copy().apply_transform(turn)) for part in parts)
