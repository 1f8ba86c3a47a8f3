"""The residuals of an estimate, their derivatives and their robust weights.

Residuals are pixels: corners in both directions, stripe places across their stripe. Their scales are found from the
residuals themselves. Derivatives are central differences, taken for all boards in one go because no residual depends on
two boards; so their number does not grow with the placements.
"""

from dataclasses import dataclass, replace

import numpy as np

from footscan.calibration.estimate import LEFT, RIGHT, Estimate, difference_step, moved_boards, moved_machine
from footscan.calibration.misfit import (
    corner_misfit_px,
    head_angles,
    sheet_misfit_mm,
    stripe_misfit_mm,
    stripe_points_head,
    stripe_scale_mm_per_px,
)
from footscan.calibration.sightings import Sightings
from footscan.calibration.unknowns import Unknowns, firmness
from footscan.coordinates import Floats, Ints

TUKEY = 4.0
"""Residuals beyond this many standard deviations have no weight; below it Tukey's biweight."""
_HUBER = 1.5
_LEAST_SCALE_PX = 0.005
_SHEETS = frozenset((*RIGHT, *LEFT))
CORNERS_GROUPS = (0, 1)
GROUP_NAMES = (
    "corners_at_stops",
    "corners_moving",
    "stripe_on_plain_board",
    "stripe_on_pattern",
    "stripe_on_footboard",
)


@dataclass(frozen=True)
class Rows:
    """What each residual belongs to.

    Attributes:
        group: `(r,)` index into the kinds of residual.
        placement: `(r,)` placement or -1.
        frame: `(r,)` frame.
        laser: `(r,)` 0, 1, or -1 for corners.
    """

    group: Ints
    placement: Ints
    frame: Ints
    laser: Ints


def rows_of(sightings: Sightings) -> Rows:
    """Groups, placements, frames and lasers of the residuals: corners twice each (y, z), then stripe places."""
    corners, stripes = sightings.corners, sightings.stripes
    group = np.concatenate(
        [
            np.repeat(corners.moving.astype(np.int64), 2),
            np.where(stripes.placement >= 0, np.where(stripes.plain, 2, 3), 4),
        ]
    )
    placement = np.concatenate([np.repeat(corners.placement, 2), stripes.placement])
    frame = np.concatenate([np.repeat(corners.frame, 2), stripes.frame])
    laser = np.concatenate([np.full(2 * len(corners), -1, dtype=np.int64), stripes.laser])
    return Rows(group, placement, frame, laser)


