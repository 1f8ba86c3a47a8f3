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
    noise.
    """
    brighter = histogram[::-1].cumsum()[::-1]
    dark_enough = brighter[1:] <= _LARGEST_STRIPE_SHARE * brighter[0]
    level = int(np.argmax(dark_enough)) if dark_enough.any() else _HIGHEST
    while level < _HIGHEST:
        ahead = histogram[level + _AHEAD.start : level + _AHEAD.stop]
        if histogram[level] <= _FLAT * ahead.mean():
            break
        level += 1
    return min(level + _MARGIN, _HIGHEST)


def automatic_threshold(frame: Frame) -> int:
    """Threshold (grey value) of one frame by `threshold_from_histogram`."""
    return threshold_from_histogram(brightness_histogram(frame))
