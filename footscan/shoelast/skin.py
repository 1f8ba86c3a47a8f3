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


def skin_of(shoelast: Shoelast, sampling: Sampling | None = None) -> LastSkin:
    """Sample a last; every edge of the mesh is shared by two faces."""
    fine = sampling or Sampling()
    u, v = np.arange(fine.round) / fine.round, np.linspace(0.0, 1.0, fine.up + 1)
    upper = shoelast.upper.grid(u, v).reshape(-1, 3)
    uv = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    sides = _tube_faces(fine.round, fine.up)
    begin = len(upper)
    low, low_faces = _disc(shoelast.bottom, fine, np.arange(fine.round), begin)
    high_rim = np.arange(fine.round) + fine.up * fine.round
    high, high_faces = _disc(shoelast.cone_top, fine, high_rim, begin + len(low))
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


def _disc(disc: ChordDisc, fine: Sampling, rim: Ints, begin: int) -> tuple[Floats, Ints]:
    """Inner points of a disc and its faces, counter-clockwise seen from above; `rim` are the indices of its edge."""
    half = fine.round // 2
    s, t = np.arange(1, half) / half, np.arange(1, fine.across) / fine.across
    inner = disc.grid(s, t).reshape(-1, 3)
    index = begin + np.arange(len(inner)).reshape(half - 1, fine.across - 1)
    rows = np.column_stack([rim[:half:-1], index, rim[1:half]])
    faces = _quads(rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:])
    heel = np.stack([np.full(fine.across, rim[0]), rows[0, :-1], rows[0, 1:]], axis=-1)
    toe = np.stack([np.full(fine.across, rim[half]), rows[-1, 1:], rows[-1, :-1]], axis=-1)
    return inner, np.vstack([faces, heel, toe])
