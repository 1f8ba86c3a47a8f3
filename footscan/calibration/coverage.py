"""How much of the picture and of the working volume a calibration rests on."""

import numpy as np

from footscan.calibration.joint import JointFit
from footscan.calibration.misfit import head_angles, stripe_points_head
from footscan.calibration.uncertainty import working_pixels
from footscan.coordinates import LASER_NAMES, Floats

_CELLS = 8


def image_coverage(joint: JointFit) -> float:
    """Share of an 8 x 8 grid of the picture that feet fill in which corners or stripe places were seen."""
    machine = joint.fit.estimate.machine
    camera = machine.camera
    size = np.array([camera.width_px, camera.height_px])

    def cells(yz_pixel: Floats) -> set[tuple[int, int]]:
        place = np.clip(yz_pixel / size * _CELLS, 0, _CELLS - 1).astype(np.int64)
        return {(int(a), int(b)) for a, b in place}

    needed = set[tuple[int, int]]().union(*(cells(working_pixels(machine, name)) for name in LASER_NAMES))
    seen = cells(joint.sightings.corners.yz_pixel) | cells(joint.sightings.stripes.yz_pixel)
    return len(needed & seen) / max(1, len(needed))


def height_coverage(joint: JointFit, laser: str) -> float:
    """Share of the 120 mm of the working volume that one laser's stripes on boards span (2nd to 98th percentile)."""
    stripes = joint.sightings.stripes
    own = stripes.kept((stripes.placement >= 0) & (stripes.laser == LASER_NAMES.index(laser)))  # type: ignore[arg-type]
    height = stripe_points_head(joint.fit.estimate, own, head_angles(joint.fit.estimate, joint.sightings))[:, 2]
    low, high = np.percentile(np.clip(height, 0.0, 120.0), [2.0, 98.0])
    return float((high - low) / 120.0)
