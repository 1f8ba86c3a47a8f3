"""Two views of the same: both sheets on one board, and the sheets of two halves of the data."""

import numpy as np

from footscan.calibration.joint import JointFit
from footscan.calibration.misfit import head_angles, stripe_points_head
from footscan.calibration.sightings import FLOOR_PLACEMENT
from footscan.calibration.uncertainty import volume_points, working_pixels
from footscan.coordinates import LASER_NAMES, Floats
from footscan.geometry.plane import fit_plane

FEWEST_ON_ONE_BOARD = 30


def sheet_disagreements_mm(joint: JointFit) -> dict[int, float]:
    """Per placement (-1: footboard) on which both sheets left enough places: right minus left distance from it, mm."""
    fit, stripes = joint.fit, joint.sightings.stripes
    kept = fit.kept()[2 * len(joint.sightings.corners) :]
    height = _surface_distance_mm(joint)
    result: dict[int, float] = {}
    for placement in (*range(len(joint.intake.placement_names)), FLOOR_PLACEMENT):
        sides = [height[kept & (stripes.placement == placement) & (stripes.laser == code)] for code in (0, 1)]
        if min(len(side) for side in sides) >= FEWEST_ON_ONE_BOARD:
            result[placement] = float(np.median(sides[0]) - np.median(sides[1]))
    return result


def _surface_distance_mm(joint: JointFit) -> Floats:
    """Distance `(n,)` of every stripe place on its sheet from the board or footboard it lies on, towards the viewer."""
    machine, stripes = joint.fit.estimate.machine, joint.sightings.stripes
    theta_rad = head_angles(joint.fit.estimate, joint.sightings)[stripes.frame]
    xyz = np.zeros((len(stripes), 3))
    for code, name in enumerate(LASER_NAMES):
        own = stripes.laser == code
        xyz[own] = volume_points(machine, name, stripes.yz_pixel[own])
    c, s = np.cos(theta_rad), np.sin(theta_rad)
    world = np.stack([c * xyz[:, 0] - s * xyz[:, 1], s * xyz[:, 0] + c * xyz[:, 1], xyz[:, 2]], axis=-1)
    poses = joint.fit.estimate.world_from_board
    normals = np.vstack([-poses[:, :3, 2], machine.floor.normal_array])
    offsets = np.append(np.einsum("pi,pi->p", normals[:-1], poses[:, :3, 3]), machine.floor.offset_mm)
    return np.einsum("ni,ni->n", world, normals[stripes.placement]) - offsets[stripes.placement]


def halves_difference_mm(joint: JointFit) -> dict[str, float]:
    """RMS distance in the working volume between the sheets of every second frame and of the others, per laser."""
    fit, stripes = joint.fit, joint.sightings.stripes
    kept = fit.kept()[2 * len(joint.sightings.corners) :]
    xyz_head = stripe_points_head(fit.estimate, stripes, head_angles(fit.estimate, joint.sightings))
    result: dict[str, float] = {}
    for code, name in enumerate(LASER_NAMES):
        own = np.flatnonzero(kept & (stripes.laser == code))
        frames = np.unique(stripes.frame[own])
        first = np.isin(stripes.frame[own], frames[::2])
        one, two = (fit_plane(xyz_head[own[half]]) for half in (first, ~first))
        place = volume_points(fit.estimate.machine, name, working_pixels(fit.estimate.machine, name))
        off = np.abs(one.distance_mm(place)) - np.abs(two.distance_mm(place))
        signed = one.distance_mm(place) - np.sign(one.normal_array @ two.normal_array) * two.distance_mm(place)
        result[name] = float(np.sqrt(np.mean(np.minimum(np.abs(off), np.abs(signed)) ** 2)))
    return result
