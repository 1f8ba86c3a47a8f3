"""Weighted least squares fit of a spline tube to scattered points whose parameters are known."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from footscan.coordinates import Floats, Ints
from footscan.foot.nurbs import SplineTube, greville, periodic_knots
from footscan.foot.nurbs_kernels import add_normal_equations, add_stiffness, cubic_bases, evaluate_scattered

_FLOOR = 1e-9  # added to the diagonal, so that the equations stay definite without any point


@dataclass(frozen=True)
class Bases:
    """Four basis functions and slopes in one direction at `(n,)` parameters."""

    first: Ints
    value: Floats
    slope: Floats


@dataclass(frozen=True)
class Scattered:
    """Surface places and derivatives `(n, 3)` at scattered parameters, mm and mm per unit parameter."""

    xyz_mm: Floats
    along_u: Floats
    along_v: Floats


def bases_at(t: Floats, knots: Floats) -> Bases:
    """Cubic bases at parameters; those outside the knots are moved to the end."""
    inside = np.ascontiguousarray(np.clip(t, knots[3], np.nextafter(knots[-4], -1.0)))
    first, value, slope = np.empty(len(t), np.int64), np.empty((len(t), 4)), np.empty((len(t), 4))
    cubic_bases(inside, knots, first, value, slope)
    return Bases(first, value, slope)


def fit_tube(
    u: Floats, v: Floats, xyz_mm: Floats, weight: Floats, count_u: int, knots_v: Floats, stiffness: Floats
) -> SplineTube:
    """Solve the weighted normal equations with a small bending energy.

    Args:
        u: `(n,)` periodic parameters.
        v: `(n,)` parameters in 0..1.
        xyz_mm: `(n, 3)` targets.
        weight: `(n,)`.
        count_u: Control points around.
        knots_v: Clamped knots.
        stiffness: `(n_v, n_u)` weight of the squared second differences of the control net.

    Returns:
        The fitted tube.
    """
    count_v = len(knots_v) - 4
    around, up = bases_at(np.mod(u, 1.0), periodic_knots(count_u)), bases_at(v, knots_v)
    n = count_u * count_v
    band, right = np.zeros((n, 6 * count_v + 4)), np.zeros((n, 3))
    order = np.lexsort((up.first, around.first))
    add_normal_equations(
        around.first[order],
        around.value[order],
        up.first[order],
        up.value[order],
        weight[order],
        xyz_mm[order],
        count_u,
        count_v,
        band,
        right,
    )
    add_stiffness(
        np.array([1.0, 1.0, 2.0]), row_spacing(knots_v), np.ascontiguousarray(stiffness), count_u, count_v, band
    )
    band[:, 0] += _FLOOR
    factor = cholesky_banded(band.T, overwrite_ab=True, lower=True, check_finite=False)
    solved = cho_solve_banded((factor, True), right, overwrite_b=True, check_finite=False)
    place = fold_order(count_u)
    return SplineTube(np.ascontiguousarray(solved.reshape(count_u, count_v, 3)[place].transpose(1, 0, 2)), knots_v)


def fold_order(count: int) -> Ints:
    """Where each column of the net stands in the folded order."""
    column = np.arange(count)
    return np.where(2 * column < count, 2 * column, 2 * (count - 1 - column) + 1)


def row_spacing(knots_v: Floats) -> Floats:
    """`(n_v, 2)` spacing of the Greville abscissae below and above each row over their mean."""
    place = greville(knots_v)
    gap = np.maximum(np.diff(place), 1e-9)
    both = np.stack([np.concatenate([gap[:1], gap]), np.concatenate([gap, gap[-1:]])], axis=1)
    return both / both.mean(axis=1, keepdims=True)


def evaluate_at(tube: SplineTube, u: Floats, v: Floats) -> Scattered:
    """Places and first derivatives at `(n,)` scattered parameters."""
    around, up = bases_at(np.mod(u, 1.0), tube.knots_u), bases_at(v, tube.knots_v)
    result = Scattered(*(np.empty((len(u), 3)) for _ in range(3)))
    evaluate_scattered(
        around.first,
        around.value,
        around.slope,
        up.first,
        up.value,
        up.slope,
        tube.net_mm,
        result.xyz_mm,
        result.along_u,
        result.along_v,
    )
    return result


def nearer_parameters(
    tube: SplineTube, u: Floats, v: Floats, xyz_mm: Floats, largest_step: tuple[float, float]
) -> tuple[Floats, Floats]:
    """One Gauss-Newton step of each point's parameters to its foot on the surface (Hoschek's correction)."""
    here = evaluate_at(tube, u, v)
    miss = xyz_mm - here.xyz_mm
    uu, vv = (here.along_u**2).sum(1), (here.along_v**2).sum(1)
    uv = (here.along_u * here.along_v).sum(1)
    eu, ev = (miss * here.along_u).sum(1), (miss * here.along_v).sum(1)
    determinant = np.maximum(uu * vv - uv**2, 0.02 * uu * vv + 1e-12)
    step_u = np.clip((vv * eu - uv * ev) / determinant, -largest_step[0], largest_step[0])
    step_v = np.clip((uu * ev - uv * eu) / determinant, -largest_step[1], largest_step[1])
    return np.mod(u + step_u, 1.0), np.clip(v + step_v, 0.0, 1.0)


def distance_mm(tube: SplineTube, u: Floats, v: Floats, xyz_mm: Floats) -> Floats:
    """Signed distance `(n,)` of points from the tangent plane at their parameters; positive outside."""
    here = evaluate_at(tube, u, v)
    normal = np.cross(here.along_u, here.along_v)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    return ((xyz_mm - here.xyz_mm) * normal).sum(1)
