"""NURBS patches through a parted mesh: the upper by least squares on its chart, the discs over their chords."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_array

from footscan.coordinates import Bools, Floats, Ints
from footscan.foot.nurbs import SplineTube, clamped_knots, graded_breaks
from footscan.foot.nurbs_fit import bases_at, distance_mm, fit_tube, nearer_parameters
from footscan.shoelast.import_chart import Chart
from footscan.shoelast.patches import LATERAL, MEDIAL, ChordDisc, ruled_disc

COUNT_U, COUNT_V = 128, 40
_COARSE_U, _COARSE_V = 48, 24
_EDGE_WEIGHT = 30.0
_EDGE_STEP_MM = 0.5
_STIFF, _STIFF_COARSE = 2e-3, 5e-2
_ROUNDS = 1
_DISC_BREAKS = 11
_DISC_STIFF = 1e-3


@dataclass(frozen=True)
class EdgeLine:
    """A closed edge in order of growing u: `xyz` `(k, 3)` and `u` `(k,)`."""

    xyz: Floats
    u: Floats

    def dense(self) -> "EdgeLine":
        """Places every half millimetre along its straight pieces."""
        start = int(self.u.argmin())
        u = np.roll(self.u, -start)
        xyz = np.roll(self.xyz, -start, axis=0)
        u, xyz = np.append(u, u[0] + 1.0), np.vstack([xyz, xyz[:1]])
        step = np.linalg.norm(np.diff(xyz, axis=0), axis=1)
        walked = np.concatenate([[0.0], np.cumsum(step)])
        places = np.arange(0.0, walked[-1], _EDGE_STEP_MM)
        dense = np.stack([np.interp(places, walked, xyz[:, k]) for k in range(3)], axis=1)
        return EdgeLine(dense, np.mod(np.interp(places, walked, u), 1.0))


@dataclass(frozen=True)
class FittedUpper:
    """The tube and how far `(k,)` the measured vertices lie off it (mm, outside positive)."""

    tube: SplineTube
    deviation_mm: Floats


def fit_upper(xyz: Floats, chart: Chart, measured: Bools, feather: EdgeLine, cone: EdgeLine) -> FittedUpper:
    """Fit the tube.

    Args:
        xyz: `(n, 3)` vertices of the whole mesh.
        chart: Of the upper.
        measured: `(n,)` vertices that are no bridge; only they count.
        feather: Edge at v = 0.
        cone: Edge at v = 1.
    """
    keep = measured[chart.vertex] & (chart.v > 0.0) & (chart.v < 1.0)
    u, v, points = chart.u[keep], chart.v[keep], xyz[chart.vertex[keep]]
    edges = [(line.dense(), level) for line, level in ((feather, 0.0), (cone, 1.0))]
    edge_u = np.concatenate([line.u for line, _ in edges])
    edge_v = np.concatenate([np.full(len(line.u), level) for line, level in edges])
    edge_xyz = np.vstack([line.xyz for line, _ in edges])

    def fitted(count_u: int, knots_v: Floats, stiff: float) -> SplineTube:
        weight = np.concatenate([np.ones(len(u)), np.full(len(edge_u), _EDGE_WEIGHT)])
        stiffness = np.full((len(knots_v) - 4, count_u), stiff * len(u) / (count_u * (len(knots_v) - 4)))
        return fit_tube(
            np.concatenate([u, edge_u]),
            np.concatenate([v, edge_v]),
            np.vstack([points, edge_xyz]),
            weight,
            count_u,
            knots_v,
            stiffness,
        )

    coarse = fitted(_COARSE_U, clamped_knots(np.linspace(0.0, 1.0, _COARSE_V - 2)), _STIFF_COARSE)
    knots_v = clamped_knots(graded_breaks(_density(coarse), COUNT_V - 3))
    tube = fitted(COUNT_U, knots_v, _STIFF)
    for _ in range(_ROUNDS):
        u, v = nearer_parameters(tube, u, v, points, (0.5 / COUNT_U, 0.5 / COUNT_V))
        tube = fitted(COUNT_U, knots_v, _STIFF)
    u, v = nearer_parameters(tube, u, v, points, (0.5 / COUNT_U, 0.5 / COUNT_V))
    return FittedUpper(tube, distance_mm(tube, u, v, points))


def _density(coarse: SplineTube) -> Floats:
    """How many knots per unit v: as the longest ribs need them, more at the feather edge and at the cone edge."""
    v = np.linspace(0.0, 1.0, 200)
    pace = np.linalg.norm(coarse.grid(np.arange(96) / 96, v, 0, 1), axis=-1)
    need = np.percentile(pace, 80, axis=1) + 0.3 * pace.max(axis=1)
    walked = np.concatenate([[0.0], np.cumsum(0.5 * (need[1:] + need[:-1]))])
    share = walked / walked[-1]
    return need * (1.0 + 2.0 * np.exp(-share / 0.05) + 1.0 * np.exp(-(1.0 - share) / 0.05))


@dataclass(frozen=True)
class FittedDisc:
    """The disc and how far `(k,)` the vertices inside lie off it (mm, upright)."""

    disc: ChordDisc
    deviation_mm: Floats


def fit_disc(xyz: Floats, row_mm: Floats, tube: SplineTube, level: float) -> FittedDisc:
    """A disc of chords over its plan whose heights are fitted; its edge is the tube's own.

    Args:
        xyz: `(k, 3)` places inside the edge.
        row_mm: `(n_u, 3)` control points of the edge.
        tube: The upper.
        level: v of the edge.
    """
    ruled = ruled_disc(row_mm, np.linspace(0.0, 1.0, _DISC_BREAKS))
    s, t = _chord_parameters(xyz, tube, level)
    along, across = bases_at(s, ruled.knots_s), bases_at(t, ruled.knots_t)
    count_s, count_t = ruled.net_mm.shape[:2]
    columns = (along.first[:, None] + np.arange(4))[:, :, None] * count_t + (across.first[:, None] + np.arange(4))[
        :, None
    ]
    values = along.value[:, :, None] * across.value[:, None, :]
    rows = np.repeat(np.arange(len(s)), 16)
    design = csr_array((values.reshape(-1), (rows, columns.reshape(-1))), shape=(len(s), count_s * count_t))
    inner = np.zeros((count_s, count_t), dtype=np.bool_)
    inner[1:-1, 1:-1] = True
    chosen = np.flatnonzero(inner)
    miss = xyz[:, 2] - design @ ruled.net_mm[:, :, 2].reshape(-1)
    left = (design.T @ design).toarray()[np.ix_(chosen, chosen)] + _stiffness(count_s, count_t, chosen, len(s))
    height = np.zeros(count_s * count_t)
    height[chosen] = cho_solve(cho_factor(left), (design.T @ miss)[chosen])
    net = ruled.net_mm.copy()
    net[:, :, 2] += height.reshape(count_s, count_t)
    return FittedDisc(ChordDisc(net, ruled.knots_s, ruled.knots_t), miss - design @ height)


def _stiffness(count_s: int, count_t: int, chosen: Ints, points: int) -> Floats:
    """Squared second differences of the heights, both ways."""
    second_s, second_t = (np.diff(np.eye(n), 2, axis=0) for n in (count_s, count_t))
    whole = np.kron(second_s.T @ second_s, np.eye(count_t)) + np.kron(np.eye(count_s), second_t.T @ second_t)
    scale = _DISC_STIFF * points / len(chosen)
    return scale * whole[np.ix_(chosen, chosen)] + 1e-6 * np.eye(len(chosen))


def _chord_parameters(xyz: Floats, tube: SplineTube, level: float) -> tuple[Floats, Floats]:
    """Which chord `(k,)` and which place along it `(k,)` each point has in plan; chords are ordered, so bisected."""
    share = np.linspace(0.0, 1.0, 1025)
    lateral, medial = (
        tube.grid(half[0] + (half[1] - half[0]) * share, np.array([level]))[0, :, :2] for half in (LATERAL, MEDIAL)
    )
    s, step = np.full(len(xyz), 0.5), 0.25
    for _ in range(30):
        a, b = _at(share, lateral, s), _at(share, medial, s)
        front = (b[:, 0] - a[:, 0]) * (xyz[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (xyz[:, 0] - a[:, 0]) < 0
        s, step = s + np.where(front, step, -step), 0.5 * step
    a, b = _at(share, lateral, s), _at(share, medial, s)
    chord = b - a
    along = ((xyz[:, :2] - a) * chord).sum(axis=1) / np.maximum((chord**2).sum(axis=1), 1e-9)
    return s, np.clip(along, 0.0, 1.0)


def _at(share: Floats, xy: Floats, s: Floats) -> Floats:
    return np.stack([np.interp(s, share, xy[:, k]) for k in range(2)], axis=1)
