"""The ambient picture of a printed board: a pixel looks along many rays at once, then the lens blurs.

A pixel whose middle and corners show the same needs no more rays.
"""

import cv2
import numpy as np

from footscan.compiled import compiled, compiled_inline
from footscan.coordinates import Floats, Floats32, Ints
from footscan.sim.board_print import (
    BACK_GREY,
    BLACK_GREY,
    BOW_MM,
    HEIGHT_MM,
    MARGIN_MM,
    WHITE_GREY,
    WIDTH_MM,
    Print,
    is_white,
    slope_of_board,
)

RAYS_PER_SIDE = 6
"""Rays in a pixel, each way; an edge is placed to 1/6 of a pixel in one pixel and far better over several."""
_PIXEL_VARIANCE = 1.0 / 12.0


def draw_print(rays: Floats32, image: Floats, eye: Floats, printed: Print, blur_px: float, grey: Floats32) -> None:
    """Draw the board over the ambient picture of what lies behind it.

    Args:
        rays: `(height, width, 2)` y and z of each pixel's ray in C, for x = 1.
        image: `(n, 3)` u, v, 1 / depth of the board's vertices.
        eye: `(3,)` optical centre in the board system.
        printed: The board; its matrix turns directions in C into the board system.
        blur_px: Sigma of the blur of lens and pixel together.
        grey: `(height, width)` ambient picture, changed.
    """
    height, width = grey.shape
    if not (image[:, 2] > 0.0).all():
        return  # the machine's camera stands outside any board; a board about the lens is no picture
    reach = int(np.ceil(4.0 * blur_px)) + 1
    low = np.maximum(np.floor(image[:, :2].min(axis=0)) - reach, 0).astype(int)
    high = np.minimum(np.ceil(image[:, :2].max(axis=0)) + reach + 1, [width, height]).astype(int)
    if (low >= high).any():
        return
    window = np.array([low[1], high[1], low[0], high[0]])
    _draw_window(rays, window, eye, printed, grey)
    part = grey[low[1] : high[1], low[0] : high[0]]
    sigma = float(np.sqrt(max(blur_px**2 - _PIXEL_VARIANCE, 0.0)))
    if sigma > 0.0:
        part[:] = cv2.GaussianBlur(part, (2 * reach + 1, 2 * reach + 1), sigma, borderType=cv2.BORDER_REPLICATE)


@compiled
def _draw_window(rays: Floats32, window: Ints, eye: Floats, printed: Print, grey: Floats32) -> None:
    last_row, last_column = rays.shape[0] - 1, rays.shape[1] - 1
    for row in range(window[0], window[1]):
        up, down = max(row - 1, 0), min(row + 1, last_row)
        for column in range(window[2], window[3]):
            left, right = max(column - 1, 0), min(column + 1, last_column)
            y, z = rays[row, column, 0], rays[row, column, 1]
            y_u = (rays[row, right, 0] - rays[row, left, 0]) / (right - left)
            z_u = (rays[row, right, 1] - rays[row, left, 1]) / (right - left)
            y_v = (rays[down, column, 0] - rays[up, column, 0]) / (down - up)
            z_v = (rays[down, column, 1] - rays[up, column, 1]) / (down - up)
            behind = grey[row, column]
            here = _grey_of_ray(eye, y, z, printed, behind)
            even = True
            for k in range(4):
                du, dv = k % 2 - 0.5, k // 2 - 0.5
                even &= here == _grey_of_ray(eye, y + du * y_u + dv * y_v, z + du * z_u + dv * z_v, printed, behind)
            if even:
                grey[row, column] = here
                continue
            total = 0.0
            for k in range(RAYS_PER_SIDE * RAYS_PER_SIDE):
                du = (k % RAYS_PER_SIDE + 0.5) / RAYS_PER_SIDE - 0.5
                dv = (k // RAYS_PER_SIDE + 0.5) / RAYS_PER_SIDE - 0.5
                total += _grey_of_ray(eye, y + du * y_u + dv * y_v, z + du * z_u + dv * z_v, printed, behind)
            grey[row, column] = total / (RAYS_PER_SIDE * RAYS_PER_SIDE)


@compiled
def _grey_of_ray(eye: Floats, ray_y: float, ray_z: float, printed: Print, behind: float) -> float:
    """Ambient grey value that the ray (1, y, z) of C meets; `behind` where it misses the board."""
    m = printed[0]
    dx = m[0, 0] + m[0, 1] * ray_y + m[0, 2] * ray_z
    dy = m[1, 0] + m[1, 1] * ray_y + m[1, 2] * ray_z
    dz = m[2, 0] + m[2, 1] * ray_y + m[2, 2] * ray_z
    seen = _grey_along(eye, dx, dy, dz, printed)
    return behind if seen < 0.0 else seen


@compiled_inline
def _grey_along(eye: Floats, dx: float, dy: float, dz: float, printed: Print) -> float:
    """Ambient grey value that a ray meets, -1 where it misses the board."""
    _, numbers, squares, markers = printed
    half, middle = 0.5 * numbers[WIDTH_MM] + numbers[MARGIN_MM], 0.5 * numbers[WIDTH_MM]
    bend = numbers[BOW_MM] / (half * half)
    # bend * (x - middle)^2 - bow - z = 0 along the ray
    a = bend * dx * dx
    b = 2.0 * bend * (eye[0] - middle) * dx - dz
    c = bend * (eye[0] - middle) ** 2 - numbers[BOW_MM] - eye[2]
    nearest, result = 1e30, -1.0
    for which in range(2):
        reach = _root(a, b, c, which)
        if not 0.0 < reach < nearest:
            continue
        x, y = eye[0] + reach * dx, eye[1] + reach * dy
        if abs(x - middle) > half or abs(y - 0.5 * numbers[HEIGHT_MM]) > 0.5 * numbers[HEIGHT_MM] + numbers[MARGIN_MM]:
            continue
        nearest = reach
        if dz - slope_of_board(x, numbers) * dx <= 0.0:
            result = numbers[BACK_GREY]
        elif is_white(x, y, numbers, squares, markers):
            result = numbers[WHITE_GREY]
        else:
            result = numbers[BLACK_GREY]
    return result


@compiled_inline
def _root(a: float, b: float, c: float, which: int) -> float:
    """One of the two roots of a x^2 + b x + c, without cancellation; -1 where there is none."""
    under = b * b - 4.0 * a * c
    if under < 0.0:
        return -1.0
    q = -0.5 * (b + (np.sqrt(under) if b >= 0.0 else -np.sqrt(under)))
    if which == 0:
        return c / q if q != 0.0 else -1.0
    return q / a if a != 0.0 else -1.0
