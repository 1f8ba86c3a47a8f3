"""The closed triangle mesh of a last: its patches sampled on common edges."""

from dataclasses import dataclass

import numpy as np
import trimesh

from footscan.coordinates import Floats, Ints
from footscan.shoelast.model import Shoelast
from footscan.shoelast.patches import ChordDisc

UPPER, BOTTOM, CONE_TOP = 0, 1, 2


@dataclass(frozen=True)
class Sampling:
    """How finely: `round` (even) steps of the edges, `up` steps of the upper, `across` steps of bottom and cone top."""

    round: int = 360
    up: int = 120
    across: int = 40


@dataclass(frozen=True)
class Breaks:
    """Where: unevenly spaced parameters from 0 to 1, so that bends get many points and flat places few.

    Attributes:
        along: `(h,)` from heel to toe, the same on both halves of the edges and on bottom and cone top.
        up: `(k,)` up the upper, from the feather edge.
        across: `(m,)` across bottom and cone top.
    """

    along: Floats
    up: Floats
    across: Floats

    @property
    def around(self) -> Floats:
        """`(2 h - 2,)` the parameters u once round the edges."""
        half = 0.5 * self.along
        return np.concatenate([half, 1.0 - half[-2:0:-1]])


def even_breaks(sampling: Sampling) -> Breaks:
    """The evenly spaced ones of a sampling."""
    half, up, across = sampling.round // 2, sampling.up, sampling.across
    return Breaks(np.arange(half + 1) / half, np.arange(up + 1) / up, np.arange(across + 1) / across)


@dataclass(frozen=True)
class LastSkin:
    """A closed mesh in the last's frame.

    Attributes:
        xyz_shoelast: `(n, 3)`.
        faces: `(m, 3)` counter-clockwise seen from outside.
        patch: `(m,)` UPPER, BOTTOM or CONE_TOP of every face.
        uv: `(k, 2)` parameters of the vertices of the upper, which are the first `k` ones: row after row of v.
    """

    xyz_shoelast: Floats
    faces: Ints
    patch: Ints
    uv: Floats

    def mesh(self) -> trimesh.Trimesh:
        """As trimesh, nothing merged or reordered."""
        return trimesh.Trimesh(self.xyz_shoelast, self.faces, process=False)


def skin_of(shoelast: Shoelast, sampling: Sampling | Breaks | None = None) -> LastSkin:
    """Sample a last; every edge of the mesh is shared by two faces."""
    breaks = sampling if isinstance(sampling, Breaks) else even_breaks(sampling or Sampling())
    u, v = breaks.around, breaks.up
    upper = shoelast.upper.grid(u, v).reshape(-1, 3)
    uv = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    sides = _tube_faces(len(u), len(v) - 1)
    begin = len(upper)
    low, low_faces = _disc(shoelast.bottom, breaks, np.arange(len(u)), begin)
    high_rim = np.arange(len(u)) + (len(v) - 1) * len(u)
    high, high_faces = _disc(shoelast.cone_top, breaks, high_rim, begin + len(low))
    parts = (sides, low_faces[:, ::-1], high_faces)
    patch = np.repeat([UPPER, BOTTOM, CONE_TOP], [len(part) for part in parts])
    return LastSkin(np.vstack([upper, low, high]), np.vstack(parts), patch, uv)


def _tube_faces(count: int, rows: int) -> Ints:
    here = np.arange(count)[None, :] + count * np.arange(rows)[:, None]
    ahead = np.roll(here, -1, axis=1)
    return _quads(here, here + count, ahead + count, ahead)


def _quads(a: Ints, b: Ints, c: Ints, d: Ints) -> Ints:
    """Two triangles for each quadrilateral a, b, c, d."""
    corners = [np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)]
    return np.concatenate([part.reshape(-1, 3) for part in corners])


def _disc(disc: ChordDisc, breaks: Breaks, rim: Ints, begin: int) -> tuple[Floats, Ints]:
    """Inner points of a disc and its faces, counter-clockwise seen from above; `rim` are the indices of its edge."""
    half, wide = len(breaks.along) - 1, len(breaks.across) - 1
    inner = disc.grid(breaks.along[1:-1], breaks.across[1:-1]).reshape(-1, 3)
    index = begin + np.arange(len(inner)).reshape(half - 1, wide - 1)
    rows = np.column_stack([rim[:half:-1], index, rim[1:half]])
    faces = _quads(rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:])
    heel = np.stack([np.full(wide, rim[0]), rows[0, :-1], rows[0, 1:]], axis=-1)
    toe = np.stack([np.full(wide, rim[half]), rows[-1, 1:], rows[-1, :-1]], axis=-1)
    return inner, np.vstack([faces, heel, toe])
