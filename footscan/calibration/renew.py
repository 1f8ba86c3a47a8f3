"""Partial renewal: after one part was exchanged only that part is estimated, and the rest must still hold."""

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from footscan.calibration.estimate import ENCODER, LEFT, RIGHT, Estimate
from footscan.calibration.first_guess import guess_estimate
from footscan.calibration.gate import Gate
from footscan.calibration.gates import LIMITS, Limits, corner_gates
from footscan.calibration.intake import Intake
from footscan.calibration.joint import consensus_sheet, lowered
from footscan.calibration.misfit import head_angles, stripe_misfit_mm, stripe_points_head
from footscan.calibration.one_placement import floor_places, per_laser, refuse_few_places
from footscan.calibration.sightings import FLOOR_PLACEMENT, NO_STRIPES, Sightings, StripePoints
from footscan.calibration.solve import Fit, fit_estimate
from footscan.calibration.stripes import assign_stripes
from footscan.calibration.uncertainty import standard_deviations, volume_points, working_pixels
from footscan.calibration.unknowns import POSES_ONLY, Unknowns
from footscan.coordinates import LASER_NAMES
from footscan.errors import PoorFitError
from footscan.geometry.plane import Plane, fit_plane
from footscan.optics import Calibration

Part = Literal["right-laser", "left-laser", "encoder", "footboard"]
PARTS: tuple[Part, ...] = get_args(Part)
_MOST_OTHER_MM = 0.15
_MOST_FLOOR_MM = 0.3
_MOST_EXPECTED_MM = 0.06
_REACH_MM = 120.0


@dataclass(frozen=True)
class Renewed:
    """A machine of which one part was estimated anew; the gates say that the rest still holds."""

    part: Part
    calibration: Calibration
    fit: Fit
    gates: list[Gate]


def renew(intake: Intake, raw: StripePoints, machine: Calibration, part: Part, limits: Limits = LIMITS) -> Renewed:
    """Estimate one part of a machine from boards and footboard; everything else stays.

    The encoder's zero is the zero of scanner.toml (where theta is 0 is a matter of definition); its direction is found
    by trying both, its eccentricity and the latency are estimated.

    Raises:
        PoorFitError: More than this part has changed, or too little of it was seen; which is named.
    """
    corners = Sightings(intake.times, intake.corners, NO_STRIPES, intake.placement_names)
    fit = _encoder(intake, corners, machine) if part == "encoder" else _posed(intake, corners, machine)
    _pass(corner_gates(fit, intake.placement_names, limits), part)
    stripes = assign_stripes(raw, fit.estimate, intake)
    refuse_few_places(stripes)
    sightings = replace(corners, stripes=stripes)
    if part in ("right-laser", "left-laser"):
        fit = _sheet(fit.estimate, sightings, LASER_NAMES.index("right" if part == "right-laser" else "left"))
    elif part == "footboard":
        fit = replace(fit, estimate=_footboard(fit.estimate, sightings))
    gates = _gates(fit, sightings, part, limits)
    _pass(gates, part)
    return Renewed(part, fit.estimate.machine, fit, gates)


def _pass(gates: list[Gate], part: Part) -> None:
    for gate in gates:
        if not gate.passed:
            raise PoorFitError(f"the {part} cannot be renewed alone: {gate.sentence()} The calibration in force stays.")


def _posed(intake: Intake, corners: Sightings, machine: Calibration) -> Fit:
    return fit_estimate(guess_estimate(intake, machine), corners, POSES_ONLY)


def _encoder(intake: Intake, corners: Sightings, machine: Calibration) -> Fit:
    """The better of both directions; the latency where moving frames show it."""
    encoder = intake.recording.scanner.encoder
    free = (*ENCODER, "latency_s") if np.any(intake.corners.moving) else ENCODER
    fits = [
        fit_estimate(
            guess_estimate(intake, replace(machine, encoder=replace(encoder, direction=direction))),
            corners,
            Unknowns(free),
        )
        for direction in (1, -1)
    ]
    return min(fits, key=lambda fit: float(np.median(np.abs(np.nan_to_num(fit.residual_px, nan=1e3)))))


