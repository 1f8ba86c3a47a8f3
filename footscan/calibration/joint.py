"""From what a recording shows to a machine: corners alone, then the sheets, then everything at once."""

from dataclasses import dataclass, replace

import numpy as np

from footscan.calibration.estimate import CAMERA, ENCODER, Estimate
from footscan.calibration.first_guess import guess_estimate
from footscan.calibration.intake import Intake
from footscan.calibration.misfit import head_angles, stripe_points_head
from footscan.calibration.sightings import NO_STRIPES, Sightings, StripePoints
from footscan.calibration.solve import Fit, fit_estimate
from footscan.calibration.stripes import assign_stripes
from footscan.calibration.uncertainty import standard_deviations, volume_points
from footscan.calibration.unknowns import EVERYTHING, Prior, Unknowns
from footscan.coordinates import LASER_NAMES, Floats
from footscan.errors import PoorFitError
from footscan.geometry.plane import fit_plane
from footscan.optics import Camera, LightPlane
from footscan.optics.calibration import Calibration, camera_from_world

CORNERS_ONLY = Unknowns((*CAMERA, "phi_rad", "sigma_rad", "t_x_mm", "t_y_mm", "latency_s", *ENCODER))
"""Without the footboard the height of W's origin is unknown: t_z stays."""
_K2_AT_CORNER = 1e-3
"""How far K2 of a lens as bought may shift the picture's corner from its design, relative to its distance."""
_K2_SEEN = 0.7
_TRIALS = 400
_INLIER_MM = (0.5, 0.2, 0.1)
_FEWEST_STRIPE_POINTS = 60
_WORTH_KEEPING = 3.0
_LEVEL_MM = 1.0


@dataclass(frozen=True)
class Choices:
    """What the technician may ask for.

    Attributes:
        horizontal_scale: Estimate s_y too; else it stays as designed.
        eccentricity: Estimate the encoder's eccentricity; else the disc is taken as centred.
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
    raw: StripePoints,
    corners_fit: Fit,
    choices: Choices = USUAL,
) -> JointFit:
    """Everything at once, from the corners-only fit and the stripe places found in the lit frames.

    Raises:
        PoorFitError: A laser left too few stripe places on boards or footboard to fix its sheet.
    """
    stripes = assign_stripes(raw, corners_fit.estimate, intake)
    _enough(stripes)
    start = _guess_sheets(corners_fit.estimate, stripes, intake)
    stripes = assign_stripes(raw, start, intake)
    _enough(stripes)
    sightings = Sightings(intake.times, intake.corners, stripes, intake.placement_names)
    fit, decisions = _fit_and_choose(start, sightings, choices, intake.recording.scanner.camera)
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
                    "needed. Check that it is on, focused and not covered, and place boards so that it crosses them.",
                    more=where == "boards",
                )


def _guess_sheets(estimate: Estimate, stripes: StripePoints, intake: Intake) -> Estimate:
    """Each sheet as the plane that most stripe places on boards agree on, and z = 0 where the footboard then is."""
    sightings = Sightings(intake.times, intake.corners, stripes, intake.placement_names)
    theta_rad = head_angles(estimate, sightings)
    on_board = stripes.placement >= 0
    xyz_head = stripe_points_head(estimate, stripes, theta_rad)
    right, left = (
        consensus_sheet(sheet, xyz_head[on_board & (stripes.laser == code)])
        for code, sheet in enumerate(estimate.machine.lasers)
    )
    machine = replace(estimate.machine, lasers=(right, left))
    floor = stripes.kept(~on_board)
    _refuse_exchanged(machine, floor)
    heights = [
        volume_points(machine, name, floor.yz_pixel[floor.laser == code])[:, 2] for code, name in enumerate(LASER_NAMES)
    ]
    return lowered(replace(estimate, machine=machine), float(np.median(np.concatenate(heights))))


def _refuse_exchanged(machine: Calibration, floor: StripePoints) -> None:
    """Refuse footboard frames whose stripes are level only when the lasers' names are exchanged."""
    uneven = [_unevenness_mm(machine, floor, exchanged) for exchanged in (False, True)]
    if uneven[1] < _LEVEL_MM < uneven[0]:
        raise PoorFitError(
            "no calibration: the lasers are mislabelled in the frames of the bare footboard, or in most of the others: "
            "what is called right there is called left on the boards. Correct frames.csv or the wiring and "
            "record it again. The calibration in force stays."
        )


def _unevenness_mm(machine: Calibration, floor: StripePoints, exchanged: bool) -> float:
    """How far stripe places of the bare footboard are from one height, seen through their own or the other sheet."""
    names = LASER_NAMES[::-1] if exchanged else LASER_NAMES
    heights = np.concatenate(
        [volume_points(machine, name, floor.yz_pixel[floor.laser == code])[:, 2] for code, name in enumerate(names)]
    )
    return float(np.median(np.abs(heights - np.median(heights))))


