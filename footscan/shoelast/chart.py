"""The upper as a chart for a displacement: directions, basis rows and bending energy.

A displacement is a scalar field d(u, v) = sum c_ij B_i(u) B_j(v) along a smooth field of directions n(u, v) with the
control vectors n_ij. The displaced upper then has the control points P_ij + c_ij n_ij: exact NURBS on the same knots.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline

from footscan.coordinates import Bools, Floats, Ints
from footscan.foot.nurbs import DEGREE, SplineTube, greville
from footscan.foot.nurbs_fit import bases_at
from footscan.foot.sole_bend import smooth_step
from footscan.shoelast.chart_loops import REACH, WIDE, add_bending, average_normals, fill_rows
from footscan.shoelast.follow_loop import follow
from footscan.shoelast.model import Shoelast

LEVEL_BELOW_MM = 14.0
"""Up to this height above the feather edge the directions go over from level (in the bottom) to the skin's normal."""
STEADY_MM = 12.0
"""Normals are averaged over this reach. Along the bare normals of a hollow of radius r a displacement by d is bent
d / (r - d) times as much again: small waves of a last would turn into creases."""
Sparse = Any


@dataclass(frozen=True)
class Chart:
    """An upper with its directions.

    Attributes:
        tube: The upper.
        direction: The directions as a tube of the same knots: control vectors n_ij.
    """

    tube: SplineTube
    direction: SplineTube

    @property
    def shape(self) -> tuple[int, int]:
        """Control rows and columns."""
        return self.tube.net_mm.shape[0], self.tube.count_u

    def displaced(self, coefficients: Floats) -> SplineTube:
        """The upper with control points P_ij + c_ij n_ij, c `(n_v, n_u)`."""
        return SplineTube(self.tube.net_mm + coefficients[..., None] * self.direction.net_mm, self.tube.knots_v)

    def rows(self, u: Floats, v: Floats) -> Sparse:
        """Sparse `(n, n_v * n_u)`: the field at places from the coefficients, row after row."""
        around, up = bases_at(np.mod(u, 1.0), self.tube.knots_u), bases_at(v, self.tube.knots_v)
        column, value = np.empty((len(u), 16), np.int64), np.empty((len(u), 16))
        fill_rows(around.first, around.value, up.first, up.value, self.shape[1], column, value)
        begin = np.arange(0, 16 * len(u) + 1, 16)
        return sparse.csr_matrix((value.ravel(), column.ravel(), begin), shape=(len(u), self.shape[0] * self.shape[1]))


def build_chart(shoelast: Shoelast) -> Chart:
    """The chart of a last: level and outward at the feather edge, the skin's normal from some height on."""
    tube = shoelast.upper
    u, v = _greville_round(tube.count_u), greville(tube.knots_v)
    xyz, normal = tube.grid(u, v), np.empty((len(v), len(u), 3))
    across = np.cross(tube.grid(u, v, order_v=1), tube.grid(u, v, order_u=1)) * np.gradient(v)[:, None, None]
    average_normals(xyz, across, STEADY_MM, normal)
    height = xyz[..., 2] - tube.grid(u, np.array([0.0]))[..., 2]
    flat = 1.0 - smooth_step(height / LEVEL_BELOW_MM)
    along = tube.grid(u, np.array([0.0]), order_u=1)[0]
    outward = np.column_stack([along[:, 1], -along[:, 0], np.zeros(len(along))])
    outward *= np.sign((outward * normal[0]).sum(axis=1, keepdims=True))
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    mixed = (1.0 - flat)[..., None] * normal + flat[..., None] * outward[None]
    mixed /= np.linalg.norm(mixed, axis=2, keepdims=True)
    return Chart(tube, SplineTube(mixed, tube.knots_v))


def greville_places(tube: SplineTube) -> tuple[Floats, Floats]:
    """Where the columns `(n_u,)` and rows `(n_v,)` of a net act most."""
    return _greville_round(tube.count_u), greville(tube.knots_v)


def _greville_round(count: int) -> Floats:
    """Where each column of a periodic net acts most."""
    return np.mod((np.arange(count) - 1.0) / count, 1.0)


def unit_normals(tube: SplineTube, u: Floats, v: Floats) -> Floats:
    """Outward unit normals `(k, m, 3)` on a grid."""
    normal = np.cross(tube.grid(u, v, order_v=1), tube.grid(u, v, order_u=1))
    return normal / np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-12)


