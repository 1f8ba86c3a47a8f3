"""A foot made of formulas: round cones blended into each other, cut flat by the board, hollow under the arch.

Free of anybody's data. In the foot's own system x runs from heel to toe, y to the medial side, z up from the board;
lengths below are those of a foot of about 255 mm (size 1).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import Floats, Side
from footscan.errors import InputError
from footscan.sim.kept_surface import kept_surface
from footscan.sim.level_set import is_closed, mesh_field
from footscan.sim.surface import Surface

SIZES = (0.45, 1.2)
LEG_TOP_MM = 238.0
"""The leg ends here, above what any camera of the machine sees."""

# x, y, z, radius at either end of each round cone, mm
_BODY = (
    (27, 0, 25, 25, 36, -1, 31, 25),  # heel
    (27, 0, 17, 20, 50, -4, 17, 19),  # heel pad
    (26, 0, 42, 19, 40, 0, 112, 15),  # Achilles tendon
    (52, 0, 62, 27, 58, 1, 118, 27),  # ankle
    (58, 1, 118, 27, 56, 0, 330, 47),  # lower leg
    (56, 0, 330, 47, 58, 0, 620, 47),  # calf, for small sizes
    (66, 6, 58, 26, 168, 12, 24, 15),  # instep
    (64, -4, 50, 24, 166, -6, 20, 14),  # third metatarsal
    (60, -14, 28, 19, 160, -27, 17, 11),  # outer border
    (70, 12, 42, 20, 178, 25, 20, 15),  # first metatarsal
    (60, 12, 16, 15, 170, 22, 14, 13),  # inner border, hollowed by the arch
    (56, 22, 74, 16, 60, 25, 76, 14),  # inner ankle
    (48, -22, 64, 15, 52, -25, 66, 13),  # outer ankle
)
_BALL = (
    (182, 29, 16, 15, 166, -33, 11, 11),
    (182, 20, 19, 15, 168, -20, 15, 12),
    (154, 10, 13, 13, 152, -20, 11, 11),
)
_TOES = (
    (184, 28, 16, 13.5, 242, 22, 11.5, 10.5),
    (186, 12, 15, 10, 240, 4, 9.5, 7.8),
    (182, -2, 14, 9.5, 230, -10.5, 9, 7.4),
    (176, -15, 13, 9, 216, -23.5, 8.5, 7.0),
    (168, -28, 12, 9, 201, -36, 8, 7.2),
)
_ARCH = (68.0, 42.0, -14.0, 31.0, 142.0, 46.0, -14.0, 31.0)
_SOLE_MM = 3.5
"""Height of the formulas at which the board cuts them: the pads of heel, ball and toes are pressed flat."""
_BODY_BLEND_MM, _TOE_BLEND_MM, _JOIN_BLEND_MM, _CUT_BLEND_MM = 5.5, 1.8, 4.0, 1.2
_GRID_STEPS_MM = (2.5, 2.45, 2.4, 2.55, 2.35, 2.3)


@dataclass(frozen=True)
class FootShape:
    """What can be chosen about the built-in foot.

    Attributes:
        side: right or left.
        size: 0.45 (a child of two) to 1.2; 1 is about 255 mm long.
        arch: Height of the arch: 0 flat, 1 usual, 1.5 high.
        hallux_valgus_rad: How far the big toe leans to the others.
        missing_toes: Numbers 1 (big toe) to 5 of amputated toes; the ball ends round where they were.
    """

    side: Side = "left"
    size: float = 1.0
    arch: float = 1.0
    hallux_valgus_rad: float = 0.0
    missing_toes: tuple[int, ...] = ()


@lru_cache(maxsize=4)
def build_foot(shape: FootShape | None = None) -> Surface:
    """The built-in foot in the world: sole on the board, toes along +x, the middle of its outline on the axis.

    It is kept in the user's cache folder: meshing its formulas takes a second.

    Raises:
        InputError: A size, arch or angle outside what the formulas can make.
    """
    shape = shape or FootShape()
    _check(shape)
    return kept_surface("foot", (shape, _GRID_STEPS_MM), lambda: _mesh_foot(shape))


def _mesh_foot(shape: FootShape) -> Surface:
    body, toes, arch = _cones(shape)
    top = LEG_TOP_MM / shape.size + _SOLE_MM

    def field(xyz_foot: Floats) -> Floats:
        value = np.empty(len(xyz_foot))
        _foot_field(np.ascontiguousarray(xyz_foot), body, toes, arch, top, value)
        return value

    low, high = np.array([-6.0, -62.0, -4.0]), np.array([272.0, 66.0, top + 5.0])
    steps = (step / np.sqrt(shape.size) for step in _GRID_STEPS_MM)
    feet = (mesh_field(field, low, high, step) for step in steps)
    closed = next((foot for foot in feet if is_closed(foot.faces)), None)
    if closed is None:
        raise InputError(f"the built-in foot cannot be meshed at size {shape.size:g}; choose a size 0.01 beside it.")
    return _in_world(closed, shape)


def _check(shape: FootShape) -> None:
    low, high = SIZES
    if not low <= shape.size <= high:
        raise InputError(f"the built-in foot has sizes {low} to {high} (1 is about 255 mm long), found {shape.size:g}.")
    if not 0.0 <= shape.arch <= 1.5:
        raise InputError(f"the arch of the built-in foot goes from 0 (flat) to 1.5 (high), found {shape.arch:g}.")
    if not 0.0 <= shape.hallux_valgus_rad <= 0.5:
        found = np.degrees(shape.hallux_valgus_rad)
        raise InputError(f"the big toe of the built-in foot leans 0 to 28 degrees, found {found:.3g}.")
    if not set(shape.missing_toes) <= {1, 2, 3, 4, 5}:
        raise InputError(f"toes have the numbers 1 (big toe) to 5, found {shape.missing_toes}.")


def _cones(shape: FootShape) -> tuple[Floats, Floats, Floats]:
    body, toes = np.array(_BODY + _BALL, dtype=np.float64), np.array(_TOES, dtype=np.float64)
    big_toe = toes[0]
    along = big_toe[4:6] - big_toe[0:2]
    c, s = np.cos(shape.hallux_valgus_rad), np.sin(shape.hallux_valgus_rad)
    big_toe[4:6] = big_toe[0:2] + np.array([c * along[0] + s * along[1], c * along[1] - s * along[0]])
    toes = _amputated(toes, shape.missing_toes)
    arch = np.array(_ARCH)
    arch[[2, 6]] += 22.0 * (shape.arch - 1.0)
    return body, toes, arch


def _amputated(toes: Floats, missing: tuple[int, ...]) -> Floats:
    """The cones of the toes, those of missing ones drawn back into the ball."""
    result = toes.copy()
    for number in missing:
        stump = result[number - 1]
        stump[4:8] = stump[:4] + 0.06 * (stump[4:8] - stump[:4])
    return result


def _in_world(foot: Surface, shape: FootShape) -> Surface:
    xyz = (foot.xyz_world - np.array([0.0, 0.0, _SOLE_MM])) * shape.size
    outline = xyz[xyz[:, 2] < 60.0 * shape.size]
    middle = (outline.min(axis=0) + outline.max(axis=0)) / 2.0
    xyz = xyz - np.array([middle[0], middle[1], 0.0])
    if shape.side == "right":
        return Surface(np.ascontiguousarray(xyz), foot.faces)
    mirrored = np.ascontiguousarray(xyz * np.array([1.0, -1.0, 1.0]))
    return Surface(mirrored, np.ascontiguousarray(foot.faces[:, ::-1]))


@compiled
def _distance(x: float, y: float, z: float, cone: Floats) -> float:
    """About the distance to a round cone, mm; negative inside."""
    ax, ay, az = cone[4] - cone[0], cone[5] - cone[1], cone[6] - cone[2]
    px, py, pz = x - cone[0], y - cone[1], z - cone[2]
    t = min(max((px * ax + py * ay + pz * az) / (ax * ax + ay * ay + az * az), 0.0), 1.0)
    away = np.sqrt((px - t * ax) ** 2 + (py - t * ay) ** 2 + (pz - t * az) ** 2)
    return away - cone[3] - t * (cone[7] - cone[3])


@compiled
def _union(x: float, y: float, z: float, cones: Floats, blend: float) -> float:
    nearest = 1e9
    for i in range(cones.shape[0]):
        nearest = min(nearest, _distance(x, y, z, cones[i]))
    total = 0.0
    for i in range(cones.shape[0]):
        total += np.exp((nearest - _distance(x, y, z, cones[i])) / blend)
    return nearest - blend * np.log(total)


@compiled
def _smaller(a: float, b: float, blend: float) -> float:
    """The smaller of two, rounded where they meet."""
    return min(a, b) - blend * np.log1p(np.exp(-abs(a - b) / blend))


@compiled
def _foot_field(xyz: Floats, body: Floats, toes: Floats, arch: Floats, top: float, value: Floats) -> None:
    for i in range(xyz.shape[0]):
        x, y, z = xyz[i, 0], xyz[i, 1], xyz[i, 2]
        shape = _union(x, y, z, body, _BODY_BLEND_MM)
        shape = _smaller(shape, _union(x, y, z, toes, _TOE_BLEND_MM), _JOIN_BLEND_MM)
        hollow = -_smaller(-shape, _distance(x, y, z, arch), _JOIN_BLEND_MM)
        above_board = -_smaller(-hollow, z - _SOLE_MM, _CUT_BLEND_MM)
        value[i] = -_smaller(-above_board, top - z, _CUT_BLEND_MM)
