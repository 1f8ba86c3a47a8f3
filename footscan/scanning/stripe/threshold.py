"""The binarisation threshold, found from the brightness of one frame or of a whole sweep."""

import cv2
import numpy as np

from footscan.coordinates import Frame, Ints

_LARGEST_STRIPE_SHARE = 0.02
_FLAT = 2.0
_AHEAD = slice(4, 13)
_MARGIN = 2
_HIGHEST = 240


def brightness_histogram(frame: Frame) -> Ints:
    """`(256,)` counts of grey values; sum the histograms of several frames for the threshold of a sweep."""
    return cv2.calcHist([frame], [0], None, [256], [0.0, 256.0]).ravel().astype(np.int64)


def threshold_from_histogram(histogram: Ints) -> int:
    """The grey value where the background's tail ends.

    A stripe covers at most a few pixels in a hundred, so the search starts where only that share is brighter. The
    tail of the background falls steeply, while a stripe's flanks fill all grey values about evenly: the threshold is
    the first level that no longer stands out from those a little above it. A dark picture gives a level above its
    noise. Recorders may store everything darker than some grey value as 0: then the background begins above that gap.
    """
    brighter = histogram[::-1].cumsum()[::-1]
    dark_enough = brighter[1:] <= _LARGEST_STRIPE_SHARE * brighter[0]
    level = int(np.argmax(dark_enough)) if dark_enough.any() else _HIGHEST
    beyond_gap = _end_of_tail(histogram, max(level, _first_after_black(histogram)))
    if brighter[beyond_gap] > 0:
        return min(beyond_gap + _MARGIN, _HIGHEST)
    return min(_end_of_tail(histogram, level) + _MARGIN, _HIGHEST)


def _first_after_black(histogram: Ints) -> int:
    """The darkest grey value in use beside 0."""
    return 1 + int(np.argmax(histogram[1:] > 0))


def _end_of_tail(histogram: Ints, level: int) -> int:
    """The first level from `level` on that does not stand out from those a little above it."""
    while level < _HIGHEST:
        ahead = histogram[level + _AHEAD.start : level + _AHEAD.stop]
        if histogram[level] <= _FLAT * ahead.mean():
            break
        level += 1
    return level


def automatic_threshold(frame: Frame) -> int:
    """Threshold (grey value) of one frame by `threshold_from_histogram`."""
    return threshold_from_histogram(brightness_histogram(frame))
