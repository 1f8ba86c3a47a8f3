"""Ridge points of one frame: where the facet's slope across the stripe is zero (Steger 1998, with a secant root).

The loops run on raw bytes. Blocks of 128 pixels without light are skipped at memory speed; of the bright pixels only
those near a maximum along their row or column are looked at in full. The outermost three rows and columns, where the
neighbourhood is cut off, have a pass of their own.
"""

import numpy as np

from footscan.compiled import compiled, compiled_inline
from footscan.coordinates import Bytes, Floats32, Frame

# Columns of a ridge point: u, v (px), peak (grey), variance across (px^2), unit normal (u, v), relative slope along (1/px).
RIDGE_COLUMNS = 7

Facet = tuple[float, float, float, float, float, float]
"""Value, slope in u and v, curvature uu, uv, vv."""
Crossing = tuple[bool, float, float, float, float, float, float, float]
"""Whether the facet has a ridge near its middle, offset (px), normal u, normal v, variance, slope across, curvature
across, relative slope along."""

_BLOCK_PX = 128
_OUTSIDE_PIXEL = 0.55  # px: a ridge further from the pixel's centre belongs to a neighbour
_WORTH_A_LOOK = 0.8  # px: the same for the first guess
_RING_PX = 3


@compiled
def find_ridge_points(frame: Frame, threshold: int, lines: Floats32, limits: Floats32, points: Floats32) -> int:
    """Write the ridge points of a frame, its outermost three rows and columns excepted, and return how many there are.

    Args:
        frame: `(height, width)` uint8, C order.
        threshold: A pixel counts when it is above it.
        lines: `line_kernels`.
        limits: smallest and largest variance (px^2) of the smoothed stripe, largest |slope along| / peak,
            largest |curvature along / curvature across|.
        points: `(capacity, 7)` result: u, v, peak (grey), variance (px^2), normal (u, v), relative slope along the stripe
            (1/px). What does not fit is not written.
    """
    height, width = frame.shape
    flat = frame.ravel()
    size = np.uint64(flat.shape[0])
    block = np.uint64(_BLOCK_PX)
    begin = np.uint64(0)
    count = 0
    while begin < size:
        end = begin + block
        brightest = np.uint8(255)
        if end <= size:
            brightest = np.uint8(0)
            for k in range(block):
                brightest = max(brightest, flat[begin + k])
        else:
            end = size
        if brightest > threshold:
            for k in range(begin, end):
                if flat[k] > threshold:
                    row = np.int64(k) // width
                    column = np.int64(k) - row * width
                    inside = _RING_PX <= column < width - _RING_PX and _RING_PX <= row < height - _RING_PX
                    if inside and count < points.shape[0] and _near_crest(frame, row, column):
                        count += _ridge_point(frame, row, column, lines, limits, points[count])
        begin = end
    return count


@compiled
def add_border_points(
    frame: Frame, threshold: int, cut: Floats32, limits: Floats32, points: Floats32, count: int
) -> int:
    """Append the ridge points of the outermost three rows and columns; returns the new number of points.

    Args are those of `find_ridge_points`, with `cut` the `border_kernels`.
    """
    height, width = frame.shape
    for row in range(height):
        whole_row = row < _RING_PX or row >= height - _RING_PX
        for column in range(width if whole_row else 2 * _RING_PX):
            if not whole_row and column >= _RING_PX:
                column += width - 2 * _RING_PX
            if frame[row, column] > threshold and count < points.shape[0]:
                facet = _cut_facet(frame, row, column, cut)
                found, offset, nu, nv, variance, _, _, along = _crossing(facet, limits)
                if found and abs(offset * nu) <= _OUTSIDE_PIXEL and abs(offset * nv) <= _OUTSIDE_PIXEL:
                    _write(points[count], row, column, offset, facet[0], variance, nu, nv, along)
                    count += 1
    return count


