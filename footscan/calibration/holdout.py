"""Placements that the fit never saw: each left out once, then predicted."""

from dataclasses import dataclass

import numpy as np

from footscan.calibration.estimate import Estimate
from footscan.calibration.joint import JointFit
from footscan.calibration.misfit import corner_misfit_px, head_angles, stripe_misfit_mm
from footscan.calibration.sightings import Sightings
from footscan.calibration.solve import fit_estimate
from footscan.calibration.unknowns import POSES_ONLY, Unknowns
from footscan.coordinates import LASER_NAMES, Floats

_ROUNDS = 12
_FEWEST = 20


@dataclass(frozen=True)
class HoldOut:
    """How well a fit without one placement predicts it; only the board's own pose is fitted to its corners.

    Attributes:
        placement: Which one was left out.
        corner_rms_px: RMS of its corners.
        sheet_mm: Mean distance of each sheet from its stripe places (right, left); NaN where too few were seen.
    """

    placement: int
    corner_rms_px: float
    sheet_mm: tuple[float, float]

    @property
    def worst_sheet_mm(self) -> float:
        """The larger of both distances; 0 where neither stripe was seen."""
        seen = [abs(x) for x in self.sheet_mm if np.isfinite(x)]
        return max(seen, default=0.0)


def hold_out_each(joint: JointFit) -> list[HoldOut]:
    """Leave out every placement once."""
    return [_hold_out(joint, p) for p in range(len(joint.intake.placement_names))]


def _hold_out(joint: JointFit, placement: int) -> HoldOut:
    fit = joint.fit
    rest = joint.sightings.without(placement)
    blind = fit_estimate(fit.estimate, rest, fit.unknowns, scale_px=fit.scale_px, rounds=_ROUNDS)
    own = joint.sightings.only(placement)
    corners_only = Sightings(
        own.times, own.corners, own.stripes.kept(np.zeros(len(own.stripes), bool)), own.placement_names
    )
    posed = fit_estimate(
        blind.estimate, corners_only, Unknowns(POSES_ONLY.machine), scale_px=fit.scale_px, rounds=_ROUNDS
    )
    theta_rad = head_angles(posed.estimate, own)
    misfit = np.minimum(np.abs(np.nan_to_num(corner_misfit_px(posed.estimate, own.corners, theta_rad), nan=3.0)), 3.0)
    right, left = (_mean_mm(posed.estimate, own, code, theta_rad) for code in range(len(LASER_NAMES)))
    return HoldOut(placement, float(np.sqrt(np.mean(misfit**2))), (right, left))


def _mean_mm(estimate: Estimate, own: Sightings, code: int, theta_rad: Floats) -> float:
    stripes = own.stripes.kept(own.stripes.laser == code)
    if len(stripes) < _FEWEST:
        return float("nan")
    return float(np.median(stripe_misfit_mm(estimate, stripes, theta_rad)))