def _sheet(estimate: Estimate, sightings: Sightings, code: int) -> Fit:
    stripes = sightings.stripes
    own = (stripes.laser == code) & (stripes.placement != FLOOR_PLACEMENT)
    xyz_head = stripe_points_head(estimate, stripes.kept(own), head_angles(estimate, sightings))
    sheets = list(estimate.machine.lasers)
    sheets[code] = consensus_sheet(sheets[code], xyz_head)
    start = replace(estimate, machine=replace(estimate.machine, lasers=(sheets[0], sheets[1])))
    only = replace(sightings, stripes=stripes.kept(stripes.laser == code))
    return fit_estimate(start, only, Unknowns((RIGHT, LEFT)[code]))


def _footboard(estimate: Estimate, sightings: Sightings) -> Estimate:
    """Slope and height of the footboard from the stripes on it; W's origin moves along the axis to its new height."""
    xyz = np.concatenate(list(floor_places(estimate.machine, sightings).values()))
    plane = fit_plane(xyz[np.abs(xyz[:, 2] - np.median(xyz[:, 2])) < 3.0])
    n_x, n_y, n_z = (float(x) for x in plane.normal_array * np.sign(plane.normal_array[2]))
    height = float(plane.offset_mm * np.sign(plane.normal_array[2]) / n_z)
    moved = lowered(estimate, height)
    return replace(moved, machine=replace(moved.machine, floor=Plane((n_x, n_y, n_z), 0.0)))


def _gates(fit: Fit, sightings: Sightings, part: Part, limits: Limits) -> list[Gate]:
    estimate, stripes = fit.estimate, sightings.stripes
    off_mm = stripe_misfit_mm(estimate, stripes, head_angles(estimate, sightings))
    sheets = per_laser(stripes, off_mm, stripes.placement != FLOOR_PLACEMENT)
    changed = "Something else has changed too, or was knocked: calibrate the whole machine."
    gates = [
        Gate("sheet_off_board_mm", abs(off), _MOST_OTHER_MM, f"{name} laser", changed) for name, off in sheets.items()
    ]
    floor = estimate.machine.floor
    for name, xyz in floor_places(estimate.machine, sightings).items():
        height = float(np.median(xyz @ floor.normal_array - floor.offset_mm))
        gates.append(Gate("footboard_off_mm", abs(height), _MOST_FLOOR_MM, f"{name} laser", changed))
    if part in ("right-laser", "left-laser"):
        scatter = 1.4826 * float(np.median(np.abs(fit.residual_px[fit.rows.laser >= 0])))
        shiny = "Check that the laser is focused and that nothing shines."
        gates.append(Gate("stripe_scatter_px", scatter, limits.stripe_px, part, shiny))
        few = "More placements are needed, at other heights and headings."
        gates.append(Gate("expected_error_mm", _expected_mm(fit), _MOST_EXPECTED_MM, part, few))
    return gates


def _expected_mm(fit: Fit) -> float:
    """What the doubt of a sheet's own three unknowns causes at the edge of the working volume, across the sheet."""
    turn, lean, offset = standard_deviations(fit).values()
    return float(np.hypot(offset, _REACH_MM * np.hypot(turn, lean)))


def moved_mm(before: Calibration, after: Calibration, part: Part) -> float:
    """How far a renewed sheet lies from the old one: largest distance in the working volume; NaN for other parts."""
    if part not in ("right-laser", "left-laser"):
        return float("nan")
    name = LASER_NAMES[0] if part == "right-laser" else LASER_NAMES[1]
    pixels = working_pixels(before, name)
    off = volume_points(after, name, pixels) - volume_points(before, name, pixels)
    return float(np.linalg.norm(off, axis=1).max())
