"""How far flat triangles stray from the curved last, and the sampling that keeps this chord error small."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.errors import QualityError
from footscan.shoelast.model import Shoelast
from footscan.shoelast.skin import Sampling

CHORD_LIMIT_MM = 0.02
_INSIDE = 0.75  # inside a triangle a quadratic strays up to 4/3 as far as in the middles of its edges
_SPARE = 1.03  # a little finer than the square law says, so that one more round is rarely needed
_COARSE = Sampling(120, 40, 12)
_MOST = Sampling(3000, 1200, 800)


@dataclass(frozen=True)
class ChordError:
    """How far (mm) the surface lies beside the middles of chords: the worst `round`, `up`, `across`, `diagonal` chord.

    Slides within the surface are left out. The mesh strays at most 4/3 of the worst from the surface.
    """

    round: float
    up: float
    across: float
    diagonal: float

    @property
    def bound_mm(self) -> float:
        """A bound of the distance between mesh and surface."""
        return max(self.round, self.up, self.across, self.diagonal) / _INSIDE


def chord_error(shoelast: Shoelast, fine: Sampling) -> ChordError:
    """Measure every edge and diagonal of `skin_of(shoelast, fine)` against the surface."""
    u = np.arange(2 * fine.round + 1) / (2 * fine.round)
    v = np.arange(2 * fine.up + 1) / (2 * fine.up)
    tube = shoelast.upper.grid(u, v)
    up, around, crossing = _gaps(tube)
    s, t = np.arange(fine.round + 1) / fine.round, np.arange(2 * fine.across + 1) / (2 * fine.across)
    discs = [_gaps(disc.grid(s, t)) for disc in (shoelast.bottom, shoelast.cone_top)]
    return ChordError(
        round=max(around, _beside(tube[[0, -1]]), *(gaps[0] for gaps in discs)),
        up=up,
        across=max(gaps[1] for gaps in discs),
        diagonal=max(crossing, *(gaps[2] for gaps in discs)),
    )


def _gaps(xyz: Floats) -> tuple[float, float, float]:
    """Along columns, rows and the mesh's diagonals, of points `(2 m + 1, 2 k + 1, 3)` at half steps, along the normal.

    Along the normal, because a slide within the surface is no error.
    """
    normal = np.cross(np.gradient(xyz, axis=0), np.gradient(xyz, axis=1))
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-30)
    corner = xyz[::2, ::2]
    gaps = (
        (xyz[1::2, ::2] - 0.5 * (corner[:-1] + corner[1:])) * normal[1::2, ::2],
        (xyz[::2, 1::2] - 0.5 * (corner[:, :-1] + corner[:, 1:])) * normal[::2, 1::2],
        (xyz[1::2, 1::2] - 0.5 * (corner[:-1, :-1] + corner[1:, 1:])) * normal[1::2, 1::2],
    )
    along, across, diagonal = (float(np.abs(gap.sum(axis=-1)).max()) for gap in gaps)
    return along, across, diagonal


def _beside(edges: Floats) -> float:
    """How far curves `(k, 2 m + 1, 3)` at half steps lie beside their chords, sideways in any direction."""
    begin, middle, end = edges[:, :-1:2], edges[:, 1::2], edges[:, 2::2]
    chord = end - begin
    along = chord / np.maximum(np.linalg.norm(chord, axis=-1, keepdims=True), 1e-30)
    gap = middle - 0.5 * (begin + end)
    gap = gap - (gap * along).sum(axis=-1, keepdims=True) * along
    return float(np.linalg.norm(gap, axis=-1).max())


def sampling_within(shoelast: Shoelast, limit_mm: float = CHORD_LIMIT_MM) -> tuple[Sampling, ChordError]:
    """The sampling of `skin_of` at which the mesh stays within `limit_mm` of the surface, and what it reaches.

    Raises:
        QualityError: Not reached with the finest sampling: the last has a crease.
    """
    fine, error = _COARSE, chord_error(shoelast, _COARSE)
    while error.bound_mm > limit_mm and fine != _MOST:
        fine = _finer(fine, error, limit_mm * _INSIDE)
        error = chord_error(shoelast, fine)
    if error.bound_mm > limit_mm:
        raise QualityError(
            f"{shoelast.name}: a mesh of {fine.round} x {fine.up} points strays {error.bound_mm:.3f} mm from the "
            f"surface, at most {limit_mm:g} mm is allowed: the surface has a crease; import or customise it again."
        )
    return fine, error


def _finer(fine: Sampling, error: ChordError, allowed: float) -> Sampling:
    """More steps where a chord strays too far; only when all chords are good do the diagonals refine everything."""
    worst = {"round": error.round, "up": error.up, "across": error.across}
    if max(worst.values()) <= allowed:
        worst = dict.fromkeys(worst, error.diagonal)
    steps = {name: min(_steps(getattr(fine, name), gap, allowed), getattr(_MOST, name)) for name, gap in worst.items()}
    return Sampling(steps["round"] + steps["round"] % 2, steps["up"], steps["across"])


def _steps(now: int, gap: float, allowed: float) -> int:
    return now if gap <= allowed else max(now + 2, int(np.ceil(now * _SPARE * np.sqrt(gap / allowed))))
