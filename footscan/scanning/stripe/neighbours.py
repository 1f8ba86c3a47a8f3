"""What the neighbours along the stripe say of a ridge point: is it part of a stripe, is it an end, where is the stripe.

A quadratic through the neighbours within a few pixels averages their noise without rounding off a curve, and never
reaches over a gap or a step, because only points that continue the same direction are neighbours. Its bend also says
how far the facet, which averages along the stripe, moved the ridge into the curve: at the tip of a toe by 0.1 px.
"""

import numpy as np

from footscan.compiled import compiled, compiled_inline
from footscan.coordinates import Floats32, Ints

Moments = tuple[float, float, float, float]

REACH_PX = 7
_FEW = 64
_FADING = 0.03  # 1/px: relative slope of the brightness along the stripe that marks an end
_SLIP_PX = 1.0  # a neighbour this far across the stripe is another stripe
_BOTH_SIDES_PX = 1.5
_PARALLEL_PX = 4.0
_SAME_DIRECTION = 0.7  # cosine


@compiled
def row_starts(points: Floats32, count: int, height: int) -> Ints:
    """Index of the first point of each row of pixels, `(height + 1,)`; points are in row order within half a pixel."""
    starts = np.zeros(height + 1, dtype=np.int64)
    for i in range(count):
        starts[_pixel(points[i, 1], height) + 1] += 1
    for row in range(height):
        starts[row + 1] += starts[row]
    return starts


@compiled_inline
def _pixel(place: float, size: int) -> int:
    return min(max(int(np.floor(place + 0.5)), 0), size - 1)


@compiled
def sort_by_pixel(points: Floats32, count: int, starts: Ints, ordered: Floats32) -> None:
    """Copy the points into row order, columns ascending within a row (an insertion sort of nearly sorted rows)."""
    height = starts.shape[0] - 1
    filled = starts[:height].copy()
    for i in range(count):
        row = _pixel(points[i, 1], height)
        k = filled[row]
        filled[row] += 1
        while k > starts[row] and ordered[k - 1, 0] > points[i, 0]:
            ordered[k] = ordered[k - 1]
            k -= 1
        ordered[k] = points[i]


@compiled_inline
def _first_from(points: Floats32, begin: int, end: int, u: float) -> int:
    """First index in begin..end whose u is at least `u`."""
    while end - begin > 4:
        middle = (begin + end) // 2
        if points[middle, 0] < u:
            begin = middle + 1
        else:
            end = middle
    while begin < end and points[begin, 0] < u:
        begin += 1
    return begin


