"""Parameters of the vertices of an upper: a harmonic map with positive weights, so one to one.

The upper is a ring: v is 0 at the feather edge and 1 at the cone edge, u runs round from the heel along the medial
side. u jumps by one turn somewhere; edges know how many turns they cross from the angle about an upright axis through
the cone, which meets bottom and cone top only. Both follow from one sparse factorisation.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from footscan.coordinates import Bools, Floats, Ints

_FLOOR = 0.05
_STEP_SHARE = 0.2


@dataclass(frozen=True)
class Chart:
    """Vertices of the upper `(k,)` and their parameters `u` and `v` `(k,)`."""

    vertex: Ints
    u: Floats
    v: Floats


def loop_shares(xyz: Floats, heel: int, toe: int) -> Floats:
    """Shares u `(k,)` of a closed line's vertices, 0 at `heel`, 1/2 at `toe`, equal at equal x on both halves.

    Args:
        xyz: `(k, 3)` in order of growing u; x grows from heel to toe on both halves, or nearly so.
        heel: Where u is 0.
        toe: Where u is 1/2.
    """
    count = len(xyz)
    turned = np.roll(xyz, -heel, axis=0)
    half = (toe - heel) % count
    share = (turned[:, 0] - turned[0, 0]) / (turned[half, 0] - turned[0, 0])
    u = np.arccos(np.clip(1.0 - 2.0 * share, -1.0, 1.0)) / (2.0 * np.pi)
    out = _rising(u[: half + 1])[:-1]
    back = _rising(np.append(u[half:], 0.0)[::-1])[::-1][:-1]
    return np.roll(np.concatenate([out, np.mod(1.0 - back, 1.0)]), heel)


def smoothed_loop(xyz: Floats, sigma_mm: float) -> Floats:
    """A closed line `(k, 3)` averaged along itself with a Gaussian, at its own vertices."""
    closed = np.vstack([xyz, xyz[:1]])
    walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    count = int(np.ceil(walked[-1] / (_STEP_SHARE * sigma_mm)))
    places = walked[-1] * np.arange(count) / count
    even = np.stack([np.interp(places, walked, closed[:, k]) for k in range(3)], axis=1)
    damping = np.exp(-0.5 * (2.0 * np.pi * np.fft.rfftfreq(count, walked[-1] / count) * sigma_mm) ** 2)
    smooth = np.fft.irfft(np.fft.rfft(even, axis=0) * damping[:, None], count, axis=0)
    at = np.append(places, walked[-1])
    return np.stack([np.interp(walked[:-1], at, np.append(smooth[:, k], smooth[0, k])) for k in range(3)], axis=1)


def _rising(values: Floats) -> Floats:
    """Values made strictly to rise from the first to the last, moved as little as a running maximum does."""
    ends, small = (values[0], values[-1]), 1e-7 * np.arange(len(values))
    risen = np.maximum.accumulate(values) + small
    return ends[0] + (risen - risen[0]) * (ends[1] - ends[0]) / (risen[-1] - risen[0])


def chart_upper(xyz: Floats, faces: Ints, feather: Ints, feather_u: Floats, cone: Ints, cone_u: Floats) -> Chart:
    """Parameters of the upper's vertices.

    Args:
        xyz: `(n, 3)` in the rough frame.
        faces: `(m, 3)` of the upper.
        feather: Vertices of the feather edge with their u `(k,)`.
        feather_u: See `feather`.
        cone: The same for the cone edge.
        cone_u: See `cone`.
    """
    vertex, local = np.unique(faces, return_inverse=True)
    ends, weight = _weights(xyz[vertex], local.reshape(-1, 3))
    fixed, u, v = _edges_fixed(vertex, feather, feather_u, cone, cone_u)
    centre = xyz[cone].mean(axis=0)
    angle = np.arctan2(xyz[vertex, 1] - centre[1], xyz[vertex, 0] - centre[0])
    turn = (np.pi - angle) / (2.0 * np.pi)
    u = np.where(fixed, u + np.round(turn - u), 0.0)
    jump = -np.round(turn[ends[:, 1]] - turn[ends[:, 0]])
    solved = _harmonic(len(vertex), ends, weight, fixed, np.stack([u, v], axis=1), jump)
    return Chart(vertex, np.mod(solved[:, 0], 1.0), np.clip(solved[:, 1], 0.0, 1.0))


def _edges_fixed(
    vertex: Ints, feather: Ints, feather_u: Floats, cone: Ints, cone_u: Floats
) -> tuple[Bools, Floats, Floats]:
    fixed, u, v = np.zeros(len(vertex), np.bool_), np.zeros(len(vertex)), np.zeros(len(vertex))
    for loop, share, level in ((feather, feather_u, 0.0), (cone, cone_u, 1.0)):
        at = np.searchsorted(vertex, loop)
        fixed[at], u[at], v[at] = True, share, level
    return fixed, u, v


def _weights(xyz: Floats, faces: Ints) -> tuple[Ints, Floats]:
    """Edges `(k, 2)` and positive weights: cotangents where they are positive, else a floor."""
    corner = xyz[faces]
    ends, weight = [], []
    for k in range(3):
        a, b, c = k, (k + 1) % 3, (k + 2) % 3
        first, second = corner[:, a] - corner[:, c], corner[:, b] - corner[:, c]
        sine = np.linalg.norm(np.cross(first, second), axis=1)
        ends.append(faces[:, [a, b]])
        weight.append(0.5 * (first * second).sum(axis=1) / np.maximum(sine, 1e-9))
    both, cot = np.sort(np.concatenate(ends), axis=1), np.clip(np.concatenate(weight), -10.0, 10.0)
    key, place = np.unique(both[:, 0] * len(xyz) + both[:, 1], return_inverse=True)
    total = np.bincount(place.reshape(-1), weights=cot)
    return np.stack([key // len(xyz), key % len(xyz)], axis=1), np.maximum(total, _FLOOR)


def _harmonic(size: int, ends: Ints, weight: Floats, fixed: Bools, value: Floats, jump: Floats) -> Floats:
    """Solve for the free vertices; the first value grows by `jump` beyond plain difference along each edge."""
    a, b = ends.T
    matrix = coo_array((np.r_[-weight, -weight], (np.r_[a, b], np.r_[b, a])), shape=(size, size)).tocsr()
    degree = np.bincount(a, weights=weight, minlength=size) + np.bincount(b, weights=weight, minlength=size)
    right = np.zeros((size, 2))
    right[:, 0] = np.bincount(a, weights=weight * jump, minlength=size)
    right[:, 0] -= np.bincount(b, weights=weight * jump, minlength=size)
    free = np.flatnonzero(~fixed)
    inner = matrix[free][:, free] + coo_array((degree[free], (np.arange(len(free)), np.arange(len(free)))))
    known = right[free] - matrix[free][:, np.flatnonzero(fixed)] @ value[fixed]
    solved = value.copy()
    solved[free] = splu(inner.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(known)
    return solved
