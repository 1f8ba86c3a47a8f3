"""What one placement of the board and the bare footboard say: enough to align lasers, or to check a calibration."""

from dataclasses import dataclass, replace

import numpy as np

from footscan.calibration.estimate import CAMERA, FLOOR, HEAD, LEFT, RIGHT, Estimate
from footscan.calibration.first_guess import guess_estimate
from footscan.calibration.intake import Intake
from footscan.calibration.joint import consensus_sheet, lowered
from footscan.calibration.misfit import head_angles, stripe_misfit_mm, stripe_points_head
from footscan.calibration.sightings import FLOOR_PLACEMENT, NO_STRIPES, Sightings, StripePoints
from footscan.calibration.solve import Fit, fit_estimate
from footscan.calibration.stripes import assign_stripes
from footscan.calibration.uncertainty import volume_points
from footscan.calibration.unknowns import POSES_ONLY, Unknowns
from footscan.coordinates import LASER_NAMES, Bools, Floats, LaserName
from footscan.errors import PoorFitError
from footscan.geometry.plane import fit_plane
from footscan.optics import Calibration

FEWEST_PLACES = 40
_SEEN_BY_ONE = tuple(name for name in (*CAMERA, *HEAD) if name not in ("k2_per_mm4", "t_z_mm"))


def fit_roughly(intake: Intake, raw: StripePoints, machine: Calibration) -> Fit:
    """Camera, axis and both sheets to some hundredths of a millimetre from one placement, starting at a machine.

    Raises:
        PoorFitError: A laser left too few stripe places.
    """
    corners = Sightings(intake.times, intake.corners, NO_STRIPES, intake.placement_names)
    seen = fit_estimate(guess_estimate(intake, machine), corners, Unknowns(_SEEN_BY_ONE))
    first = _assigned(raw, seen.estimate, intake, corners)
    start = _with_sheets(seen.estimate, first)
    sightings = _assigned(raw, start, intake, corners)  # now that the height of the footboard is known
    return fit_estimate(
        _with_sheets(start, sightings), sightings, Unknowns((*_SEEN_BY_ONE, "t_z_mm", *RIGHT, *LEFT, *FLOOR))
    )


def _assigned(raw: StripePoints, estimate: Estimate, intake: Intake, corners: Sightings) -> Sightings:
    stripes = assign_stripes(raw, estimate, intake)
    refuse_few_places(stripes)
    return replace(corners, stripes=stripes)


def refuse_few_places(stripes: StripePoints) -> None:
    """Refuse where a laser left too few stripe places on boards or footboard.

    Raises:
        PoorFitError: Which laser, where, and what to do.
    """
    for code, name in enumerate(LASER_NAMES):
        for where, on_floor in (("the board", False), ("the bare footboard", True)):
            count = int(
                np.count_nonzero((stripes.laser == code) & ((stripes.placement == FLOOR_PLACEMENT) == on_floor))
            )
            if count < FEWEST_PLACES:
                raise PoorFitError(
                    f"the {name} laser shows {count} stripe places on {where}, at least {FEWEST_PLACES} are needed: "
                    "check that it is on, focused and not covered, and that the board stands near the axis."
                )


def _with_sheets(estimate: Estimate, sightings: Sightings) -> Estimate:
    """Sheets through their stripe places on board and footboard, the footboard's height from where both agree."""
    stripes = sightings.stripes
    theta_rad = head_angles(estimate, sightings)
    xyz_head = stripe_points_head(estimate, stripes, theta_rad)
    on_board = stripes.placement != FLOOR_PLACEMENT
    right, left = (
        consensus_sheet(sheet, xyz_head[on_board & (stripes.laser == code)])
        for code, sheet in enumerate(estimate.machine.lasers)
    )
    machine = replace(estimate.machine, lasers=(right, left))
    floor = stripes.kept(~on_board)
    heights = [
        volume_points(machine, name, floor.yz_pixel[floor.laser == code])[:, 2] for code, name in enumerate(LASER_NAMES)
    ]
    return lowered(replace(estimate, machine=machine), float(np.median(np.concatenate(heights))))


@dataclass(frozen=True)
class Recheck:
    """How well a calibration predicts one placement that it never saw; only the board's pose is fitted.

    Attributes:
        corner_rms_px: Of the board's corners, each counted up to 3 px.
        sheet_mm: Median distance of each laser's stripe on the board from its sheet.
        sheet_turned_mm: What a sheet is off at the ends of 100 mm by its turn against the stripes on the board.
        floor_mm: Median height of each laser's stripe on the bare footboard above the calibrated one.
        floor_lean_deg: Between the calibrated footboard and the plane through those stripes.
    """

    corner_rms_px: float
    sheet_mm: dict[LaserName, float]
    sheet_turned_mm: dict[LaserName, float]
    floor_mm: dict[LaserName, float]
    floor_lean_deg: float


