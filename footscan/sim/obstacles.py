"""What stands beside or around the scanned foot: painted and casting shadow, but no part of the truth.

The idle leg stands on a stand beside the machine, so high that the turning head passes below the other foot; its
post and that of the handhold stand outside the footboard. All three are closed bodies.
"""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from footscan.coordinates import Floats, Side
from footscan.errors import InputError
from footscan.sim.bodies import turned_body
from footscan.sim.foot import LEG_TOP_MM, FootShape, build_foot
from footscan.sim.surface import Surface, grid_faces, surface_from_trimesh

Obstacle = Literal["idle-leg", "handhold", "trouser-hem"]
OBSTACLES: tuple[Obstacle, ...] = get_args(Obstacle)

STAND_MM = 240.0
"""Height of the platform under the idle foot."""
POST_FROM_AXIS_MM = 330.0
HEM_MM = (120.0, 200.0)
"""Heights of the hem's edge, and of the place where the cloth lies close to the leg."""
_METAL, _SKIN, _CLOTH = 0.35, 1.0, 0.3
_EDGE_MM = 12.0
_AROUND = 180


@dataclass(frozen=True)
class Part:
    """A body in world millimetres and its brightness relative to skin."""

    surface: Surface
    tone: float


def build_obstacle(name: str, scanned: Surface, side: Side) -> tuple[Part, ...]:
    """An obstacle for a scanned foot.

    Args:
        name: One of `OBSTACLES`.
        scanned: What stands on the board, toes along +x.
        side: Of the scanned foot; the idle leg stands on its inner side.

    Raises:
        InputError: No such obstacle, or a hem for a body without a leg.
    """
    inward = 1.0 if side == "right" else -1.0
    match name:
        case "idle-leg":
            return _idle_leg(inward, "left" if side == "right" else "right")
        case "handhold":
            place = np.array([-60.0, -inward * 280.0, 0.0])
            return (Part(_post(16.0, place, 0.0, 420.0), _METAL),)
        case "trouser-hem":
            return (Part(_hem(scanned), _CLOTH),)
        case _:
            raise InputError(f"an obstacle is one of {', '.join(OBSTACLES)}; found {name!r}.")


def join_parts(surface: Surface, parts: tuple[Part, ...]) -> tuple[Surface, Floats]:
    """One surface of a body and its obstacles, the body's faces first, and the tone `(m,)` of every face."""
    vertices, faces, tones = [surface.xyz_world], [surface.faces], [np.ones(len(surface.faces))]
    count = len(surface.xyz_world)
    for part in parts:
        vertices.append(part.surface.xyz_world)
        faces.append(part.surface.faces + count)
        tones.append(np.full(len(part.surface.faces), part.tone))
        count += len(part.surface.xyz_world)
    joined = Surface(np.ascontiguousarray(np.concatenate(vertices)), np.concatenate(faces), surface.closed)
    return joined, np.concatenate(tones)


def _idle_leg(inward: float, side: Side) -> tuple[Part, ...]:
    """Post, platform and the other foot upon it."""
    y = inward * POST_FROM_AXIS_MM
    post = _post(20.0, np.array([0.0, y, 0.0]), 0.0, STAND_MM - 20.0)
    import trimesh

    plate = trimesh.creation.box([300.0, 130.0, 20.0])
    plate.apply_translation([0.0, y, STAND_MM - 10.0])
    other = _moved(build_foot(FootShape(side)), np.array([0.0, y, STAND_MM]))
    return Part(post, _METAL), Part(surface_from_trimesh(plate, _EDGE_MM), _METAL), Part(other, _SKIN)


def _post(radius_mm: float, foot_world: Floats, low_mm: float, high_mm: float) -> Surface:
    rise = np.linspace(low_mm, high_mm, int(np.ceil((high_mm - low_mm) / _EDGE_MM)) + 1)
    radius = np.concatenate([[0.5], np.full(len(rise), 1.0), [0.5]]) * radius_mm
    return _moved(turned_body(radius, np.concatenate([rise[:1], rise, rise[-1:]]), sections=36), foot_world)


def _moved(surface: Surface, shift_mm: Floats) -> Surface:
    return Surface(surface.xyz_world + shift_mm, surface.faces, surface.closed)


def _hem(scanned: Surface) -> Surface:
    """A tube of cloth about the leg, with folds, wide at its lower edge."""
    low, close = HEM_MM
    top = min(float(scanned.xyz_world[:, 2].max()), LEG_TOP_MM) - 4.0
    if top < close:
        raise InputError(
            f"a trouser hem needs a leg up to {close + 4.0:.0f} mm above the board, this body ends at "
            f"{top + 4.0:.0f} mm; leave the hem out or give a mesh with a longer leg."
        )
    height: Floats = low + np.arange(int((top - low) / 4.0) + 1, dtype=np.float64) * 4.0
    angle: Floats = np.arange(_AROUND, dtype=np.float64) * (2.0 * np.pi / _AROUND)
    flare = np.clip((close - height) / (close - low), 0.0, 1.0)
    folds = 1.0 + 0.3 * np.cos(5.0 * angle)[None, :]
    outer, inner = (_ring(scanned, height, angle, (gap + 20.0 * flare)[:, None] * folds) for gap in (6.0, 4.0))
    return _tube(np.concatenate([outer, inner[::-1]]))


def _ring(scanned: Surface, height: Floats, angle: Floats, gap_mm: Floats) -> Floats:
    """`(heights, angles, 3)` places `gap_mm` outside a round leg as wide as the scanned one."""
    rings = np.empty((len(height), len(angle), 3))
    for row, z in enumerate(height):
        near = scanned.xyz_world[np.abs(scanned.xyz_world[:, 2] - z) < 6.0]
        middle = (near[:, :2].min(axis=0) + near[:, :2].max(axis=0)) / 2.0
        radius = float(np.hypot(*(near[:, :2] - middle).T).max())
        reach = radius + gap_mm[row]
        rings[row, :, 0] = middle[0] + reach * np.cos(angle)
        rings[row, :, 1] = middle[1] + reach * np.sin(angle)
        rings[row, :, 2] = z
    return rings


def _tube(rings: Floats) -> Surface:
    """A closed body of rings: the first follows the last, the first angle the last one."""
    count, around = rings.shape[:2]
    index = (np.arange(count + 1) % count)[:, None] * around + (np.arange(around + 1) % around)
    faces = index.ravel()[grid_faces(count + 1, around + 1)]
    return Surface(np.ascontiguousarray(rings.reshape(-1, 3)), np.ascontiguousarray(faces[:, ::-1]))