def bending_matrix(tube: SplineTube, fair_mm: float = 0.0, moving: Bools | None = None) -> Sparse:
    """Energy of a scalar field on the upper: c' K c = integral of its squared covariant Hessian H over the surface.

    With `fair_mm` = l the integral is that of H^2 + l^2 (dH/ds)^2: bends shorter than about l cost more.

    Args:
        tube: The upper.
        fair_mm: l.
        moving: `(n_v, n_u)` coefficients whose rows are needed; the spans that none of them reaches are left out.

    Returns:
        Sparse symmetric `(n_v * n_u, n_v * n_u)`.
    """
    breaks = tube.knots_v[DEGREE:-DEGREE]
    offset = np.array([-1.0, 1.0]) / np.sqrt(12.0) + 0.5
    u = ((np.arange(tube.count_u)[:, None] + offset) / tube.count_u).ravel()
    v = (breaks[:-1, None] + np.diff(breaks)[:, None] * offset).ravel()
    weight = np.repeat(0.5 * np.diff(breaks), 2)[:, None] * np.full(len(u), 0.5 / tube.count_u)[None]
    if moving is not None:
        weight = weight * np.repeat(np.repeat(_reached_spans(moving), 2, axis=0), 2, axis=1)
    apart = offset[1] - offset[0]
    step = np.concatenate([[apart / tube.count_u], apart * np.diff(breaks)])
    orders = ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    tangents = np.stack([tube.grid(u, v, order_u=a, order_v=b) for a, b in orders], axis=2)
    stencil = np.zeros((*tube.net_mm.shape[:2], WIDE, WIDE))
    first_u, basis_u = _basis_table(u, tube.knots_u)
    first_v, basis_v = _basis_table(v, tube.knots_v)
    places = np.ascontiguousarray(tangents)
    add_bending(first_u, basis_u, first_v, basis_v, places, weight, step, fair_mm**2, stencil)
    return _matrix_from_stencil(stencil)


def _reached_spans(moving: Bools) -> Bools:
    """Spans `(n_v - 3, n_u)` in which some of the coefficients `(n_v, n_u)` act."""
    around = np.logical_or.reduce([np.roll(moving, -k, axis=1) for k in range(DEGREE + 1)])
    return np.logical_or.reduce([around[k : len(around) - DEGREE + k] for k in range(DEGREE + 1)])


def _basis_table(t: Floats, knots: Floats) -> tuple[Ints, Floats]:
    """First of the four basis functions `(n,)` and their values and two derivatives `(n, 3, 4)`."""
    count = len(knots) - DEGREE - 1
    spline = BSpline(knots, np.eye(count), DEGREE)
    first = np.clip(np.searchsorted(knots, t, side="right") - 1 - DEGREE, 0, count - 4)
    place = first[:, None] + np.arange(4)
    table = np.stack([np.take_along_axis(spline(t, nu=order), place, axis=1) for order in range(3)], axis=1)
    return first.astype(np.int64), np.ascontiguousarray(table)


def _matrix_from_stencil(stencil: Floats) -> Sparse:
    rows, columns = stencil.shape[:2]
    j, i, dj, di = np.nonzero(stencil)
    other = (j + dj - REACH) * columns + (i + di - REACH) % columns
    return sparse.csc_matrix((stencil[j, i, dj, di], (j * columns + i, other)), shape=(rows * columns,) * 2)


def project(chart: Chart, tube: SplineTube, xyz: Floats, u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
    """Follow the directions from places in space to the upper: S(u, v) + t n(u, v) = xyz.

    Args:
        chart: Directions.
        tube: The upper, displaced or not, of the same knots.
        xyz: `(n, 3)` places near it.
        u: `(n,)` first guess.
        v: `(n,)` first guess.

    Returns:
        u, v and t (mm, positive outside), each `(n,)`; NaN in t where the places are not reached along a direction.
    """
    found = np.column_stack([np.mod(u, 1.0), v, np.zeros(len(u))])
    nets = np.ascontiguousarray(tube.net_mm), np.ascontiguousarray(chart.direction.net_mm)
    parts = np.linspace(0, len(u), _AT_ONCE + 1).astype(np.int64)
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        halves = [slice(begin, end) for begin, end in pairwise(parts)]
        list(pool.map(lambda here: follow(*nets, tube.knots_v, xyz[here], found[here]), halves))
    return found[:, 0].copy(), found[:, 1].copy(), found[:, 2].copy()


_AT_ONCE = 2
