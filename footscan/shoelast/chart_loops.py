"""Compiled loops over the upper's control net: bending energy as a stencil, and sparse rows of scattered places."""

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import Floats, Ints

REACH = 3
WIDE = 2 * REACH + 1
AROUND = (14, 9)
"""Rows and columns to either side that an average of normals looks at."""


@compiled
def _hessian(s: Floats, basis_u: Floats, basis_v: Floats, h: Floats) -> tuple[float, float, float]:
    """Covariant Hessians `(16, 3)` of the basis functions in an orthonormal frame: 11, sqrt(2) * 12, 22.

    Args:
        s: `(5, 3)` derivatives u, v, uu, uv, vv of the surface.
        basis_u: `(3, 4)` values, first and second derivatives.
        basis_v: Likewise.
        h: Result; control (j, i) of the patch is row 4 * i + j.

    Returns:
        a, b, c: the frame's first axis is along u, where u is (a, 0) and v is (b, c).
    """
    guu = s[0, 0] * s[0, 0] + s[0, 1] * s[0, 1] + s[0, 2] * s[0, 2]
    guv = s[0, 0] * s[1, 0] + s[0, 1] * s[1, 1] + s[0, 2] * s[1, 2]
    gvv = s[1, 0] * s[1, 0] + s[1, 1] * s[1, 1] + s[1, 2] * s[1, 2]
    det = guu * gvv - guv * guv
    a = np.sqrt(guu)
    b, c = guv / a, np.sqrt(det) / a
    gamma = np.empty((3, 2))
    for d in range(3):
        du = s[2 + d, 0] * s[0, 0] + s[2 + d, 1] * s[0, 1] + s[2 + d, 2] * s[0, 2]
        dv = s[2 + d, 0] * s[1, 0] + s[2 + d, 1] * s[1, 1] + s[2 + d, 2] * s[1, 2]
        gamma[d, 0], gamma[d, 1] = (gvv * du - guv * dv) / det, (guu * dv - guv * du) / det
    for i in range(4):
        for j in range(4):
            u0, u1, u2 = basis_u[0, i], basis_u[1, i], basis_u[2, i]
            v0, v1, v2 = basis_v[0, j], basis_v[1, j], basis_v[2, j]
            fu, fv = u1 * v0, u0 * v1
            huu = u2 * v0 - gamma[0, 0] * fu - gamma[0, 1] * fv
            huv = u1 * v1 - gamma[1, 0] * fu - gamma[1, 1] * fv
            hvv = u0 * v2 - gamma[2, 0] * fu - gamma[2, 1] * fv
            h[4 * i + j, 0] = huu / (a * a)
            h[4 * i + j, 1] = 1.4142135623730951 * (huv - b * huu / a) / (a * c)
            h[4 * i + j, 2] = (hvv - 2.0 * b * huv / a + b * b * huu / (a * a)) / (c * c)
    return a, b, c


@compiled
def add_bending(
    first_u: Ints,
    basis_u: Floats,
    first_v: Ints,
    basis_v: Floats,
    tangents: Floats,
    weight: Floats,
    step: Floats,
    fair2: float,
    stencil: Floats,
) -> None:
    """Add the squared covariant Hessian of a scalar field, and that of its change along the surface, span by span.

    Args:
        first_u: `(m,)` first of the four control columns at every u: two places in every span.
        basis_u: `(m, 3, 4)` their values, first and second derivatives.
        first_v: `(k,)` first of the four control rows at every v, likewise.
        basis_v: `(k, 3, 4)` likewise.
        tangents: `(k, m, 5, 3)` derivatives u, v, uu, uv, vv of the surface.
        weight: `(k, m)` parameter area of every place; 0 leaves its span out.
        step: `(1 + k / 2,)` parameter way between the two places of a span, around and then up in every row of spans.
        fair2: Weight (mm2) of the squared change of the Hessian per mm.
        stencil: `(n_v, n_u, 7, 7)` to add to: entry (j, i, dj + 3, di + 3) couples (j, i) with (j + dj, i + di).
    """
    h, parts = np.empty((4, 16, 3)), np.empty((16, 18))
    for row in range(weight.shape[0] // 2):
        for column in range(weight.shape[1] // 2):
            k, m = 2 * row, 2 * column
            if weight[k, m] == 0.0:
                continue
            a = b = c = area = 0.0
            for at in range(4):
                p, q = k + at // 2, m + at % 2
                a1, b1, c1 = _hessian(tangents[p, q], basis_u[q], basis_v[p], h[at])
                a, b, c = a + 0.25 * a1, b + 0.25 * b1, c + 0.25 * c1
                w = weight[p, q] * a1 * c1
                area += w
                for z in range(16):
                    for d in range(3):
                        parts[z, 3 * at + d] = np.sqrt(w) * h[at, z, d]
            share = np.sqrt(fair2 * area)
            for z in range(16):
                for d in range(3):
                    du = 0.5 * (h[1, z, d] + h[3, z, d] - h[0, z, d] - h[2, z, d]) / step[0]
                    dv = 0.5 * (h[2, z, d] + h[3, z, d] - h[0, z, d] - h[1, z, d]) / step[1 + row]
                    parts[z, 12 + d], parts[z, 15 + d] = share * du / a, share * (dv - b / a * du) / c
            _add_products(parts, first_u[m], first_v[k], stencil)


@compiled
def _add_products(parts: Floats, first_u: int, first_v: int, stencil: Floats) -> None:
    columns = stencil.shape[1]
    for p in range(16):
        i, j = (first_u + p // 4) % columns, first_v + p % 4
        for q in range(16):
            total = 0.0
            for d in range(parts.shape[1]):
                total += parts[p, d] * parts[q, d]
            stencil[j, i, q % 4 - p % 4 + REACH, q // 4 - p // 4 + REACH] += total


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


@compiled
def average_normals(xyz: Floats, across: Floats, reach_mm: float, normal: Floats) -> None:
    """Write unit normals `(k, m, 3)`, averaged with weights (1 - (r / reach)^2)^2 of straight distance and area.

    Args:
        xyz: `(k, m, 3)` a grid of places, periodic along m.
        across: `(k, m, 3)` normals there, as long as the area that a place stands for.
        reach_mm: Where the weight ends.
        normal: Result.
    """
    rows, columns = xyz.shape[0], xyz.shape[1]
    for j in range(rows):
        for i in range(columns):
            x = y = z = 0.0
            for dj in range(-min(AROUND[0], j), min(AROUND[0], rows - 1 - j) + 1):
                for di in range(-AROUND[1], AROUND[1] + 1):
                    q, p = j + dj, (i + di) % columns
                    r2 = 0.0
                    for axis in range(3):
                        r2 += (xyz[q, p, axis] - xyz[j, i, axis]) ** 2
                    w = 1.0 - r2 / (reach_mm * reach_mm)
                    if w > 0.0:
                        x, y, z = x + w * w * across[q, p, 0], y + w * w * across[q, p, 1], z + w * w * across[q, p, 2]
            size = max(np.sqrt(x * x + y * y + z * z), 1e-12)
            normal[j, i, 0], normal[j, i, 1], normal[j, i, 2] = x / size, y / size, z / size
