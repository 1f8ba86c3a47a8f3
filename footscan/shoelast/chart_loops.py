"""Compiled loops over the upper's control net: bending energy as a stencil, and sparse rows of scattered places."""

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import Floats, Ints

REACH = 3
WIDE = 2 * REACH + 1


@compiled
def add_bending(
    first_u: Ints, basis_u: Floats, first_v: Ints, basis_v: Floats, tangents: Floats, weight: Floats, stencil: Floats
) -> None:
    """Add the squared covariant Hessian of a scalar field at places of a grid.

    Args:
        first_u: `(m,)` first of the four control columns at every u.
        basis_u: `(m, 3, 4)` their values, first and second derivatives.
        first_v: `(k,)` first of the four control rows at every v.
        basis_v: `(k, 3, 4)` likewise.
        tangents: `(k, m, 5, 3)` derivatives u, v, uu, uv, vv of the surface.
        weight: `(k, m)` parameter area of every place; 0 leaves it out.
        stencil: `(n_v, n_u, 7, 7)` to add to: entry (j, i, dj + 3, di + 3) couples (j, i) with (j + dj, i + di).
    """
    columns = stencil.shape[1]
    h = np.empty((16, 3))
    for k in range(weight.shape[0]):
        for m in range(weight.shape[1]):
            if weight[k, m] == 0.0:
                continue
            s = tangents[k, m]
            guu = s[0, 0] * s[0, 0] + s[0, 1] * s[0, 1] + s[0, 2] * s[0, 2]
            guv = s[0, 0] * s[1, 0] + s[0, 1] * s[1, 1] + s[0, 2] * s[1, 2]
            gvv = s[1, 0] * s[1, 0] + s[1, 1] * s[1, 1] + s[1, 2] * s[1, 2]
            det = guu * gvv - guv * guv
            area = np.sqrt(det)
            # an orthonormal frame: e1 along u; J holds u and v in it
            a = np.sqrt(guu)
            b, c = guv / a, area / a
            gamma = np.empty((3, 2))
            for d in range(3):
                du = s[2 + d, 0] * s[0, 0] + s[2 + d, 1] * s[0, 1] + s[2 + d, 2] * s[0, 2]
                dv = s[2 + d, 0] * s[1, 0] + s[2 + d, 1] * s[1, 1] + s[2 + d, 2] * s[1, 2]
                gamma[d, 0], gamma[d, 1] = (gvv * du - guv * dv) / det, (guu * dv - guv * du) / det
            for i in range(4):
                for j in range(4):
                    u0, u1, u2 = basis_u[m, 0, i], basis_u[m, 1, i], basis_u[m, 2, i]
                    v0, v1, v2 = basis_v[k, 0, j], basis_v[k, 1, j], basis_v[k, 2, j]
                    fu, fv = u1 * v0, u0 * v1
                    huu = u2 * v0 - gamma[0, 0] * fu - gamma[0, 1] * fv
                    huv = u1 * v1 - gamma[1, 0] * fu - gamma[1, 1] * fv
                    hvv = u0 * v2 - gamma[2, 0] * fu - gamma[2, 1] * fv
                    # into the frame: inverse of J = [[a, b], [0, c]]
                    h11 = huu / (a * a)
                    h12 = (huv - b * huu / a) / (a * c)
                    h22 = (hvv - 2.0 * b * huv / a + b * b * huu / (a * a)) / (c * c)
                    at = 4 * i + j
                    h[at, 0], h[at, 1], h[at, 2] = h11, 1.4142135623730951 * h12, h22
            w = weight[k, m] * area
            for p in range(16):
                i, j = (first_u[m] + p // 4) % columns, first_v[k] + p % 4
                for q in range(16):
                    di, dj = q // 4 - p // 4, q % 4 - p % 4
                    stencil[j, i, dj + REACH, di + REACH] += w * (
                        h[p, 0] * h[q, 0] + h[p, 1] * h[q, 1] + h[p, 2] * h[q, 2]
                    )


@compiled
def fill_rows(
    first_u: Ints, basis_u: Floats, first_v: Ints, basis_v: Floats, columns_u: int, column: Ints, value: Floats
) -> None:
    """Write the 16 columns and values `(n, 16)` of scattered places: control (j, i) is column j * columns_u + i."""
    for k in range(len(first_u)):
        for i in range(4):
            for j in range(4):
                column[k, 4 * i + j] = (first_v[k] + j) * columns_u + (first_u[k] + i) % columns_u
                value[k, 4 * i + j] = basis_u[k, i] * basis_v[k, j]
