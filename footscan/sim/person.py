"""The person on the footboard: sways, drifts, shifts weight, twitches, and moves a part of the foot when told to.

`Person.xyz_world_at(time_s)` is a pure function of time: the same settings and seed give the same skin at the same
moment, in whatever order it is asked. Everything is a few rigid motions, each with a weight per vertex that fades
smoothly, so the faces stay those of the surface.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import Floats, Ints
from footscan.errors import InputError
from footscan.sim.person_parts import (
    PARTS,
    Part,
    StandingFrame,
    find_frame,
    part_weights,
    pivot,
    smooth_step,
    sway_weight,
)
from footscan.sim.surface import Surface

_SLOT_S = 8.0  # one twitch of the toes per slot
_TWITCH_S = 0.5


@dataclass(frozen=True)
class PersonSettings:
    """How restless a person is; 0 switches a motion off.

    Attributes:
        sway_rad: Of the leg about the ankle, largest lean in either direction.
        drift_mm: Of the whole foot on the board, farthest from its place.
        turn_rad: Of the whole foot about its heel, farthest either way.
        lean_mm: Weight shift: the instep leans to either side while the sole stays; at the height of the ankle.
        sink_mm: Weight shift: the soft sole gives way, most of all the skin above it.
        arch_mm: Weight shift: the arch lowers.
        twitch_mm: Of the tips of the toes, upwards, about half a second once in eight.
    """

    sway_rad: float = np.deg2rad(1.0)
    drift_mm: float = 2.0
    turn_rad: float = np.deg2rad(0.3)
    lean_mm: float = 0.6
    sink_mm: float = 0.4
    arch_mm: float = 0.6
    twitch_mm: float = 1.5


RESTLESS = PersonSettings()
CALM = PersonSettings(np.deg2rad(0.06), 0.06, np.deg2rad(0.01), 0.05, 0.04, 0.05, 0.0)
"""Somebody who stands still: breathing and pulse move the skin by about 0.1 mm."""
STATUE = PersonSettings(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Nothing moves but what is told to."""


@dataclass(frozen=True)
class Move:
    """One deliberate move that stays.

    Attributes:
        part: What moves: foot (with the leg), heel, midfoot, ball, toes or ankle (the leg above it).
        shift_mm: Along the foot, to its left, up; the middle of the part goes this far.
        turn_rad: About the part's pivot: foot, heel, midfoot and ball about the vertical, toes (upwards) and the leg
            (forwards) about the axis across the foot.
        at_s: When it begins.
        lasts_s: How long it takes.
    """

    part: Part
    shift_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn_rad: float = 0.0
    at_s: float = 0.0
    lasts_s: float = 0.4


