"""The compiled loop that follows a chart's directions from places in space to the upper (Newton, place by place)."""

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import Floats, Ints
from footscan.foot.nurbs_kernels import cubic_bases

_STEPS, _MISS_MM, _REACHED_MM = 12, 1e-4, 0.02
_MOST_U, _MOST_V, _MOST_T_MM = 0.02, 0.08, 12.0
_REGULAR = 1e-9


@compiled
def follow(net: Floats, direction: Floats, knots_v: Floats, xyz: Floats, found: Floats) -> None:
    """Solve S(u, v) + t n(u, v) = xyz for every place.

    Args:
        net: `(n_v, n_u, 3)` control points of S, periodic in u with uniform knots.
        direction: `(n_v, n_u, 3)` those of n.
        knots_v: `(n_v + 4,)` clamped.
        xyz: `(n, 3)` places.
        found: `(n, 3)` first guesses of (u, v, t), u in 0..1; the results, NaN in t where a place is not reached.
    """
    columns = net.shape[1]
    knots_u = np.arange(-3.0, columns + 4.0) / columns
    state = np.empty((6, 3))  # S, its slopes, n, its slopes
    jacobian, step = np.empty((3, 3)), np.empty(3)
    first, value, slope = np.empty(2, np.int64), np.empty((2, 4)), np.empty((2, 4))
    for i in range(len(xyz)):
        u, v, t = found[i]
        miss = np.inf
        for step_number in range(_STEPS + 1):
            _evaluate(net, direction, knots_u, knots_v, u, v, first, value, slope, state)
            miss = 0.0
            for axis in range(3):
                step[axis] = xyz[i, axis] - state[0, axis] - t * state[3, axis]
                jacobian[axis, 0] = state[1, axis] + t * state[4, axis]
                jacobian[axis, 1] = state[2, axis] + t * state[5, axis]
                jacobian[axis, 2] = state[3, axis]
                jacobian[axis, axis] += _REGULAR
                miss += step[axis] * step[axis]
            miss = np.sqrt(miss)
            if step_number == _STEPS or (step_number and miss < _MISS_MM) or not _solved(jacobian, step):
                break
            u = (u + min(max(step[0], -_MOST_U), _MOST_U)) % 1.0
            v = min(max(v + min(max(step[1], -_MOST_V), _MOST_V), 0.0), 1.0)
            t += min(max(step[2], -_MOST_T_MM), _MOST_T_MM)
        found[i, 0], found[i, 1], found[i, 2] = u, v, t if miss < _REACHED_MM else np.nan


@compiled
def _evaluate(
    net: Floats,
    direction: Floats,
    knots_u: Floats,
    knots_v: Floats,
    u: float,
    v: float,
    first: Ints,
    value: Floats,
    slope: Floats,
    state: Floats,
) -> None:
    """Places and slopes of surface and directions at one (u, v)."""
    low_u, high_u = knots_u[3], np.nextafter(knots_u[-4], -1.0)
    low_v, high_v = knots_v[3], np.nextafter(knots_v[-4], -1.0)
    at = np.array([min(max(u, low_u), high_u)])
    cubic_bases(at, knots_u, first[:1], value[:1], slope[:1])
    at[0] = min(max(v, low_v), high_v)
    cubic_bases(at, knots_v, first[1:], value[1:], slope[1:])
    state[:] = 0.0
    for a in range(4):
        column = (first[0] + a) % net.shape[1]
        for b in range(4):
            row = first[1] + b
            both, along_u, along_v = value[0, a] * value[1, b], slope[0, a] * value[1, b], value[0, a] * slope[1, b]
            for axis in range(3):
                x, n = net[row, column, axis], direction[row, column, axis]
                state[0, axis] += both * x
                state[1, axis] += along_u * x
                state[2, axis] += along_v * x
                state[3, axis] += both * n
                state[4, axis] += along_u * n
                state[5, axis] += along_v * n


@compiled
def _solved(a: Floats, b: Floats) -> bool:
    """Solve a 3x3 system in place of its right side by Cramer's rule; False where it is singular."""
    x0 = a[1, 1] * a[2, 2] - a[1, 2] * a[2, 1]
    x1 = a[1, 2] * a[2, 0] - a[1, 0] * a[2, 2]
    x2 = a[1, 0] * a[2, 1] - a[1, 1] * a[2, 0]
    det = a[0, 0] * x0 + a[0, 1] * x1 + a[0, 2] * x2
    if det == 0.0:
        return False
    b0, b1, b2 = b[0], b[1], b[2]
    b[0] = (x0 * b0 + (a[0, 2] * a[2, 1] - a[0, 1] * a[2, 2]) * b1 + (a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]) * b2) / det
    b[1] = (x1 * b0 + (a[0, 0] * a[2, 2] - a[0, 2] * a[2, 0]) * b1 + (a[0, 2] * a[1, 0] - a[0, 0] * a[1, 2]) * b2) / det
    b[2] = (x2 * b0 + (a[0, 1] * a[2, 0] - a[0, 0] * a[2, 1]) * b1 + (a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]) * b2) / det
    return True
