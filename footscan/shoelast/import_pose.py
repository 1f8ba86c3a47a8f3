"""Roughly upright: which way a last points, from its shape alone; and whether it is whole."""

import numpy as np

from footscan.coordinates import Bools, Floats, Ints, Side
from footscan.errors import MeshError
from footscan.foot.crossing import convex_hull
from footscan.foot.units import UNITS, mm_from_unit
from footscan.shoelast.design import SEAT_SHARE
from footscan.shoelast.mesh_topology import face_normals, usual_direction

LENGTH_MM = (140.0, 400.0)
_USUAL_MM = (200.0, 345.0)
_LARGE_SHARE, _HALF_DEPTH_MM = 0.6, 62.0
_BALL_SHARE = 0.66
_TABLE_ROUNDS = 2
_LEANING, _SAME_WAY, _FLAT_MM, _SAWN_SHARE = 0.6, float(np.cos(np.radians(3.0))), 0.4, 0.9
_PLURAL = {"mm": "millimetres", "cm": "centimetres", "m": "metres", "in": "inches"}
_WHOLE = 1000.0
_FACTORS = (10.0, 25.4, 1000.0)
"""By these a unit is mistaken: cm or m written as if they were mm, or inches."""


def check_length(extent_mm: float, unit: str, *, stated: bool = False) -> None:
    """Refuse a body that is no last's size, naming the unit it probably is in.

    Args:
        extent_mm: The longest extent by the unit that was said.
        unit: The unit that was said: by the person, or by the file.
        stated: The file states its unit itself, so that the person cannot say another one.

    Raises:
        MeshError: Outside `LENGTH_MM`.
    """
    if LENGTH_MM[0] <= extent_mm <= LENGTH_MM[1]:
        return
    number = extent_mm / mm_from_unit(unit)
    fitting = _fitting_units(number)
    if not fitting:
        advice = _wrong_by(extent_mm)
    elif stated:
        advice = (
            f"its numbers are probably {_PLURAL[fitting[0]]}: set that unit where the file was made and save it again"
        )
    else:
        advice = f"its numbers are probably {_PLURAL[fitting[0]]}: pass --unit {fitting[0]}"
    raise MeshError(
        f"the longest extent is {_number(number)} {unit}, a last has {LENGTH_MM[0]:.0f} to {LENGTH_MM[1]:.0f} mm; "
        f"{advice}."
    )


def _fitting_units(number: float) -> list[str]:
    return [one for one in UNITS if _USUAL_MM[0] <= number * mm_from_unit(one) <= _USUAL_MM[1]]


def _number(value: float) -> str:
    return f"{value:.0f}" if value >= _WHOLE else f"{value:.4g}"


def _wrong_by(extent_mm: float) -> str:
    for factor in _FACTORS:
        if _USUAL_MM[0] <= extent_mm / factor <= _USUAL_MM[1]:
            return f"it is about {factor:g} times too large: save it in mm and pass --unit mm"
    return "check that it is one last"


def likely_unit(extent: float) -> str:
    """Words on the unit in which a bare number would be the length of a last."""
    fitting = _fitting_units(extent)
    return f"by its size ({_number(extent)} long) probably --unit {fitting[0]}" if fitting else "its size fits no last"


def rough_frame(xyz: Floats, faces: Ints, side: Side) -> Floats:
    """A 4x4 that lays a last roughly upright with its toe along +x and y medial.

    The long axis comes from the moments of the skin; down is where, around that axis, most skin looks to (the bottom);
    the heel is the end that is higher. Then it is laid on its seat and ball as on a table: the long axis rises the more
    the higher the heel is.

    Args:
        xyz: `(n, 3)` mm, any heading.
        faces: `(m, 3)` outward.
        side: As said; a left last is mirrored.
    """
    normal, area = face_normals(xyz, faces)
    middle = xyz[faces].mean(axis=1)
    centre = np.average(middle, axis=0, weights=area)
    spread = (middle - centre) * np.sqrt(area)[:, None]
    long = np.linalg.eigh(spread.T @ spread)[1][:, -1]
    down = _down(normal, area, long)
    across = np.cross(-down, long)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([long, across, -down])
    if _heel_in_front(xyz @ frame[:3, :3].T):
        frame[:2] *= -1.0
    if side == "left":
        frame[1] *= -1.0
    for _ in range(_TABLE_ROUNDS):
        frame[:3, :3] = _laid_on_table(xyz @ frame[:3, :3].T) @ frame[:3, :3]
    frame[:3, 3] = -(xyz @ frame[:3, :3].T).min(axis=0)
    return frame


def _down(normal: Floats, area: Floats, long: Floats) -> Floats:
    first = np.cross(long, [1.0, 0.0, 0.0] if abs(long[0]) < 0.9 else [0.0, 1.0, 0.0])
    first /= np.linalg.norm(first)
    second = np.cross(long, first)
    a, b = normal @ first, normal @ second
    weight, angle = area * np.hypot(a, b) ** 4, np.arctan2(b, a)
    count = np.histogram(angle, 360, (-np.pi, np.pi), weights=weight)[0]
    kernel = np.exp(-0.5 * (np.arange(-30, 31) / 9.0) ** 2)
    smooth = np.convolve(np.concatenate([count[-30:], count, count[:30]]), kernel, "valid")
    best = np.radians(smooth.argmax() + 0.5) - np.pi
    return np.cos(best) * first + np.sin(best) * second