class Person:
    """Somebody standing on the board, as vertices over time."""

    def __init__(
        self, surface: Surface, settings: PersonSettings = RESTLESS, seed: int = 0, moves: tuple[Move, ...] = ()
    ) -> None:
        """Take over a surface standing on z = 0 (in world millimetres).

        Raises:
            InputError: A move of an unknown part, or one that takes no time.
        """
        _check(moves)
        self.surface, self.settings, self.moves = surface, settings, moves
        self.frame: StandingFrame = find_frame(surface.xyz_world)
        self._seed = seed
        self._waves = _Waves(seed)
        xyz = np.ascontiguousarray(surface.xyz_world)
        weights = part_weights(xyz, self.frame)
        leg = sway_weight(xyz, self.frame)
        height = xyz[:, 2] / self.frame.length_mm
        own = [
            leg,
            weights["foot"],
            smooth_step(height / 0.3),
            smooth_step(height / 0.08),
            weights["midfoot"] * smooth_step(height / 0.12),
            weights["toes"],
        ]
        # a turn of the leg bends the ankle; a shift moves the whole of what lies above it
        told = [leg if move.part == "ankle" and move.turn_rad else weights[move.part] for move in moves]
        self._xyz = xyz
        self._weight = np.ascontiguousarray(np.stack([*own, *told], axis=1))

    def xyz_world_at(self, time_s: float) -> Floats:
        """`(n, 3)` vertices of the surface's faces at a moment (s)."""
        motions = np.ascontiguousarray(np.stack([*self._own_motions(time_s), *self._told_motions(time_s)]))
        active = np.flatnonzero(np.any(motions != 0.0, axis=(1, 2)))
        result = self._xyz.copy()
        if len(active):
            _displace(self._xyz, self._weight, active, motions, result)
        return result

    def surface_at(self, time_s: float) -> Surface:
        """The surface as it stands at a moment."""
        return Surface(self.xyz_world_at(time_s), self.surface.faces, self.surface.closed)

    def _own_motions(self, time_s: float) -> list[Floats]:
        s, frame, wave = self.settings, self.frame, self._waves
        up = np.array([0.0, 0.0, 1.0])
        ankle, heel = pivot("ankle", frame), pivot("foot", frame)
        sway = s.sway_rad / np.sqrt(2.0) * (wave(0, time_s) * frame.across + wave(1, time_s) * frame.along)
        drift = s.drift_mm / np.sqrt(2.0) * (wave(2, time_s) * frame.along + wave(3, time_s) * frame.across)
        load = wave(5, time_s)
        raised = s.twitch_mm * self._twitch(time_s) / (0.2 * frame.length_mm)
        return [
            _about(ankle, sway, np.zeros(3)),
            _about(heel, s.turn_rad * wave(4, time_s) * up, drift),
            _about(heel, np.zeros(3), s.lean_mm * load * frame.across),
            _about(heel, np.zeros(3), -0.5 * s.sink_mm * (1.0 + load) * up),
            _about(heel, np.zeros(3), -0.5 * s.arch_mm * (1.0 + load) * up),
            _about(pivot("toes", frame), -raised * frame.across, np.zeros(3)),
        ]

    def _told_motions(self, time_s: float) -> list[Floats]:
        return [self._told(move, time_s) for move in self.moves]

    def _told(self, move: Move, time_s: float) -> Floats:
        frame = self.frame
        done = float(smooth_step(np.array([(time_s - move.at_s) / move.lasts_s]))[0])
        basis = np.stack([frame.along, frame.across, np.array([0.0, 0.0, 1.0])])
        axis = {"toes": -frame.across, "ankle": frame.across}.get(move.part)
        axis = basis[2] if axis is None else axis
        return _about(pivot(move.part, frame), done * move.turn_rad * axis, done * np.array(move.shift_mm) @ basis)

    def _twitch(self, time_s: float) -> float:
        """0 at rest; once in a slot a short, smooth pulse up to 1."""
        slot = int(np.floor(time_s / _SLOT_S))
        since = time_s - slot * _SLOT_S - _twitch_begin(self._seed, slot)
        return float(np.sin(np.pi * since / _TWITCH_S) ** 2) if 0.0 < since < _TWITCH_S else 0.0


class _Waves:
    """Six slow, smooth functions of time between -1 and 1, each three sines without a common period."""

    def __init__(self, seed: int) -> None:
        random = np.random.default_rng([seed, 0x9E4507])
        hertz = np.array([[0.25, 0.55]] * 2 + [[0.03, 0.12]] * 3 + [[0.08, 0.3]])
        self._hertz = random.uniform(hertz[:, :1], hertz[:, 1:], (6, 3))
        self._phase = random.uniform(0.0, 2.0 * np.pi, (6, 3))

    def __call__(self, number: int, time_s: float) -> float:
        return float(np.sin(2.0 * np.pi * self._hertz[number] * time_s + self._phase[number]).sum()) / 3.0


@lru_cache(maxsize=256)
def _twitch_begin(seed: int, slot: int) -> float:
    # a slot before time 0 is negative, and seeds are not
    random = np.random.default_rng([seed, 0x70E5, abs(slot), int(slot < 0)])
    return float(random.uniform(0.0, _SLOT_S - _TWITCH_S))


def _about(centre: Floats, turn: Floats, shift: Floats) -> Floats:
    """`(3, 4)`: what a turn (rotation vector) about a place and a shift add to a point; a zero when nothing moves."""
    angle = float(np.linalg.norm(turn))
    k = turn / max(angle, 1e-30)
    cross = np.array([[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]])
    added = np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    return np.column_stack([added, shift - added @ centre])


def _check(moves: tuple[Move, ...]) -> None:
    for move in moves:
        if move.part not in PARTS:
            raise InputError(f"a person can move {', '.join(PARTS)}, found {move.part!r}.")
        if not move.lasts_s > 0.0:
            raise InputError(f"a move takes time, found {move.lasts_s:g} s; give more than 0.")


@compiled
def _displace(xyz: Floats, weight: Floats, active: Ints, motions: Floats, result: Floats) -> None:
    for i in range(xyz.shape[0]):
        x, y, z = xyz[i, 0], xyz[i, 1], xyz[i, 2]
        for a in range(active.shape[0]):
            k = active[a]
            w = weight[i, k]
            if w != 0.0:
                for row in range(3):
                    m = motions[k, row]
                    result[i, row] += w * (m[0] * x + m[1] * y + m[2] * z + m[3])
