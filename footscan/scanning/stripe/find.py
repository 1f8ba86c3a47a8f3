"""`find_stripe`: one frame in, sub-pixel stripe places and weights out."""

import threading
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from footscan.coordinates import Floats, Floats32, Frame
from footscan.scanning.stripe.facet import border_kernels, line_kernels
from footscan.scanning.stripe.ridge import RIDGE_COLUMNS
from footscan.scanning.stripe.threshold import automatic_threshold
from footscan.scanning.stripe.trace import TRACE_COLUMNS, trace_stripe


@dataclass(frozen=True)
class Stripe:
    """The stripe of one frame.

    Attributes:
        uv: `(n, 2)` places (u, v) in the upright frame, px.
        weight: `(n,)` in 0..1, from peak height, width and how well the neighbours agree.
        peak: `(n,)` brightness of the smoothed stripe, grey values.
        sigma_px: `(n,)` width of the stripe across its direction, standard deviation, px.
    """

    uv: Floats
    weight: Floats
    peak: Floats
    sigma_px: Floats

    def __len__(self) -> int:
        return len(self.uv)


@dataclass(frozen=True)
class StripeSettings:
    """What counts as a laser stripe.

    Attributes:
        facet_sigma_px: Size of the neighbourhood a place is found from.
        sigma_px: Narrowest and widest stripe (standard deviation across) that light can make.
        steepest_along: Largest relative change of brightness along the stripe, 1/px.
        roundest: Largest curvature along the stripe relative to that across it (a round speck has 1).
        fewest_neighbours: Points within 7 px, itself included, below which a speck is no stripe.
        roughest_px: Largest RMS distance of the neighbours from their own quadratic.
        end_px: A point whose brightness changes along the stripe needs a neighbour this far on both sides.
    """

    facet_sigma_px: float = 1.2
    sigma_px: tuple[float, float] = (0.4, 4.5)
    steepest_along: float = 0.35
    roundest: float = 0.35
    fewest_neighbours: int = 5
    roughest_px: float = 0.35
    end_px: float = 0.7


DEFAULT_SETTINGS = StripeSettings()


class StripeFinder:
    """Finds stripes with buffers that are allocated once; one per thread."""

    def __init__(self, settings: StripeSettings = DEFAULT_SETTINGS) -> None:
        self.settings = settings
        variance = settings.facet_sigma_px**2
        narrow, wide = settings.sigma_px
        limits = (variance + narrow**2, variance + wide**2, settings.steepest_along, settings.roundest)
        rules = (settings.fewest_neighbours, settings.end_px, settings.roughest_px, variance)
        self._constants = (
            line_kernels(settings.facet_sigma_px),
            border_kernels(settings.facet_sigma_px),
            np.array(limits, dtype=np.float32),
            np.array(rules, dtype=np.float32),
        )
        self._buffers = _buffers(0)

    def find(self, frame: Frame, threshold: int) -> Stripe:
        """Find the stripe of an upright frame `(height, width)` uint8 with a given threshold (0..255).

        Raises:
            ValueError: The frame is not a two-dimensional array of bytes, or the threshold no byte.
        """
        frame, threshold = _checked(frame), _checked_threshold(threshold)
        capacity = 32 * (frame.shape[0] + frame.shape[1])
        if len(self._buffers[0]) < capacity:
            self._buffers = _buffers(capacity)
        count, full = trace_stripe(frame, threshold, *self._constants, *self._buffers)
        while full:
            self._buffers = _buffers(2 * len(self._buffers[0]))
            count, full = trace_stripe(frame, threshold, *self._constants, *self._buffers)
        own = self._buffers[3][:count].copy()
        return Stripe(own[:, 0:2], own[:, 2], own[:, 3], own[:, 4])


def _buffers(capacity: int) -> tuple[Floats32, Floats32, Floats32, Floats]:
    points = np.empty((capacity, RIDGE_COLUMNS), dtype=np.float32)
    verdict = np.empty((capacity, 3), dtype=np.float32)
    return points, np.empty_like(points), verdict, np.empty((capacity, TRACE_COLUMNS))


def find_stripe(frame: Frame, threshold: int | None = None) -> Stripe:
    """Find the laser stripe of one upright frame.

    Args:
        frame: `(height, width)` uint8, upright.
        threshold: A pixel counts when it is above it; `None` takes `automatic_threshold` of this frame.

    Returns:
        The stripe; empty when nothing in the frame is one.

    Raises:
        ValueError: The frame is not a two-dimensional array of bytes, or the threshold no byte.
    """
    frame = _checked(frame)
    finder = _finder_of_thread(threading.get_ident())
    return finder.find(frame, automatic_threshold(frame) if threshold is None else threshold)


@lru_cache(maxsize=16)
def _finder_of_thread(_: int) -> StripeFinder:
    """Buffers that `find_stripe` reuses from frame to frame, one set per thread."""
    return StripeFinder()


def _checked(frame: Frame) -> Frame:
    if frame.ndim != 2 or frame.dtype != np.uint8:
        raise ValueError(f"a frame is (height, width) uint8, found {frame.shape} {frame.dtype}")
    return np.ascontiguousarray(frame)


def _checked_threshold(threshold: int) -> int:
    if not 0 <= threshold <= 255:
        raise ValueError(f"a threshold lies between 0 and 255, found {threshold}")
    return int(threshold)