def _laid_on_table(xyz: Floats) -> Floats:
    """A turn `(3, 3)` about y that lays a body on the two places, seen from the side, between which it balances."""
    corner = xyz[convex_hull(np.ascontiguousarray(xyz[:, [0, 2]]))][:, [0, 2]]
    middle = 0.5 * (xyz[:, 0].min() + xyz[:, 0].max())
    begin, end = corner, np.roll(corner, -1, axis=0)
    spanning = np.flatnonzero((begin[:, 0] <= middle) != (end[:, 0] <= middle))
    below = spanning[(begin + end)[spanning, 1].argmin()]
    along = (end - begin)[below] * np.sign((end - begin)[below, 0])
    cosine, sine = along / np.linalg.norm(along)
    return np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])


def _heel_in_front(xyz: Floats) -> bool:
    """Whether the end at +x is the higher one: the cone is over the heel."""
    x = (xyz[:, 0] - xyz[:, 0].min()) / np.ptp(xyz[:, 0])
    back, front = (np.ptp(xyz[(x > low) & (x < high), 2]) for low, high in ((0.08, 0.3), (0.7, 0.92)))
    return bool(front > back)


def check_whole(xyz: Floats, faces: Ints, rims: list[Floats]) -> tuple[str, ...]:
    """Refuse half lasts and lasts without a sole; words on the holes that are bridged.

    Args:
        xyz: `(n, 3)` in the rough frame.
        faces: `(m, 3)`.
        rims: `(k, 3)` of every hole.

    Raises:
        MeshError: What is missing.
    """
    extent = np.ptp(xyz, axis=0)
    for rim in rims:
        size = np.ptp(rim, axis=0)
        if size.max() < _LARGE_SHARE * extent[1]:
            continue
        if size[0] > 0.6 * extent[0] and _depth_mm(xyz, rim) > _HALF_DEPTH_MM:
            raise MeshError("the sole is missing: the last is open below; export it with its bottom.")
        raise MeshError(f"part of the last is missing: an opening of {size.max():.0f} mm; export the whole last.")
    _check_flat_end(xyz, faces, extent)
    ratio = extent[0] / extent[1]
    if not 2.2 < ratio < 4.6:
        raise MeshError(
            f"length over width is {ratio:.1f}, a last has 2.3 to 4.4: half a last, two lasts, or another body."
        )
    if not rims:
        return ()
    around = [float(np.linalg.norm(np.diff(rim, axis=0, append=rim[:1]), axis=1).sum()) for rim in rims]
    return (f"{len(rims)} holes (the largest {max(around):.0f} mm round) were bridged",)


def _depth_mm(xyz: Floats, rim: Floats) -> float:
    """How far the body reaches from the plane of a rim."""
    normal = np.linalg.svd(rim - rim.mean(axis=0), full_matrices=False)[2][2]
    return float(np.ptp((xyz - rim.mean(axis=0)) @ normal))


def _check_flat_end(xyz: Floats, faces: Ints, extent: Floats) -> None:
    """Refuse a last with a flat face where it was sawn through: a large one that stands, or one that it lies on.

    A half lies on all of its plan; a bottom is narrower than the last above it.
    """
    normal, area = face_normals(xyz, faces)
    middle = xyz[faces].mean(axis=1)
    plan = float((area * np.maximum(normal[:, 2], 0.0)).sum())
    lying = [_largest_flat(normal[side], area[side], middle[side])[1] for side in _lying(normal)]
    stands = np.abs(normal[:, 2]) < _LEANING
    usual, flat = _largest_flat(normal[stands], area[stands], middle[stands])
    if max(lying) > _SAWN_SHARE * plan:
        way = "lengthwise"
    elif flat > 0.2 * extent[1] * extent[2]:
        way = "lengthwise" if abs(usual[1]) > 0.7 else "across"
    else:
        return
    raise MeshError(f"the last is cut off {way}: it has a flat face as large as a cut; export the whole last.")


def _lying(normal: Floats) -> tuple[Bools, Bools]:
    return normal[:, 2] <= -_LEANING, normal[:, 2] >= _LEANING


def _largest_flat(normal: Floats, area: Floats, middle: Floats) -> tuple[Floats, float]:
    """Which way the largest flat part of some faces looks `(3,)`, and its area (mm2)."""
    if len(normal) == 0:
        return np.array([0.0, 0.0, 1.0]), 0.0
    usual = usual_direction(normal, area)
    near = normal @ usual > _SAME_WAY
    offset = middle[near] @ usual
    count = np.histogram(offset, max(int(np.ptp(offset) / _FLAT_MM), 1), weights=area[near])[0]
    return usual, float(count.max())


def heading_of(xyz_edge: Floats) -> Floats:
    """A 4x4 that turns a last about z so that the axis of its feather edge `(k, 3)` points along x."""
    turn = np.eye(4)
    for _ in range(4):
        places = xyz_edge @ turn[:3, :3].T
        x = (places[:, 0] - places[:, 0].min()) / np.ptp(places[:, 0])
        middles = []
        for share in (SEAT_SHARE, _BALL_SHARE):
            near = places[np.abs(x - share) < 0.03]
            middles.append([near[:, 0].mean(), 0.5 * (near[:, 1].min() + near[:, 1].max())])
        along = np.subtract(middles[1], middles[0])
        angle = -float(np.arctan2(along[1], along[0]))
        step = np.eye(4)
        step[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        turn = step @ turn
    return turn