def lowered(estimate: Estimate, height_mm: float) -> Estimate:
    """The same machine and boards in a W whose origin lies `height_mm` higher along the axis."""
    machine, boards = estimate.machine, estimate.world_from_board.copy()
    boards[:, 2, 3] -= height_mm
    along = camera_from_world(machine)[:3, 2] * height_mm
    t_x, t_y, t_z = (float(t) for t in np.asarray(machine.pose.translation_mm) + along)
    right, left = (replace(s, offset_mm=s.offset_mm - s.normal[2] * height_mm) for s in machine.lasers)
    machine = replace(machine, pose=replace(machine.pose, translation_mm=(t_x, t_y, t_z)), lasers=(right, left))
    return replace(estimate, machine=machine, world_from_board=boards)


def consensus_sheet(sheet: LightPlane, xyz_head: Floats) -> LightPlane:
    """The plane through three random places `(n, 3)` that has most of the others near, refined on those."""
    random = np.random.default_rng(1)
    best, most = np.ones(len(xyz_head), dtype=np.bool_), 0
    for _ in range(_TRIALS):
        one, two, three = xyz_head[random.choice(len(xyz_head), 3, replace=False)]
        normal = np.cross(two - one, three - one)
        length = float(np.linalg.norm(normal))
        if length < 1.0:
            continue
        near = np.abs((xyz_head - one) @ (normal / length)) < _INLIER_MM[0]
        if np.count_nonzero(near) > most:
            best, most = near, int(np.count_nonzero(near))
    plane = fit_plane(xyz_head[best])
    for tolerance_mm in _INLIER_MM[1:]:
        off = plane.distance_mm(xyz_head)
        near = np.abs(off - np.median(off[np.abs(off) < _INLIER_MM[0]])) < tolerance_mm
        plane = fit_plane(xyz_head[near]) if np.count_nonzero(near) >= _FEWEST_STRIPE_POINTS else plane
    # both normals of a plane are right; take the one nearer to the design's
    sign = 1.0 if float(plane.normal_array @ np.array(sheet.normal)) > 0.0 else -1.0
    n = sign * plane.normal_array
    return LightPlane(sheet.name, (float(n[0]), float(n[1]), float(n[2])), sign * plane.offset_mm)


def _fit_and_choose(
    start: Estimate, sightings: Sightings, choices: Choices, design: Camera
) -> tuple[Fit, tuple[str, ...]]:
    """Fit everything; K2 as far as the data show it, the horizontal scale if asked.

    The eccentricity is kept even where it is within its doubt: leaving it out would bias sigma and the sheets by
    three times what they are doubted.
    """
    asked = ("horizontal_scale",) if choices.horizontal_scale else ()
    turned = ENCODER if choices.eccentricity else ()
    lens = k2_prior(design)
    start = start if turned else _centred(start)
    fit = fit_estimate(start, sightings, Unknowns((*EVERYTHING.machine, *asked, *turned), priors=(lens,)))
    decisions: list[str] = []
    if standard_deviations(fit)["k2_per_mm4"] > _K2_SEEN * lens.deviation:
        decisions.append("K2 is hardly observable in these pictures and stays near its design")
    if asked:
        decisions.append("horizontal scale estimated as asked for")
    if turned and not _eccentricity_shown(fit):
        decisions.append("the eccentricity of the encoder disc is within its doubt of zero")
    return fit, tuple(decisions)


def k2_prior(design: Camera) -> Prior:
    """K2 as designed, give or take what moves the picture's corner by a thousandth of its distance.

    Holding it exactly would hide the error that this makes from the expected one; leaving it free would let it run
    where no corner was seen.
    """
    half_y = 0.5 * design.width_px * design.horizontal_scale * design.pixel_pitch_y_mm
    half_z = 0.5 * design.height_px * design.pixel_pitch_z_mm
    return Prior("k2_per_mm4", design.k2_per_mm4, _K2_AT_CORNER / float(np.hypot(half_y, half_z)) ** 4)


def _centred(estimate: Estimate) -> Estimate:
    """The same estimate with an encoder disc that sits on its centre."""
    encoder = replace(estimate.machine.encoder, eccentricity_rad=0.0, eccentricity_phase_rad=0.0)
    return replace(estimate, machine=replace(estimate.machine, encoder=encoder))


def _eccentricity_shown(fit: Fit) -> bool:
    deviation = standard_deviations(fit)
    along = fit.estimate.machine.encoder
    parts = np.array([along.eccentricity_rad * np.cos(along.eccentricity_phase_rad)])
    parts = np.append(parts, along.eccentricity_rad * np.sin(along.eccentricity_phase_rad))
    scale = np.array([deviation[name] for name in ENCODER])
    return bool(np.hypot(*(parts / scale)) > _WORTH_KEEPING)
