"""How far flat triangles stray from the curved last, and the few places at which this chord error stays small."""

from dataclasses import dataclass

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import Floats
from footscan.errors import QualityError
from footscan.shoelast.model import Shoelast
from footscan.shoelast.skin import Breaks, Sampling, even_breaks

CHORD_LIMIT_MM = 0.02
_INSIDE = 0.75  # inside a triangle a quadratic strays up to 4/3 as far as in the middles of its edges
_FIRST = Sampling(480, 160, 24)
"""Where the bends are looked for; a chord's error goes with the square of its length."""
_ROUNDS, _SPARE, _MOST_STEPS = 6, 0.97, 3000
_SLOWEST = 0.15
"""No place gets fewer points than this share of its neighbours' density, so that triangles change size gradually."""


@dataclass(frozen=True)
class ChordError:
    """How far (mm) the surface lies beside the middles of chords, the worst of every step `along`, `up` and `across`.

    Slides within the surface are left out. The mesh strays at most 4/3 of the worst from the surface.

    Attributes:
        along: `(h - 1,)` of the steps from heel to toe, on both halves of the upper and on bottom and cone top.
        up: `(k - 1,)` of the steps up the upper.
        across: `(m - 1,)` of the steps across bottom and cone top.
        diagonal: The worst diagonal.
    """

    along: Floats
    up: Floats
    across: Floats
    diagonal: float

    @property
    def bound_mm(self) -> float:
        """A bound of the distance between mesh and surface."""
        return max(float(self.along.max()), float(self.up.max()), float(self.across.max()), self.diagonal) / _INSIDE


def chord_error(shoelast: Shoelast, breaks: Breaks) -> ChordError:
    """Measure every edge and diagonal of `skin_of(shoelast, breaks)` against the surface."""
    s, t = _with_middles(breaks.along), _with_middles(breaks.across)
    around = np.concatenate([0.5 * s, 1.0 - 0.5 * s[-2::-1]])
    tube = shoelast.upper.grid(around, _with_middles(breaks.up))
    up, round_, crossing = _gaps(tube)
    round_ = np.maximum(round_, _beside(tube[[0, -1]]))
    discs = [_gaps(disc.grid(s, t)) for disc in (shoelast.bottom, shoelast.cone_top)]
    steps = len(breaks.along) - 1
    return ChordError(
        along=np.max([round_[:steps], round_[: -steps - 1 : -1], *(gaps[0] for gaps in discs)], axis=0),
        up=up,
        across=np.maximum(discs[0][1], discs[1][1]),
        diagonal=max(crossing, discs[0][2], discs[1][2]),
    )


def _with_middles(breaks: Floats) -> Floats:
    result = np.empty(2 * len(breaks) - 1)
    result[::2], result[1::2] = breaks, 0.5 * (breaks[:-1] + breaks[1:])
    return result


def _gaps(xyz: Floats) -> tuple[Floats, Floats, float]:
    """Worst of every step along columns `(m,)`, rows `(k,)` and of the mesh's diagonals, along the normal.

    Of points `(2 m + 1, 2 k + 1, 3)` at half steps. Along the normal, because a slide within the surface is no error.
    """
    down, across = np.zeros(len(xyz) // 2), np.zeros(xyz.shape[1] // 2)
    return down, across, float(worst_gaps(np.ascontiguousarray(xyz), down, across))


@compiled
def worst_gaps(xyz: Floats, down: Floats, across: Floats) -> float:
    """Raise the worst gaps of steps to what points at half steps show; the result is that of the diagonals."""
    rows, columns = xyz.shape[0], xyz.shape[1]
    diagonal = 0.0
    for i in range(rows):
        for j in range(1 - i % 2, columns, 2 - i % 2):
            di, dj = i % 2, j % 2  # a middle of a step down, of one across, or of a diagonal
            above, below, left, right = max(i - 1, 0), min(i + 1, rows - 1), max(j - 1, 0), min(j + 1, columns - 1)
            size = off = 0.0
            for x in range(3):
                y, z = (x + 1) % 3, (x + 2) % 3
                normal = (xyz[below, j, y] - xyz[above, j, y]) * (xyz[i, right, z] - xyz[i, left, z])
                normal -= (xyz[below, j, z] - xyz[above, j, z]) * (xyz[i, right, y] - xyz[i, left, y])
                off += normal * (xyz[i, j, x] - 0.5 * (xyz[i - di, j - dj, x] + xyz[i + di, j + dj, x]))
                size += normal * normal
            off = abs(off) / max(np.sqrt(size), 1e-30)
            if di and dj:
                diagonal = max(diagonal, off)
            elif di:
                down[i // 2] = max(down[i // 2], off)
            else:
                across[j // 2] = max(across[j // 2], off)
    return diagonal


def _beside(edges: Floats) -> Floats:
    """How far curves `(k, 2 m + 1, 3)` at half steps lie beside their chords, sideways in any direction, `(m,)`."""
    begin, middle, end = edges[:, :-1:2], edges[:, 1::2], edges[:, 2::2]
    chord = end - begin
    along = chord / np.maximum(np.linalg.norm(chord, axis=-1, keepdims=True), 1e-30)
    gap = middle - 0.5 * (begin + end)
    gap = gap - (gap * along).sum(axis=-1, keepdims=True) * along
    return np.linalg.norm(gap, axis=-1).max(axis=0)


def breaks_within(shoelast: Shoelast, limit_mm: float = CHORD_LIMIT_MM) -> tuple[Breaks, ChordError]:
    """Few places for `skin_of` at which the mesh stays within `limit_mm` of the surface, and what it reaches.

    Raises:
        QualityError: Not reached: the last has a crease.
    """
    first = even_breaks(_FIRST)
    seen = chord_error(shoelast, first)
    breaks, error, allowed = first, seen, 0.5 * _INSIDE * limit_mm  # a diagonal strays as far as two steps together
    for _ in range(_ROUNDS):
        breaks = Breaks(
            _spread(first.along, seen.along, allowed),
            _spread(first.up, seen.up, allowed),
            _spread(first.across, seen.across, allowed),
        )
        error = chord_error(shoelast, breaks)
        if error.bound_mm <= limit_mm:
            return breaks, error
        allowed *= _SPARE * limit_mm / error.bound_mm
    raise QualityError(
        f"{shoelast.name}: a mesh of {len(breaks.around)} x {len(breaks.up)} points strays {error.bound_mm:.3f} mm "
        f"from the surface, at most {limit_mm:g} mm is allowed: the surface has a crease; import or customise it again."
    )


def _spread(breaks: Floats, gap: Floats, allowed: float) -> Floats:
    """Breaks so dense everywhere that no step strays further than allowed, if `gap` is what even ones stray."""
    steps = np.sqrt(np.maximum(gap, 0.0) / allowed)
    wide = np.concatenate([steps[:1], steps, steps[-1:]])
    steps = np.maximum.reduce([wide[:-2], wide[1:-1], wide[2:]])
    steps = np.maximum(steps, _SLOWEST * steps.max())
    total = np.concatenate([[0.0], np.cumsum(steps)])
    count = int(np.clip(np.ceil(total[-1]), 2, _MOST_STEPS))
    return np.interp(np.arange(count + 1) / count * total[-1], total, breaks)
