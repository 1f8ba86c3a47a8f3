"""Ridge points of one frame: where the facet's slope across the stripe is zero (Steger 1998, with a secant root).

The loops run on raw bytes. Blocks of 128 pixels without light are skipped at memory speed; of the bright pixels only
those near a maximum along their row or column are looked at in full. The outermost three rows and columns, where the
neighbourhood is cut off, have a pass of their own.
"""

import numpy as np

from footscan.compiled import Real, Truth, Whole, compiled, compiled_inline
from footscan.coordinates import Bytes, Floats32, Frame

# Columns of a ridge point: u, v (px), peak (grey), variance across (px^2), unit normal (u, v), relative slope along
# the stripe (1/px).
RIDGE_COLUMNS = 7

Facet = tuple[Real, Real, Real, Real, Real, Real]
"""Value, slope in u and v, curvature uu, uv, vv."""
Crossing = tuple[Truth, Real, Real, Real, Real, Real, Real, Real]
"""Whether the facet has a ridge near its middle, offset (px), normal u, normal v, variance, slope across, curvature
across, relative slope along."""

# Unsigned offsets: Numba wraps signed indices around like Python, which costs a test at every read.
_U1, _U2, _U3 = np.uint64(1), np.uint64(2), np.uint64(3)
_BLOCK_PX = 128
_OUTSIDE_PIXEL = 0.55  # px along the row or column, whichever crosses the ridge: further away it is a neighbour's
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
        points: `(capacity, 7)` result: u, v, peak (grey), variance (px^2), normal (u, v), relative slope along
            the stripe (1/px). What does not fit is not written.
    """
    height, width = frame.shape
    flat = frame.ravel()
    size = np.uint64(flat.shape[0])
    block = np.uint64(_BLOCK_PX)
    begin = np.uint64(0)
    stride = np.uint64(width)
    margin = np.uint64(_RING_PX) * stride
    count = 0
    if height <= 2 * _RING_PX or width <= 2 * _RING_PX:
        return 0
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
            for k in range(max(begin, margin), min(end, size - margin)):
                if flat[k] > threshold and _near_crest(flat, k, stride):
                    row = np.int64(k) // width
                    column = np.int64(k) - row * width
                    inside = _RING_PX <= column < width - _RING_PX and _RING_PX <= row < height - _RING_PX
                    if inside and count < points.shape[0]:
                        count += _ridge_point(flat, stride, row, column, height, lines, limits, points[count])
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
    ring = min(_RING_PX, (width + 1) // 2)
    for row in range(height):
        end = width if row < _RING_PX or row >= height - _RING_PX else ring
        for column in range(end):
            if frame[row, column] > threshold and count < points.shape[0]:
                count += _border_point(frame, row, column, cut, limits, points[count])
        for column in range(max(end, width - ring), width):
            if frame[row, column] > threshold and count < points.shape[0]:
                count += _border_point(frame, row, column, cut, limits, points[count])
    return count


@compiled
def _border_point(frame: Bytes, row: int, column: int, cut: Floats32, limits: Floats32, point: Floats32) -> int:
    facet = _cut_facet(frame, row, column, cut)
    found, offset, nu, nv, variance, _, _, along = _crossing(facet, limits)
    if not found or abs(offset) > _OUTSIDE_PIXEL * max(abs(nu), abs(nv)):
        return 0
    _write(point, row, column, offset, facet[0], variance, nu, nv, along)
    return 1


@compiled_inline
def _near_crest(flat: Bytes, at: Whole, stride: Whole) -> Truth:
    """Whether a parabola through sums of three pixels, along the axis where they bend most, peaks about here."""
    up, down = at - stride, at + stride
    nw, n, ne = np.int32(flat[up - _U1]), np.int32(flat[up]), np.int32(flat[up + _U1])
    w, c, e = np.int32(flat[at - _U1]), np.int32(flat[at]), np.int32(flat[at + _U1])
    sw, s, se = np.int32(flat[down - _U1]), np.int32(flat[down]), np.int32(flat[down + _U1])
    left, centre, right = nw + w + sw, n + c + s, ne + e + se
    above, level, below = nw + n + ne, w + c + e, sw + s + se
    bend_u, bend_v = 2 * centre - left - right, 2 * level - above - below
    if bend_u >= bend_v:
        return 10 * abs(right - left) <= 12 * bend_u + (centre >> 2)
    return 10 * abs(below - above) <= 12 * bend_v + (level >> 2)


@compiled_inline
def _whole_facet(flat: Bytes, at: Whole, stride: Whole, k: Floats32) -> Facet:
    a0, a1, a2, a3 = k[0, 3], k[0, 4], k[0, 5], k[0, 6]
    b1, b2, b3 = k[1, 4], k[1, 5], k[1, 6]
    c0, c1, c2, c3 = k[2, 3], k[2, 4], k[2, 5], k[2, 6]
    p0 = np.float32(flat[at])
    p1, m1 = np.float32(flat[at + _U1]), np.float32(flat[at - _U1])
    p2, m2 = np.float32(flat[at + _U2]), np.float32(flat[at - _U2])
    p3, m3 = np.float32(flat[at + _U3]), np.float32(flat[at - _U3])
    value = a0 * p0 + a1 * (p1 + m1) + a2 * (p2 + m2) + a3 * (p3 + m3)
    g = k[0, 3] * value
    gu = k[0, 3] * (b1 * (p1 - m1) + b2 * (p2 - m2) + b3 * (p3 - m3))
    guu = k[0, 3] * (c0 * p0 + c1 * (p1 + m1) + c2 * (p2 + m2) + c3 * (p3 + m3))
    gvv = k[2, 3] * value
    gv = guv = np.float32(0.0)
    up, down = at, at
    for j in range(1, 4):  # rows above and below together: their sum carries the even terms, their difference the odd
        up, down = up - stride, down + stride
        s0, d0 = _both(flat[down], flat[up])
        sp1, dp1 = _both(flat[down + _U1], flat[up + _U1])
        sm1, dm1 = _both(flat[down - _U1], flat[up - _U1])
        sp2, dp2 = _both(flat[down + _U2], flat[up + _U2])
        sm2, dm2 = _both(flat[down - _U2], flat[up - _U2])
        sp3, dp3 = _both(flat[down + _U3], flat[up + _U3])
        sm3, dm3 = _both(flat[down - _U3], flat[up - _U3])
        value = a0 * s0 + a1 * (sp1 + sm1) + a2 * (sp2 + sm2) + a3 * (sp3 + sm3)
        g += k[0, 3 + j] * value
        gvv += k[2, 3 + j] * value
        gu += k[0, 3 + j] * (b1 * (sp1 - sm1) + b2 * (sp2 - sm2) + b3 * (sp3 - sm3))
        guu += k[0, 3 + j] * (c0 * s0 + c1 * (sp1 + sm1) + c2 * (sp2 + sm2) + c3 * (sp3 + sm3))
        gv += k[1, 3 + j] * (a0 * d0 + a1 * (dp1 + dm1) + a2 * (dp2 + dm2) + a3 * (dp3 + dm3))
        guv += k[1, 3 + j] * (b1 * (dp1 - dm1) + b2 * (dp2 - dm2) + b3 * (dp3 - dm3))
    return g, gu, gv, guu, guv, gvv


@compiled_inline
def _both(below: Whole, above: Whole) -> tuple[Real, Real]:
    x, y = np.float32(below), np.float32(above)
    return x + y, x - y


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
    near = abs(offset) <= _WORTH_A_LOOK * max(abs(nu), abs(nv))
    return near, offset, nu, nv, variance, slope, across, slope_along


@compiled_inline
def _write(
    point: Floats32,
    row: Whole,
    column: Whole,
    offset: Real,
    peak: Real,
    variance: Real,
    nu: Real,
    nv: Real,
    along: Real,
) -> None:
    point[0], point[1] = column + offset * nu, row + offset * nv
    point[2], point[3], point[4], point[5], point[6] = peak, variance, nu, nv, along


@compiled_inline
def _ridge_point(
    flat: Bytes,
    stride: Whole,
    row: Whole,
    column: Whole,
    height: int,
    lines: Floats32,
    limits: Floats32,
    point: Floats32,
) -> int:
    """Fit the facet at a pixel, find the ridge in it, and write the point; 1 when there is one, else 0."""
    at = np.uint64(row) * stride + np.uint64(column)
    facet = _whole_facet(flat, at, stride, lines)
    found, offset, nu, nv, variance, slope, across, along = _crossing(facet, limits)
    if not found:
        return 0
    step_u, step_v = (1, 0) if abs(nu) >= abs(nv) else (0, 1)
    if (step_u * nu + step_v * nv) * offset < 0.0:
        step_u, step_v = -step_u, -step_v
    row_there, column_there = row + step_v, column + step_u
    width = np.int64(stride)
    if _RING_PX <= column_there < width - _RING_PX and _RING_PX <= row_there < height - _RING_PX:
        there = np.uint64(row_there) * stride + np.uint64(column_there)
        slope_there = _slope_across(flat, there, stride, lines, nu, nv)
        offset = _root_across(slope, across, slope_there, step_u * nu + step_v * nv, offset)
    if abs(offset) > _OUTSIDE_PIXEL * max(abs(nu), abs(nv)):
        return 0
    _write(point, row, column, offset, facet[0], variance, nu, nv, along)
    return 1


@compiled_inline
def _root_across(slope: Real, curvature: Real, slope_there: Real, distance: Real, first_guess: Real) -> Real:
    """Offset along the normal where the slope is zero: a parabola through slope and curvature here and the slope at the
    neighbour on the ridge's side, exact to third order whatever the profile (a saturated one is far from Gaussian)."""
    bend = (slope_there - slope - curvature * distance) / (distance * distance)
    inside = curvature * curvature - np.float32(4.0) * slope * bend
    if inside <= 0.0:
        return first_guess
    return np.float32(-2.0) * slope / (curvature - np.sqrt(inside))


@compiled_inline
def _slope_across(flat: Bytes, at: Whole, stride: Whole, k: Floats32, nu: Real, nv: Real) -> Real:
    """Slope along (nu, nv) of the facet at a pixel."""
    a0, a1, a2, a3 = k[0, 3], k[0, 4], k[0, 5], k[0, 6]
    b1, b2, b3 = k[1, 4], k[1, 5], k[1, 6]
    gu = gv = np.float32(0.0)
    line = at - _U3 * stride
    for j in range(7):
        p1, m1 = np.float32(flat[line + _U1]), np.float32(flat[line - _U1])
        p2, m2 = np.float32(flat[line + _U2]), np.float32(flat[line - _U2])
        p3, m3 = np.float32(flat[line + _U3]), np.float32(flat[line - _U3])
        gv += k[1, j] * (a0 * np.float32(flat[line]) + a1 * (p1 + m1) + a2 * (p2 + m2) + a3 * (p3 + m3))
        gu += k[0, j] * (b1 * (p1 - m1) + b2 * (p2 - m2) + b3 * (p3 - m3))
        line += stride
    return gu * nu + gv * nv
