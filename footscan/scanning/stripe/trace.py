"""The whole way from a frame's bytes to stripe points in one compiled call, with buffers that are allocated once."""

import numpy as np

from footscan.compiled import Real, compiled, compiled_inline
from footscan.coordinates import Floats, Floats32, Frame
from footscan.scanning.stripe.neighbours import judge_points, row_starts, sort_by_pixel
from footscan.scanning.stripe.ridge import add_border_points, find_ridge_points

# Columns of a traced point: u, v (px), weight (0..1), peak (grey), standard deviation across (px).
TRACE_COLUMNS = 5
_FULL_PEAK = 160.0  # grey: a peak from which brightness no longer limits the accuracy
_SHARP_PX = 2.0


@compiled
def trace_stripe(
    frame: Frame,
    threshold: int,
    lines: Floats32,
    cut: Floats32,
    limits: Floats32,
    rules: Floats32,
    points: Floats32,
    ordered: Floats32,
    verdict: Floats32,
    traced: Floats,
) -> tuple[int, bool]:
    """Write the stripe points of a frame in row order; returns their number, and whether a buffer was too small.

    Args:
        frame: `(height, width)` uint8, C order.
        threshold: A pixel counts when it is above it.
        lines: `facet.line_kernels`.
        cut: `facet.border_kernels`.
        limits: See `ridge.find_ridge_points`.
        rules: fewest neighbours, end (px), roughest (px), variance of the facet (px^2).
        points: Buffer `(capacity, 7)`.
        ordered: Buffer of the same shape.
        verdict: Buffer `(capacity, 3)`.
        traced: `(capacity, 5)` result: u, v, weight, peak, standard deviation across.
    """
    height, width = frame.shape
    count = find_ridge_points(frame, threshold, lines, limits, points)
    count = add_border_points(frame, threshold, cut, limits, points, count)
    starts = row_starts(points, count, height)
    sort_by_pixel(points, count, starts, ordered)
    judge_points(ordered, count, starts, width, int(rules[0]), rules[1], rules[3], verdict)
    kept = 0
    for i in range(count):
        if verdict[i, 0] > 0.0 and verdict[i, 2] < rules[2]:
            sigma_px = np.sqrt(max(ordered[i, 3] - rules[3], 1e-6))
            traced[kept, 0] = ordered[i, 0] + verdict[i, 1] * ordered[i, 4]
            traced[kept, 1] = ordered[i, 1] + verdict[i, 1] * ordered[i, 5]
            traced[kept, 2] = _weight(ordered[i], verdict[i], sigma_px, rules[2])
            traced[kept, 3], traced[kept, 4] = ordered[i, 2], sigma_px
            kept += 1
    return kept, count == points.shape[0]


@compiled_inline
def _weight(point: Floats32, verdict: Floats32, sigma_px: Real, roughest_px: Real) -> Real:
    """0..1: bright, sharp and calm.

    On skin the error grows threefold from the brightest to the dimmest stripes, where the light grazes. Weighing more
    steeply, or by the distance from the stripe's end, was tried: points close to the board then lose against the
    assumed sole, and the seen skin of the fitted foot gets worse (0.075 to 0.2 mm RMS).
    """
    bright = min(point[2] / _FULL_PEAK, 1.0)
    sharp = min(_SHARP_PX / sigma_px, 1.0)
    return bright * sharp * (1.0 - verdict[2] / roughest_px)
