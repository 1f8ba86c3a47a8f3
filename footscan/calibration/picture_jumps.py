"""Does the picture sit at the same place on the sensor in every placement?"""

from dataclasses import dataclass

import numpy as np

from footscan.calibration.estimate import LENS, POSE, SHAPE
from footscan.calibration.gate import Gate
from footscan.calibration.intake import Intake
from footscan.calibration.joint import CORNERS_ONLY
from footscan.calibration.sightings import NO_STRIPES, Sightings
from footscan.calibration.solve import Fit, fit_estimate
from footscan.calibration.unknowns import Unknowns
from footscan.coordinates import Floats

MOST_KNOCK_PX = np.array([0.05, 0.2])
"""Jump of the picture along the rows and the columns of the sensor; the second one hides behind the boards' height."""
_SURE = 5.0
_FREE_LENS = tuple(name for name in CORNERS_ONLY.machine if not name.startswith(("principal", "latency")))


@dataclass(frozen=True)
class PictureJumps:
    """Shift of the picture on the sensor from placement to placement, `(p - 1, 2)` px, and what may be chance."""

    jump_px: Floats
    chance_px: Floats

    def ratio(self) -> Floats:
        """Each jump `(p - 1,)` relative to what is allowed."""
        return np.max(np.abs(self.jump_px) / np.maximum(MOST_KNOCK_PX, self.chance_px), axis=1)


def picture_jumps(intake: Intake, corners_fit: Fit) -> tuple[PictureJumps, Fit]:
    """Let the picture sit elsewhere on the sensor in every placement, at the stops; returns the jumps and the fit."""
    at_stops = intake.corners.kept(~intake.corners.moving)
    sightings = Sightings(intake.times, at_stops, NO_STRIPES, intake.placement_names)
    free = fit_estimate(corners_fit.estimate, sightings, Unknowns(_FREE_LENS, POSE + LENS))
    return jumps_of(free), free


def jumps_of(free: Fit) -> PictureJumps:
    """The jumps that a fit with a free lens shows."""
    names, spread = free.unknowns.names(free.estimate.placements), free.spread()
    jump = np.diff(free.estimate.doubts[:, len(SHAPE) :], axis=0)
    chance = np.zeros_like(jump)
    for column, name in enumerate(LENS):
        for p in range(len(jump)):
            i, j = names.index(f"{name}[{p}]"), names.index(f"{name}[{p + 1}]")
            chance[p, column] = _SURE * np.sqrt(max(0.0, spread[i, i] + spread[j, j] - 2.0 * spread[i, j]))
    return PictureJumps(jump, chance)


def jump_gate(jumps: PictureJumps, names: tuple[str, ...]) -> Gate:
    """Gate on the lens: the picture must not jump between placements."""
    ratio = jumps.ratio()
    at = int(np.argmax(ratio))
    size = float(np.hypot(*jumps.jump_px[at]))
    return Gate(
        "picture_jump_of_allowed",
        float(ratio[at]),
        1.0,
        f"between placements {names[at]} and {names[at + 1]}",
        f"The picture jumps by {size:.2f} px: lens or camera was knocked. Fix both and record everything again.",
    )