class Problem:
    """Residuals and their derivatives for fixed sightings and unknowns."""

    def __init__(self, sightings: Sightings, unknowns: Unknowns, scale_px: Floats | None) -> None:
        self.sightings, self.unknowns, self.given_scale = sightings, unknowns, scale_px
        self.rows = rows_of(sightings)
        self.firmness = firmness(unknowns, len(sightings.placement_names))
        self._px_per_mm: Floats | None = None

    def residual_px(self, estimate: Estimate) -> Floats:
        """`(r,)` residuals; the scale from mm to px across the stripe is taken at the first estimate."""
        theta_rad = head_angles(estimate, self.sightings)
        corners = corner_misfit_px(estimate, self.sightings.corners, theta_rad)
        stripes = self.sightings.stripes
        if self._px_per_mm is None:
            self.rescale(estimate)
        assert self._px_per_mm is not None
        across = stripe_misfit_mm(estimate, stripes, theta_rad) * self._px_per_mm
        return np.concatenate([corners.ravel(), across])

    def pull(self, estimate: Estimate) -> Floats:
        """Slope `(k,)` of half the strain."""
        result = np.zeros(len(self.firmness))
        for prior in self.unknowns.priors:
            at = self.unknowns.machine.index(prior.name)
            result[at] = (getattr(estimate.machine.camera, prior.name) - prior.value) * self.firmness[at]
        return result

    def strain(self, estimate: Estimate) -> float:
        """How far the machine is from what is known beforehand, on the scale of `cost`."""
        off = [
            (getattr(estimate.machine.camera, prior.name) - prior.value) / prior.deviation
            for prior in self.unknowns.priors
        ]
        return 0.25 * float(np.sum(np.square(off)))

    def rescale(self, estimate: Estimate) -> None:
        """Take the scale of the stripe residuals, px per mm, from this estimate."""
        if not len(self.sightings.stripes):
            self._px_per_mm = np.zeros(0)
            return
        scale = stripe_scale_mm_per_px(estimate, self.sightings.stripes, head_angles(estimate, self.sightings))
        self._px_per_mm = 1.0 / np.maximum(scale, 0.02)

    def jacobian(self, estimate: Estimate) -> Floats:
        """`(r, k)` central differences."""
        self.rescale(estimate)
        placements = estimate.placements
        columns = {name: self._machine_column(estimate, name) for name in self.unknowns.machine if name not in _SHEETS}
        columns |= self._sheet_columns(estimate)
        width = len(self.unknowns.machine) + placements * len(self.unknowns.boards)
        result = np.zeros((len(self.rows.group), width))
        for k, name in enumerate(self.unknowns.machine):
            result[:, k] = columns[name]
        row = np.flatnonzero(self.rows.placement >= 0)
        for k, name in enumerate(self.unknowns.boards):
            at = len(self.unknowns.machine) + self.rows.placement[row] * len(self.unknowns.boards) + k
            result[row, at] = self._board_column(estimate, name)[row]
        return result

    def _machine_column(self, estimate: Estimate, name: str) -> Floats:
        h = difference_step(name)
        ahead, behind = (
            self.residual_px(replace(estimate, machine=moved_machine(estimate.machine, name, step))) for step in (h, -h)
        )
        return (ahead - behind) / (2.0 * h)

    def _sheet_columns(self, estimate: Estimate) -> dict[str, Floats]:
        """Columns of the sheets' own unknowns: they move no corner, nor where a ray meets a board."""
        names = [name for name in self.unknowns.machine if name in _SHEETS]
        if not names:
            return {}
        stripes = self.sightings.stripes
        xyz_head = stripe_points_head(estimate, stripes, head_angles(estimate, self.sightings))
        corners = np.zeros(2 * len(self.sightings.corners))
        assert self._px_per_mm is not None
        result: dict[str, Floats] = {}
        for name in names:
            h = difference_step(name)
            ahead, behind = (
                sheet_misfit_mm(moved_machine(estimate.machine, name, step), stripes, xyz_head) for step in (h, -h)
            )
            result[name] = np.concatenate([corners, (ahead - behind) / (2.0 * h) * self._px_per_mm])
        return result

    def _board_column(self, estimate: Estimate, name: str) -> Floats:
        h = difference_step(name)
        steps = np.full(estimate.placements, h)
        ahead, behind = (self.residual_px(moved_boards(estimate, name, sign * steps)) for sign in (1.0, -1.0))
        return (ahead - behind) / (2.0 * h)

    def moved(self, estimate: Estimate, step: Floats) -> Estimate:
        """The estimate moved by a step `(k,)` of all unknowns."""
        machine = estimate.machine
        for name, part in zip(self.unknowns.machine, step, strict=False):
            machine = moved_machine(machine, name, float(part))
        result = replace(estimate, machine=machine)
        of_boards = step[len(self.unknowns.machine) :].reshape(estimate.placements, -1)
        for k, name in enumerate(self.unknowns.boards):
            result = moved_boards(result, name, of_boards[:, k])
        return result

    def weights(self, residual: Floats, first: bool) -> tuple[Floats, Floats]:
        """Scale per kind, and the weight of every residual; Huber's in the first rounds, then Tukey's biweight."""
        scale = self._scales(residual) if self.given_scale is None else self.given_scale
        ratio = np.abs(residual) / scale[self.rows.group]
        if first:
            robust = np.minimum(1.0, _HUBER / np.maximum(ratio, 1e-12))
        else:
            robust = np.where(ratio < TUKEY, (1.0 - (ratio / TUKEY) ** 2) ** 2, 0.0)
        return scale, robust / scale[self.rows.group] ** 2

    def _scales(self, residual: Floats) -> Floats:
        scale = np.ones(len(GROUP_NAMES))
        for group in range(len(scale)):
            own = np.abs(residual[self.rows.group == group])
            if len(own):
                scale[group] = max(1.4826 * float(np.median(own)), _LEAST_SCALE_PX)
        return scale

    def cost(self, residual: Floats, scale: Floats) -> float:
        """Sum of a smooth robust loss (Cauchy's), which falls whenever a step helps most residuals."""
        ratio = residual / (2.0 * scale[self.rows.group])
        if not np.all(np.isfinite(ratio)):
            return np.inf
        return float(np.sum(np.log1p(ratio**2)))
