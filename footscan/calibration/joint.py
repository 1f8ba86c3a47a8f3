"""From what a recording shows to a machine: corners alone, then the sheets, then everything at once."""

from dataclasses import dataclass, replace

import numpy as np

from footscan.calibration.estimate import CAMERA, ENCODER, Estimate
from footscan.calibration.first_guess import guess_estimate
from footscan.calibration.intake import Intake, Progress
from footscan.calibration.misfit import head_angles, stripe_points_head
from footscan.calibration.sightings import NO_STRIPES, Sightings, StripePoints
from footscan.calibration.solve import EVERYTHING, Fit, Unknowns, fit_estimate
from footscan.calibration.stripes import assign_stripes, find_stripes
from footscan.calibration.uncertainty import standard_deviations
from footscan.coordinates import LASER_NAMES, Floats, Ints
from footscan.errors import PoorFitError
from footscan.geometry.plane import fit_plane
from footscan.optics import LightPlane
from footscan.optics.calibration import Calibration

CORNERS_ONLY = Unknowns((*CAMERA, "phi_rad", "sigma_rad", "t_x_mm", "t_y_mm", "latency_s"))
"""Without the footboard the height of W's origin is unknown: t_z stays."""
_WITHOUT_K2 = tuple(name for name in EVERYTHING.machine if name != "k2_per_mm4")
_TRIALS = 400
_INLIER_MM = 1.0
_FEWEST_STRIPE_POINTS = 60
_WORTH_KEEPING = 3.0


@dataclass(frozen=True)
class Choices:
    """What the technician may ask for.

    Attributes:
        horizontal_scale: Estimate s_y too; else it stays as designed.
        eccentricity: Estimate the encoder's eccentricity where the data show it.
    """

    horizontal_scale: bool = False
    eccentricity: bool = True


USUAL = Choices()


@dataclass(frozen=True)
class JointFit:
    """The corners-only fit, the joint one, and what was left out of it and why."""

    intake: Intake
    sightings: Sightings
    corners_fit: Fit
    fit: Fit
    decisions: tuple[str, ...]


def fit_corners(intake: Intake, start: Estimate | None = None) -> Fit:
    """Camera, pose, latency and boards from corners alone."""
    sightings = Sightings(intake.times, intake.corners, NO_STRIPES, intake.placement_names)
    return fit_estimate(start or guess_estimate(intake), sightings, CORNERS_ONLY)


def fit_jointly(
    intake: Intake,
    corners_fit: Fit,
    choices: Choices = USUAL,
    progress: Progress = lambda done, total: None,
) -> JointFit:
    """Everything at once, from the corners-only fit and the stripes.

    Raises:
        PoorFitError: A laser left too few stripe places on boards or footboard to fix its sheet.
    """
    raw = find_stripes(intake, progress)
    estimate = corners_fit.estimate
    stripes = assign_stripes(raw, estimate, intake)
    _enough(stripes)
    sightings = Sightings(intake.times, intake.corners, stripes, intake.placement_names)
    start = replace(estimate, machine=_guess_sheets(estimate, sightings))
    fit, decisions = _fit_and_choose(start, sightings, choices)
    return JointFit(intake, sightings, corners_fit, fit, decisions)


def _enough(stripes: StripePoints) -> None:
    for code, name in enumerate(LASER_NAMES):
        own = stripes.laser == code
        for where, count in (
            ("boards", int(np.count_nonzero(own & (stripes.placement >= 0)))),
            ("the bare footboard", int(np.count_nonzero(own & (stripes.placement < 0)))),
        ):
            if count < _FEWEST_STRIPE_POINTS:
                raise PoorFitError(
                    f"the {name} laser shows {count} stripe places on {where}, at least {_FEWEST_STRIPE_POINTS} are "
                    "needed. Check that it is on, focused and not covered, and place boards so that it crosses them."
                )


