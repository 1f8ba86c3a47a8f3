"""What the camera sees first at every pixel: a depth picture of the mesh, and the ambient light on foot and board."""

import numpy as np

from footscan.compiled import compiled, compiled_inline
from footscan.coordinates import Floats, Floats32, Ints

HIDDEN_MM = 0.6
"""A surface this much nearer to the camera hides what is behind; less is the same surface."""


@compiled
def shade_faces(
    xyz_world: Floats, faces: Ints, tone: Floats, ambient: float, lamp: Floats, closed: bool, shade: Floats32
) -> None:
    """Write the ambient grey value of each face: a third from everywhere, the rest from lamps in one direction.

    Args:
        xyz_world: `(n, 3)` vertices.
        faces: `(m, 3)` vertex indices.
        tone: `(m,)` brightness of each face relative to skin.
        ambient: Grey value of skin that faces the lamps.
        lamp: `(3,)` unit vector towards them.
        closed: Whether the faces bound a body; else both their sides are alike.
        shade: `(m,)` result.
    """
    for i in range(faces.shape[0]):
        a, b, c = xyz_world[faces[i, 0]], xyz_world[faces[i, 1]], xyz_world[faces[i, 2]]
        ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-12)
        towards = (nx * lamp[0] + ny * lamp[1] + nz * lamp[2]) / length
        towards = max(towards, 0.0) if closed else abs(towards)
        shade[i] = tone[i] * ambient * (1.0 + 2.0 * towards) / 3.0


@compiled
def draw_mesh(image: Floats, faces: Ints, shade: Floats32, nearest: Floats32, grey: Floats32) -> None:
    """Draw the faces into the depth picture, the nearest wins.

    Args:
        image: `(n, 3)` u, v, 1 / depth of the vertices.
        faces: `(m, 3)` vertex indices.
        shade: `(m,)` ambient grey value of each face.
        nearest: `(height, width)` 1 / depth (1/mm) of the nearest face at each pixel's centre; 0 is nothing.
        grey: `(height, width)` ambient picture.
    """
    height, width = nearest.shape
    nearest[:] = 0.0
    grey[:] = 0.0
    for i in range(faces.shape[0]):
        a, b, c = faces[i, 0], faces[i, 1], faces[i, 2]
        if min(image[a, 2], image[b, 2], image[c, 2]) <= 0.0:
            continue
        ua, va, ub, vb, uc, vc = image[a, 0], image[a, 1], image[b, 0], image[b, 1], image[c, 0], image[c, 1]
        top, bottom = max(int(np.ceil(min(va, vb, vc))), 0), min(int(np.floor(max(va, vb, vc))), height - 1)
        left, right = max(int(np.ceil(min(ua, ub, uc))), 0), min(int(np.floor(max(ua, ub, uc))), width - 1)
        area = (ub - ua) * (vc - va) - (uc - ua) * (vb - va)
        if top > bottom or left > right or area == 0.0:
            continue
        du_b, dv_b = (vc - va) / area, -(uc - ua) / area
        du_c, dv_c = -(vb - va) / area, (ub - ua) / area
        step_b, step_c = image[b, 2] - image[a, 2], image[c, 2] - image[a, 2]
        for row in range(top, bottom + 1):
            share_b = (left - ua) * du_b + (row - va) * dv_b
            share_c = (left - ua) * du_c + (row - va) * dv_c
            for column in range(left, right + 1):
                if share_b >= 0.0 and share_c >= 0.0 and share_b + share_c <= 1.0:
                    inverse = np.float32(image[a, 2] + share_b * step_b + share_c * step_c)
                    if inverse > nearest[row, column]:
                        nearest[row, column] = inverse
                        grey[row, column] = shade[i]
                share_b += du_b
                share_c += du_c


@compiled
def draw_board(rays: Floats32, board: Floats, ambient: float, nearest: Floats32, grey: Floats32) -> None:
    """Add the ambient light of the round footboard wherever no face is nearer.

    Args:
        rays: `(height, width, 2)` y and z of each pixel's ray in C, for x = 1.
        board: Plane (normal, offset seen from the optical centre), centre seen from the optical centre, radius.
        ambient: Grey value of the board.
        nearest: Depth picture of the mesh.
        grey: Ambient picture, changed.
    """
    nx, ny, nz, offset = board[0], board[1], board[2], board[3]
    cx, cy, cz, radius2 = board[4], board[5], board[6], board[7] * board[7]
    for row in range(rays.shape[0]):
        for column in range(rays.shape[1]):
            y, z = rays[row, column, 0], rays[row, column, 1]
            reach = offset / (nx + ny * y + nz * z)
            dx, dy, dz = reach - cx, reach * y - cy, reach * z - cz
            if nearest[row, column] == 0.0 and reach > 0.0 and dx * dx + dy * dy + dz * dz < radius2:
                grey[row, column] = ambient


@compiled_inline
def is_seen(u: float, v: float, inverse_depth: float, nearest: Floats32) -> bool:
    """Whether nothing lies before a place; right to about a pixel at the edge of what hides it."""
    height, width = nearest.shape
    column, row = int(np.floor(u)), int(np.floor(v))
    if column < -8 or row < -8 or column > width + 8 or row > height + 8:
        return False
    column, row = min(max(column, 0), width - 2), min(max(row, 0), height - 2)
    upper, lower = nearest[row], nearest[row + 1]
    first_met = min(upper[column], upper[column + 1], lower[column], lower[column + 1])
    return first_met * (1.0 - HIDDEN_MM * inverse_depth) <= inverse_depth