@compiled_inline
def _near_crest(frame: Bytes, row: int, column: int) -> bool:
    """Whether the sums of three pixels do not clearly rise to a side, along the axis where they bend most."""
    top, middle, bottom = frame[row - 1], frame[row], frame[row + 1]
    left = np.int32(top[column - 1]) + middle[column - 1] + bottom[column - 1]
    centre = np.int32(top[column]) + middle[column] + bottom[column]
    right = np.int32(top[column + 1]) + middle[column + 1] + bottom[column + 1]
    above = np.int32(top[column - 1]) + top[column] + top[column + 1]
    level = np.int32(middle[column - 1]) + middle[column] + middle[column + 1]
    below = np.int32(bottom[column - 1]) + bottom[column] + bottom[column + 1]
    bend_u, bend_v = 2 * centre - left - right, 2 * level - above - below
    if bend_u >= bend_v:
        return bend_u >= 0 and centre + (centre >> 4) >= max(left, right)
    return bend_v >= 0 and level + (level >> 4) >= max(above, below)


@compiled_inline
def _whole_facet(frame: Bytes, row: int, column: int, k: Floats32) -> Facet:
    a0, a1, a2, a3 = k[0, 3], k[0, 4], k[0, 5], k[0, 6]
    b1, b2, b3 = k[1, 4], k[1, 5], k[1, 6]
    c0, c1, c2, c3 = k[2, 3], k[2, 4], k[2, 5], k[2, 6]
    g = gu = gv = guu = guv = gvv = np.float32(0.0)
    for j in range(7):
        line = frame[row - 3 + j]
        middle = np.float32(line[column])
        p1, m1 = np.float32(line[column + 1]), np.float32(line[column - 1])
        p2, m2 = np.float32(line[column + 2]), np.float32(line[column - 2])
        p3, m3 = np.float32(line[column + 3]), np.float32(line[column - 3])
        value = a0 * middle + a1 * (p1 + m1) + a2 * (p2 + m2) + a3 * (p3 + m3)
        slope = b1 * (p1 - m1) + b2 * (p2 - m2) + b3 * (p3 - m3)
        curve = c0 * middle + c1 * (p1 + m1) + c2 * (p2 + m2) + c3 * (p3 + m3)
        g += k[0, j] * value
        gu += k[0, j] * slope
        guu += k[0, j] * curve
        gv += k[1, j] * value
        guv += k[1, j] * slope
        gvv += k[2, j] * value
    return g, gu, gv, guu, guv, gvv


@compiled_inline
def _cut_facet(frame: Bytes, row: int, column: int, cut: Floats32) -> Facet:
    height, width = frame.shape
    missing_u = max(3 - column, 0) - max(column - (width - 4), 0)
    missing_v = max(3 - row, 0) - max(row - (height - 4), 0)
    kernel = cut[missing_u + 3, missing_v + 3]
    g = gu = gv = guu = guv = gvv = np.float32(0.0)
    for j in range(max(3 - row, 0), min(height - row + 3, 7)):
        for i in range(max(3 - column, 0), min(width - column + 3, 7)):
            grey = np.float32(frame[row - 3 + j, column - 3 + i])
            g += kernel[0, j, i] * grey
            gu += kernel[1, j, i] * grey
            gv += kernel[2, j, i] * grey
            guu += kernel[3, j, i] * grey
            guv += kernel[4, j, i] * grey
            gvv += kernel[5, j, i] * grey
    return g, gu, gv, guu, guv, gvv


@compiled_inline
def _crossing(facet: Facet, limits: Floats32) -> Crossing:
    """The ridge in a facet; the offset is exact where the smoothed stripe is Gaussian."""
    g, gu, gv, guu, guv, gvv = facet
    half, mean = np.float32(0.5) * (guu - gvv), np.float32(0.5) * (guu + gvv)
    root = np.sqrt(half * half + guv * guv)
    across, along = mean - root, mean + root
    nothing = (False, np.float32(0.0), half, half, half, half, half, half)
    if across >= 0.0 or abs(along) > -limits[3] * across or g <= 0.0:
        return nothing
    nu, nv = (root - half, -guv) if half < 0.0 else (-guv, root + half)
    length = np.sqrt(nu * nu + nv * nv)
    if length == 0.0:
        return nothing
    nu, nv = nu / length, nv / length
    slope, slope_along = gu * nu + gv * nv, (gv * nu - gu * nv) / g
    variance = g * g / (slope * slope - g * across)
    if variance < limits[0] or variance > limits[1] or abs(slope_along) > limits[2]:
        return nothing
    offset = slope * variance / g
    near = abs(offset * nu) <= _WORTH_A_LOOK and abs(offset * nv) <= _WORTH_A_LOOK
    return near, offset, nu, nv, variance, slope, across, slope_along