def _guess_sheets(estimate: Estimate, sightings: Sightings) -> Calibration:
    """Each sheet as the plane that most of its stripe places agree on, whatever the design says."""
    xyz_head = stripe_points_head(estimate, sightings.stripes, head_angles(estimate, sightings))
    sheets = [
        _consensus_sheet(
            sheet,
            xyz_head[sightings.stripes.laser == code],
            sightings.stripes.placement[sightings.stripes.laser == code],
        )
        for code, sheet in enumerate(estimate.machine.lasers)
    ]
    return replace(estimate.machine, lasers=(sheets[0], sheets[1]))


def _consensus_sheet(sheet: LightPlane, xyz_head: Floats, placement: Ints) -> LightPlane:
    """The plane through three random places that has most of the others near; half of the trials start on boards."""
    random = np.random.default_rng(1)
    board, floor = np.flatnonzero(placement >= 0), np.flatnonzero(placement < 0)
    share = 1.0 / np.bincount((placement >= 0).astype(np.int64), minlength=2)
    worth = share[(placement >= 0).astype(np.int64)]
    best, most = None, -1.0
    for _ in range(_TRIALS):
        chosen = np.concatenate([random.choice(board, 2), random.choice(floor, 1)])
        one, two, three = xyz_head[chosen]
        normal = np.cross(two - one, three - one)
        length = float(np.linalg.norm(normal))
        if length < 1.0:
            continue
        distance = np.abs((xyz_head - one) @ (normal / length))
        count = float(worth[distance < _INLIER_MM].sum())
        if count > most:
            best, most = distance < _INLIER_MM, count
    assert best is not None
    plane = fit_plane(xyz_head[best])
    # both normals of a plane are right; take the one nearer to the design's
    sign = 1.0 if float(plane.normal_array @ np.array(sheet.normal)) > 0.0 else -1.0
    n = sign * plane.normal_array
    return LightPlane(sheet.name, (float(n[0]), float(n[1]), float(n[2])), sign * plane.offset_mm)


def _fit_and_choose(start: Estimate, sightings: Sightings, choices: Choices) -> tuple[Fit, tuple[str, ...]]:
    """Fit, then keep K2, eccentricity and horizontal scale only where the data show them."""
    asked = ("horizontal_scale",) if choices.horizontal_scale else ()
    fit = fit_estimate(start, sightings, Unknowns((*EVERYTHING.machine, *asked)))
    decisions: list[str] = []
    if not _k2_observable(fit):
        decisions.append("K2 is not observable in these pictures and stays as designed")
        kept = replace(fit.estimate.machine.camera, k2_per_mm4=start.machine.camera.k2_per_mm4)
        again = replace(fit.estimate, machine=replace(fit.estimate.machine, camera=kept))
        fit = fit_estimate(again, sightings, Unknowns((*_WITHOUT_K2, *asked)))
    if asked:
        decisions.append("horizontal scale estimated as asked for")
    if choices.eccentricity:
        turned = fit_estimate(fit.estimate, sightings, Unknowns((*fit.unknowns.machine, *ENCODER)))
        if _eccentricity_shown(turned):
            decisions.append("eccentricity of the encoder disc estimated")
            fit = turned
        else:
            decisions.append("no eccentricity of the encoder disc can be seen")
    return fit, tuple(decisions)


def _k2_observable(fit: Fit) -> bool:
    """Whether K2 is known better than what it shifts: at the farthest corner seen, to less than 0.1 px."""
    camera = fit.estimate.machine.camera
    deviation = standard_deviations(fit)["k2_per_mm4"]
    half_y = 0.5 * camera.width_px * camera.horizontal_scale * camera.pixel_pitch_y_mm
    half_z = 0.5 * camera.height_px * camera.pixel_pitch_z_mm
    rho = float(np.hypot(half_y, half_z))
    return deviation * rho**5 < 0.3 * camera.pixel_pitch_y_mm


def _eccentricity_shown(fit: Fit) -> bool:
    deviation = standard_deviations(fit)
    along = fit.estimate.machine.encoder
    parts = np.array([along.eccentricity_rad * np.cos(along.eccentricity_phase_rad)])
    parts = np.append(parts, along.eccentricity_rad * np.sin(along.eccentricity_phase_rad))
    scale = np.array([deviation[name] for name in ENCODER])
    return bool(np.hypot(*(parts / scale)) > _WORTH_KEEPING)
