"""`find_stripe`: one frame in, sub-pixel stripe places and weights out."""

from dataclasses import dataclass, field

import numpy as np

from footscan.coordinates import Floats, Floats32, Frame
from footscan.scanning.stripe.facet import border_kernels, line_kernels
from footscan.scanning.stripe.neighbours import judge_points, row_starts, sort_by_pixel
from footscan.scanning.stripe.ridge import RIDGE_COLUMNS, add_border_points, find_ridge_points
from footscan.scanning.stripe.threshold import automatic_threshold


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
        fewest_neighbours: Points within 5 px, itself included, below which a speck is no stripe.
        roughest_px: Largest RMS distance of the neighbours from their own quadratic.
    """

    facet_sigma_px: float = 1.2
    sigma_px: tuple[float, float] = (0.4, 4.5)
    steepest_along: float = 0.35
    roundest: float = 0.35
    fewest_neighbours: int = 6
    roughest_px: float = 0.35
    end_px: float = 0.7


DEFAULT_SETTINGS = StripeSettings()


class StripeFinder:
    """Finds stripes with buffers that are allocated once; one per thread."""

    def __init__(self, settings: StripeSettings = DEFAULT_SETTINGS) -> None:
        self.settings = settings
        sigma2 = settings.facet_sigma_px**2
        self._lines = line_kernels(settings.facet_sigma_px)
        self._cut = border_kernels(settings.facet_sigma_px)
        narrow, wide = settings.sigma_px
        self._limits = np.array(
            [sigma2 + narrow**2, sigma2 + wide**2, settings.steepest_along, settings.roundest], dtype=np.float32
        )
        self._points = np.empty((0, RIDGE_COLUMNS), dtype=np.float32)
        self._ordered = self._points
        self._verdict = np.empty((0, 3), dtype=np.float32)

    def find(self, frame: Frame, threshold: int) -> Stripe:
        """Find the stripe of an upright frame `(height, width)` uint8 with a given threshold (0..255).

        Raises:
            ValueError: The frame is not a two-dimensional array of bytes, or the threshold no byte.
        """
        points, verdict = self._judged(_checked(frame), _checked_threshold(threshold))
        settings = self.settings
        keep = (verdict[:, 0] > 0.0) & (verdict[:, 2] < settings.roughest_px)
        return _stripe(points[keep], verdict[keep], settings)

    def _judged(self, frame: Frame, threshold: int) -> tuple[Floats32, Floats32]:
        self._make_room(frame.shape)
        count = find_ridge_points(frame, threshold, self._lines, self._limits, self._points)
        count = add_border_points(frame, threshold, self._cut, self._limits, self._points, count)
        starts = row_starts(self._points, count, frame.shape[0])
        sort_by_pixel(self._points, count, starts, self._ordered)
        fewest = self.settings.fewest_neighbours
        judge_points(self._ordered, count, starts, frame.shape[1], fewest, self.settings.end_px, self._verdict)
        return self._ordered[:count], self._verdict[:count]

    def _make_room(self, shape: tuple[int, ...]) -> None:
        capacity = 32 * (shape[0] + shape[1])
        if len(self._points) < capacity:
            self._points = np.empty((capacity, RIDGE_COLUMNS), dtype=np.float32)
            self._ordered = np.empty_like(self._points)
            self._verdict = np.empty((capacity, 3), dtype=np.float32)


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
    return StripeFinder().find(frame, automatic_threshold(frame) if threshold is None else threshold)


def _checked(frame: Frame) -> Frame:
    if frame.ndim != 2 or frame.dtype != np.uint8:
        raise ValueError(f"a frame is (height, width) uint8, found {frame.shape} {frame.dtype}")
    return np.ascontiguousarray(frame)


def _checked_threshold(threshold: int) -> int:
    if not 0 <= threshold <= 255:
        raise ValueError(f"a threshold lies between 0 and 255, found {threshold}")
    return int(threshold)


def _stripe(points: Floats32, verdict: Floats32, settings: StripeSettings) -> Stripe:
    shift = verdict[:, 1:2]
    uv = (points[:, 0:2] + shift * points[:, 4:6]).astype(np.float64)
    peak = points[:, 2].astype(np.float64)
    sigma = np.sqrt(np.maximum(points[:, 3] - settings.facet_sigma_px**2, 0.0)).astype(np.float64)
    sharp = np.minimum(1.0, 2.0 / np.maximum(sigma, 1e-6))
    calm = 1.0 - verdict[:, 2].astype(np.float64) / settings.roughest_px
    return Stripe(uv, np.minimum(peak / 200.0, 1.0) * sharp * calm, peak, sigma)
