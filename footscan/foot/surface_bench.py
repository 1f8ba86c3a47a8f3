"""How long the fit takes beside geomdl's own, on the same gridded points with as many control points."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from geomdl import fitting

from footscan.foot.nurbs import DEGREE, SplineTube, clamped_knots
from footscan.foot.nurbs_fit import fit_tube

Result = TypeVar("Result")


@dataclass(frozen=True)
class FitTimes:
    """Seconds of the two fits of one grid of points.

    Attributes:
        points: Points fitted.
        controls: Control points of each fit.
        ours_s: Least of three runs.
        geomdl_s: One run.
        ours_rms_mm: RMS deviation of ours at the points (geomdl chooses parameters of its own).
    """

    points: int
    controls: int
    ours_s: float
    geomdl_s: float
    ours_rms_mm: float

    @property
    def ratio(self) -> float:
        """How many times faster ours is."""
        return self.geomdl_s / self.ours_s


def compare_fits(
    tube: SplineTube, points: tuple[int, int] = (120, 80), controls: tuple[int, int] = (60, 40)
) -> FitTimes:
    """Fit a grid of places of a foot with both.

    Args:
        tube: The foot.
        points: Grid around and up.
        controls: Control points around and up.
    """
    u, v = np.linspace(0.0, 1.0, points[0]), np.linspace(0.0, 1.0, points[1])
    place = tube.grid(u, v)
    flat = place.transpose(1, 0, 2).reshape(-1, 3)
    knots = clamped_knots(np.linspace(0.0, 1.0, controls[1] - 2))
    scattered_u, scattered_v = np.repeat(u, points[1]), np.tile(v, points[0])
    stiffness, weight = np.full((controls[1], controls[0]), 1e-6), np.ones(len(flat))

    def fit_ours() -> SplineTube:
        return fit_tube(scattered_u, scattered_v, flat, weight, controls[0], knots, stiffness)

    fit_ours()
    ours = [_timed(fit_ours) for _ in range(3)]
    listed = flat.tolist()
    theirs_s, _ = _timed(
        lambda: fitting.approximate_surface(
            listed, *points, DEGREE, DEGREE, ctrlpts_size_u=controls[0], ctrlpts_size_v=controls[1]
        )
    )
    rms = float(np.sqrt(((ours[0][1].grid(u, v) - place) ** 2).sum(axis=2).mean()))
    return FitTimes(len(flat), controls[0] * controls[1], min(seconds for seconds, _ in ours), theirs_s, rms)


def _timed(work: Callable[[], Result]) -> tuple[float, Result]:
    start = time.perf_counter()
    result = work()
    return time.perf_counter() - start, result
