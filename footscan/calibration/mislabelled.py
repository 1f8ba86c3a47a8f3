"""Stripes that lie off their sheet: under the other laser's name, or where a placement is otherwise wrong."""

import numpy as np

from footscan.calibration.gates import Limits, placement_stripes
from footscan.calibration.joint import JointFit
from footscan.calibration.misfit import head_angles, stripe_misfit_mm
from footscan.calibration.sightings import FLOOR_PLACEMENT
from footscan.coordinates import LASER_NAMES

_NEAR_MM = 0.5
_MOST = 0.5
_FEWEST = 30


def explain_stripes(joint: JointFit, limits: Limits) -> str:
    """A reason why stripes of some placement contradict the others, or an empty text."""
    names = joint.intake.placement_names
    for placement in (*range(len(names)), FLOOR_PLACEMENT):
        scatter, rejected = placement_stripes(joint.fit, placement)
        if scatter > limits.stripe_px or rejected > _MOST:
            where = "the bare footboard" if placement == FLOOR_PLACEMENT else f"placement {names[placement]}"
            if _fits_other_laser(joint, placement):
                return (
                    f"{where}: the lasers are mislabelled, stripes called right lie on the left laser's sheet and vice "
                    "versa. Correct frames.csv or the wiring and record it again."
                )
    return ""


def _fits_other_laser(joint: JointFit, placement: int) -> bool:
    stripes = joint.sightings.stripes.kept(joint.sightings.stripes.placement == placement)
    if len(stripes) < _FEWEST:
        return False
    estimate = joint.fit.estimate
    theta_rad = head_angles(estimate, joint.sightings)
    exchanged = type(stripes)(
        stripes.frame, stripes.placement, len(LASER_NAMES) - 1 - stripes.laser, stripes.yz_pixel, stripes.plain
    )
    return float(np.median(np.abs(stripe_misfit_mm(estimate, exchanged, theta_rad)))) < _NEAR_MM