def recheck(intake: Intake, raw: StripePoints, machine: Calibration) -> Recheck:
    """Hold a calibration against what one placement (or several) and the bare footboard show.

    Raises:
        PoorFitError: A laser left too few stripe places to say anything.
    """
    corners = Sightings(intake.times, intake.corners, NO_STRIPES, intake.placement_names)
    posed = fit_estimate(guess_estimate(intake, machine), corners, POSES_ONLY)
    sightings = _assigned(raw, posed.estimate, intake, corners)
    stripes = sightings.stripes
    misfit = np.minimum(np.abs(np.nan_to_num(posed.residual_px, nan=3.0)), 3.0)
    off_mm = stripe_misfit_mm(posed.estimate, stripes, head_angles(posed.estimate, sightings))
    on_board = stripes.placement != FLOOR_PLACEMENT
    height = _floor_height(machine, sightings)
    return Recheck(
        float(np.sqrt(np.mean(misfit**2))),
        per_laser(stripes, off_mm, on_board),
        {name: _turned_mm(posed.estimate, sightings, code, off_mm) for code, name in enumerate(LASER_NAMES)},
        {name: float(np.median(h)) for name, h in height.items()},
        _floor_lean_deg(machine, sightings),
    )


def per_laser(stripes: StripePoints, value: Floats, where: Bools) -> dict[LaserName, float]:
    """Median of some values `(n,)` of stripe places where `where` `(n,)` holds, per laser."""
    return {name: float(np.median(value[where & (stripes.laser == code)])) for code, name in enumerate(LASER_NAMES)}


def _turned_mm(estimate: Estimate, sightings: Sightings, code: int, off_mm: Floats) -> float:
    """Slope of the distance from a sheet along the head's x, y and z, as mm at the ends of 100 mm."""
    stripes = sightings.stripes
    own = (stripes.placement != FLOOR_PLACEMENT) & (stripes.laser == code)
    xyz = stripe_points_head(estimate, stripes.kept(own), head_angles(estimate, sightings))
    near = np.abs(off_mm[own] - np.median(off_mm[own])) < 1.0
    xyz, off = xyz[near] - xyz[near].mean(axis=0), off_mm[own][near]
    sheet = estimate.machine.lasers[code]
    level = np.array([sheet.normal[1], -sheet.normal[0], 0.0])
    inside = np.column_stack([xyz @ level, xyz[:, 2], np.ones(len(xyz))])
    slope = np.linalg.lstsq(inside, off, rcond=None)[0]
    return float(50.0 * np.hypot(slope[0], slope[1]))


def floor_places(machine: Calibration, sightings: Sightings) -> dict[LaserName, Floats]:
    """World places at theta = 0 of each laser's stripe on the bare footboard, turned by the head's angle."""
    stripes, theta_rad = sightings.stripes, head_angles(_held(machine), sightings)
    result: dict[LaserName, Floats] = {}
    for code, name in enumerate(LASER_NAMES):
        own = (stripes.placement == FLOOR_PLACEMENT) & (stripes.laser == code)
        xyz = volume_points(machine, name, stripes.yz_pixel[own])
        c, s = np.cos(theta_rad[stripes.frame[own]]), np.sin(theta_rad[stripes.frame[own]])
        result[name] = np.column_stack([c * xyz[:, 0] - s * xyz[:, 1], s * xyz[:, 0] + c * xyz[:, 1], xyz[:, 2]])
    return result


def _held(machine: Calibration) -> Estimate:
    return Estimate(machine, np.zeros((0, 4, 4)), np.zeros((0, 7)))


def _floor_height(machine: Calibration, sightings: Sightings) -> dict[LaserName, Floats]:
    floor = machine.floor
    return {name: xyz @ floor.normal_array - floor.offset_mm for name, xyz in floor_places(machine, sightings).items()}


def _floor_lean_deg(machine: Calibration, sightings: Sightings) -> float:
    xyz = np.concatenate(list(floor_places(machine, sightings).values()))
    height = xyz @ machine.floor.normal_array - machine.floor.offset_mm
    plane = fit_plane(xyz[np.abs(height - np.median(height)) < 1.5])
    return float(np.degrees(np.arccos(min(1.0, abs(float(plane.normal_array @ machine.floor.normal_array))))))