@compiled_inline
def _write(
    point: Floats32,
    row: int,
    column: int,
    offset: float,
    peak: float,
    variance: float,
    nu: float,
    nv: float,
    along: float,
) -> None:
    point[0], point[1] = column + offset * nu, row + offset * nv
    point[2], point[3], point[4], point[5], point[6] = peak, variance, nu, nv, along


@compiled_inline
def _ridge_point(frame: Bytes, row: int, column: int, lines: Floats32, limits: Floats32, point: Floats32) -> int:
    """Fit the facet at a pixel, find the ridge in it, and write the point; 1 when there is one, else 0."""
    facet = _whole_facet(frame, row, column, lines)
    found, offset, nu, nv, variance, slope, across, along = _crossing(facet, limits)
    if not found:
        return 0
    offset = _root_across(frame, row, column, lines, nu, nv, slope, across, offset)
    if abs(offset * nu) > _OUTSIDE_PIXEL or abs(offset * nv) > _OUTSIDE_PIXEL:
        return 0
    _write(point, row, column, offset, facet[0], variance, nu, nv, along)
    return 1


@compiled_inline
def _root_across(
    frame: Bytes,
    row: int,
    column: int,
    k: Floats32,
    nu: float,
    nv: float,
    slope: float,
    curvature: float,
    first_guess: float,
) -> float:
    """Offset along the normal where the slope is zero: a parabola through slope and curvature here and the slope at the
    neighbour on the ridge's side, exact to third order whatever the profile (a saturated one is far from Gaussian)."""
    step_u, step_v = (1, 0) if abs(nu) >= abs(nv) else (0, 1)
    distance = step_u * nu + step_v * nv
    if distance * first_guess < 0.0:
        step_u, step_v, distance = -step_u, -step_v, -distance
    row, column = row + step_v, column + step_u
    height, width = frame.shape
    if not (_RING_PX <= column < width - _RING_PX and _RING_PX <= row < height - _RING_PX):
        return first_guess
    there = _slope_across(frame, row, column, k, nu, nv)
    bend = (there - slope - curvature * distance) / (distance * distance)
    inside = curvature * curvature - np.float32(4.0) * slope * bend
    if inside <= 0.0:
        return first_guess
    return np.float32(-2.0) * slope / (curvature - np.sqrt(inside))


@compiled_inline
def _slope_across(frame: Bytes, row: int, column: int, k: Floats32, nu: float, nv: float) -> float:
    """Slope along (nu, nv) of the facet at a pixel."""
    a0, a1, a2, a3 = k[0, 3], k[0, 4], k[0, 5], k[0, 6]
    b1, b2, b3 = k[1, 4], k[1, 5], k[1, 6]
    gu = gv = np.float32(0.0)
    for j in range(7):
        line = frame[row - 3 + j]
        p1, m1 = np.float32(line[column + 1]), np.float32(line[column - 1])
        p2, m2 = np.float32(line[column + 2]), np.float32(line[column - 2])
        p3, m3 = np.float32(line[column + 3]), np.float32(line[column - 3])
        gv += k[1, j] * (a0 * np.float32(line[column]) + a1 * (p1 + m1) + a2 * (p2 + m2) + a3 * (p3 + m3))
        gu += k[0, j] * (b1 * (p1 - m1) + b2 * (p2 - m2) + b3 * (p3 - m3))
    return gu * nu + gv * nv
