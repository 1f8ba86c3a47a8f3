"""Compiled loops of the spline fit: bases at scattered parameters and the banded normal equations.

Columns of the control net are folded (0, n-1, 1, n-2, ...) so that the periodic direction stays banded: neighbours
within three columns are at most six places apart.
"""

import numpy as np

from footscan.compiled import compiled, compiled_inline
from footscan.coordinates import Floats, Ints


@compiled_inline
def folded(column: int, count: int) -> int:
    """Place of a column in the folded order."""
    column = column % count
    return 2 * column if 2 * column < count else 2 * (count - 1 - column) + 1


@compiled
def cubic_bases(t: Floats, knots: Floats, first: Ints, value: Floats, slope: Floats) -> None:
    """The four cubic B-splines and their derivatives at each of `(n,)` parameters.

    Args:
        t: Parameters inside knots[3] .. knots[-4].
        knots: Non-decreasing knots.
        first: `(n,)` result: index of the first of the four.
        value: `(n, 4)` result.
        slope: `(n, 4)` result, per unit of t.
    """
    last = len(knots) - 5
    for k in range(len(t)):
        x = t[k]
        low, high = 3, last + 1
        while high - low > 1:
            middle = (low + high) // 2
            if knots[middle] <= x:
                low = middle
            else:
                high = middle
        i = low
        first[k] = i - 3
        a1, a2, a3 = x - knots[i], x - knots[i - 1], x - knots[i - 2]
        b1, b2, b3 = knots[i + 1] - x, knots[i + 2] - x, knots[i + 3] - x
        q1 = 1.0 / (a1 + b1)
        l0, l1 = b1 * q1, a1 * q1
        q20, q21 = 1.0 / (a2 + b1), 1.0 / (a1 + b2)
        m0, m1, m2 = b1 * l0 * q20, a2 * l0 * q20 + b2 * l1 * q21, a1 * l1 * q21
        q30, q31, q32 = 1.0 / (a3 + b1), 1.0 / (a2 + b2), 1.0 / (a1 + b3)
        value[k, 0] = b1 * m0 * q30
        value[k, 1] = a3 * m0 * q30 + b2 * m1 * q31
        value[k, 2] = a2 * m1 * q31 + b3 * m2 * q32
        value[k, 3] = a1 * m2 * q32
        slope[k, 0] = -3.0 * m0 * q30
        slope[k, 1] = 3.0 * (m0 * q30 - m1 * q31)
        slope[k, 2] = 3.0 * (m1 * q31 - m2 * q32)
        slope[k, 3] = 3.0 * m2 * q32


@compiled
def add_normal_equations(
    first_u: Ints,
    basis_u: Floats,
    first_v: Ints,
    basis_v: Floats,
    weight: Floats,
    target: Floats,
    count_u: int,
    count_v: int,
    band: Floats,
    right: Floats,
) -> None:
    """Add weighted points to the lower band `(band + 1, n)` and the right sides `(n, 3)` of the normal equations."""
    where = np.empty(16, np.int64)
    b = np.empty(16, np.float64)
    for k in range(len(weight)):
        w = weight[k]
        if w <= 0.0:
            continue
        for i in range(4):
            base = folded(first_u[k] + i, count_u) * count_v + first_v[k]
            for j in range(4):
                where[4 * i + j] = base + j
                b[4 * i + j] = basis_u[k, i] * basis_v[k, j]
        for i in range(16):
            wb = w * b[i]
            row = where[i]
            for c in range(3):
                right[row, c] += wb * target[k, c]
            for j in range(16):
                column = where[j]
                if row >= column:
                    band[column, row - column] += wb * b[j]


@compiled
def add_stiffness(gram_u: Floats, gram_v: Floats, weight: Floats, count_u: int, count_v: int, band: Floats) -> None:
    """Add the energy of second differences to the band.

    Args:
        gram_u: `(3,)` weights of the differences around, up and mixed.
        gram_v: `(n_v, 2)` the neighbouring row spacings (below, above) over their mean.
        weight: `(n_v, n_u)` local stiffness at each control point.
        count_u: Control columns.
        count_v: Control rows.
        band: The lower band to add to.
    """
    where = np.empty(4, np.int64)
    factor = np.empty(4, np.float64)
    for i in range(count_u):
        before, here, after = folded(i + count_u - 1, count_u), folded(i, count_u), folded(i + 1, count_u)
        for j in range(count_v):
            w = weight[j, i]
            for kind in range(3):
                if kind == 0:
                    where[0], where[1], where[2] = before * count_v + j, here * count_v + j, after * count_v + j
                    factor[0], factor[1], factor[2] = 1.0, -2.0, 1.0
                    terms = 3
                elif kind == 1:
                    if j == 0 or j == count_v - 1:
                        continue
                    below, above = gram_v[j, 0], gram_v[j, 1]
                    where[0], where[1], where[2] = here * count_v + j - 1, here * count_v + j, here * count_v + j + 1
                    factor[0], factor[1], factor[2] = 1.0 / below, -1.0 / below - 1.0 / above, 1.0 / above
                    terms = 3
                else:
                    if j == count_v - 1:
                        continue
                    where[0], where[1] = here * count_v + j, here * count_v + j + 1
                    where[2], where[3] = after * count_v + j, after * count_v + j + 1
                    factor[0], factor[1], factor[2], factor[3] = 1.0, -1.0, -1.0, 1.0
                    terms = 4
                for a in range(terms):
                    for c in range(terms):
                        if where[a] >= where[c]:
                            band[where[c], where[a] - where[c]] += w * gram_u[kind] * factor[a] * factor[c]


@compiled
def evaluate_scattered(
    first_u: Ints,
    basis_u: Floats,
    slope_u: Floats,
    first_v: Ints,
    basis_v: Floats,
    slope_v: Floats,
    net: Floats,
    place: Floats,
    along_u: Floats,
    along_v: Floats,
) -> None:
    """Surface points and first derivatives `(n, 3)` at scattered parameters, written to the last three arguments."""
    count_u = net.shape[1]
    for k in range(len(first_u)):
        for c in range(3):
            place[k, c] = 0.0
            along_u[k, c] = 0.0
            along_v[k, c] = 0.0
        for i in range(4):
            column = (first_u[k] + i) % count_u
            for j in range(4):
                row = first_v[k] + j
                bb, sb, bs = basis_u[k, i] * basis_v[k, j], slope_u[k, i] * basis_v[k, j], basis_u[k, i] * slope_v[k, j]
                for c in range(3):
                    x = net[row, column, c]
                    place[k, c] += bb * x
                    along_u[k, c] += sb * x
                    along_v[k, c] += bs * x