@compiled
def judge_points(
    points: Floats32,
    count: int,
    starts: Ints,
    width: int,
    fewest: int,
    end_px: float,
    facet_px2: float,
    verdict: Floats32,
) -> None:
    """For every point write (keep 0/1, shift across, residual RMS) from its neighbours along the stripe.

    Args:
        points: `(>= count, 7)` in the order of `sort_by_pixel`.
        count: Number of points.
        starts: `row_starts`.
        width: Columns of the frame.
        fewest: Smallest number of points (itself included) within reach for a stripe.
        end_px: A point whose brightness changes along the stripe needs a neighbour this far on both sides.
        facet_px2: Variance of the facet's weights along the stripe.
        verdict: `(>= count, 3)` result; the shift is px along the point's normal to the fitted quadratic.
    """
    height = starts.shape[0] - 1
    for i in range(count):
        u, v, nu, nv = points[i, 0], points[i, 1], points[i, 4], points[i, 5]
        row = _pixel(v, height)
        first, last = max(row - REACH_PX, 0), min(row + REACH_PX, height - 1)
        few = starts[last + 1] - starts[first] <= _FEW  # then one run over all rows is faster than a search in each
        s1 = s2 = s3 = s4 = y0 = y1 = y2 = yy = 0.0
        lowest, highest = 0.0, 0.0
        members, rival = 0, False
        for other_row in range(last if few else first, last + 1):
            end = starts[other_row + 1]
            j = starts[first] if few else _first_from(points, starts[other_row], end, u - REACH_PX - 0.5)
            while j < end and (few or points[j, 0] <= u + REACH_PX + 0.5):
                du, dv = points[j, 0] - u, points[j, 1] - v
                d, t = du * nu + dv * nv, dv * nu - du * nv
                slip = abs(d)
                if slip < _SLIP_PX + 0.25 * abs(t):
                    if abs(points[j, 4] * nu + points[j, 5] * nv) > _SAME_DIRECTION and abs(t) < REACH_PX + 0.5:
                        members += 1
                        lowest, highest = min(lowest, t), max(highest, t)
                        t2 = t * t
                        s1, s2, s3, s4 = s1 + t, s2 + t2, s3 + t2 * t, s4 + t2 * t2
                        y0, y1, y2, yy = y0 + d, y1 + d * t, y2 + d * t2, yy + d * d
                elif slip < _PARALLEL_PX and abs(t) < 1.5 and points[j, 2] > 1.25 * points[i, 2]:
                    rival = True
                j += 1
        inner = 4.0 < u < width - 5.0 and 4.0 < v < height - 5.0
        is_end = inner and (lowest > -end_px or highest < end_px) and abs(points[i, 6]) > _FADING
        verdict[i, 0] = 0.0 if members < fewest or rival or is_end else 1.0
        both_sides = lowest < -_BOTH_SIDES_PX and highest > _BOTH_SIDES_PX
        # points of the outermost rows and columns are not exact enough to tell a bend
        clear = REACH_PX + 3.0 < u < width - REACH_PX - 4.0 and REACH_PX + 3.0 < v < height - REACH_PX - 4.0
        into_bend = facet_px2 if clear else 0.0
        verdict[i, 1], verdict[i, 2] = _place_at_zero(
            (s1, s2, s3, s4), (y0, y1, y2, yy), members, both_sides, into_bend
        )


@compiled_inline
def _place_at_zero(
    powers: Moments, mixed: Moments, members: int, both_sides: bool, facet_px2: float
) -> tuple[float, float]:
    """Value at 0 of the least-squares quadratic, freed from the facet's shift into the curve, and residual RMS.

    Where the stripe ends and only one side is known a quadratic would amplify noise: a line is taken there.

    Args:
        powers: Sums of t, t2, t3, t4 over the neighbours (t along the stripe).
        mixed: Sums of d, d t, d t2, d2 (d across it).
        members: Number of neighbours.
        both_sides: Whether they lie on both sides.
        facet_px2: Variance of the facet's weights along the stripe.
    """
    n = float(members)
    s1, s2, s3, s4 = powers
    y0, y1, y2, yy = mixed
    c00, c01, c02 = s2 * s4 - s3 * s3, s2 * s3 - s1 * s4, s1 * s3 - s2 * s2
    determinant = n * c00 + s1 * c01 + s2 * c02
    if both_sides and members >= 5 and determinant > 1e-3 * n * s2 * s4:
        c11, c12, c22 = n * s4 - s2 * s2, s1 * s2 - n * s3, n * s2 - s1 * s1
        a = (c00 * y0 + c01 * y1 + c02 * y2) / determinant
        b = (c01 * y0 + c11 * y1 + c12 * y2) / determinant
        c = (c02 * y0 + c12 * y1 + c22 * y2) / determinant
        return a - facet_px2 * c, np.sqrt(max(yy - a * y0 - b * y1 - c * y2, 0.0) / n)
    determinant = n * s2 - s1 * s1
    if members >= 3 and determinant > 1e-3 * n * s2:
        a, b = (s2 * y0 - s1 * y1) / determinant, (n * y1 - s1 * y0) / determinant
        return a, np.sqrt(max(yy - a * y0 - b * y1, 0.0) / n)
    return 0.0, np.sqrt(yy / max(n, 1.0))
