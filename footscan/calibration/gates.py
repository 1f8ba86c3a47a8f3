"""Gates that can fail: what a calibration must show before it may be used, each with a reason and what to do."""

from dataclasses import dataclass

import numpy as np

from footscan.calibration.estimate import Estimate
from footscan.calibration.holdout import HoldOut
from footscan.calibration.joint import JointFit
from footscan.calibration.misfit import head_angles, stripe_points_head
from footscan.calibration.sightings import FLOOR_PLACEMENT
from footscan.calibration.solve import Fit
from footscan.calibration.uncertainty import condition, expected_error_mm, volume_points, working_pixels
from footscan.coordinates import LASER_NAMES, Floats
from footscan.geometry.plane import fit_plane
from footscan.optics import Calibration
from footscan.optics.scanner import Scanner, calibration_from_design
from footscan.optics.sheet import alpha_from_sheet


@dataclass(frozen=True)
class Limits:
    """What is allowed.

    Attributes:
        corner_px: Robust scatter of all corners.
        placement_corner_px: RMS of one placement's corners, rejected ones included up to 3 px.
        rejected_corners: Share of one placement's corners that fit nothing.
        stripe_px: Robust scatter of stripe places.
        rejected_stripes: Share of one placement's stripe places that fit nothing.
        lopsided: Share of far-off stripe places on one side of the sheet minus that on the other.
        holdout_px: RMS of corners of a placement that the fit never saw.
        holdout_mm: Mean distance of a sheet from stripes of a placement that the fit never saw.
        sheets_mm: Between both sheets' idea of one board.
        halves_mm: RMS in the working volume between the sheets of two halves of the data.
        expected_mm: Expected RMS error in the working volume, per laser.
        condition: Condition number.
        spread_deg: Largest angle between two boards.
        image_coverage: Share of the picture that feet fill in which corners or stripes were seen.
        height_coverage: Share of the height of the volume that stripes on boards span.
    """

    corner_px: float = 0.15
    placement_corner_px: float = 0.25
    rejected_corners: float = 0.10
    stripe_px: float = 0.30
    rejected_stripes: float = 0.5
    lopsided: float = 0.2
    holdout_px: float = 0.25
    holdout_mm: float = 0.15
    sheets_mm: float = 0.15
    halves_mm: float = 0.12
    expected_mm: float = 0.06
    condition: float = 1e5
    spread_deg: float = 15.0
    image_coverage: float = 0.4
    height_coverage: float = 0.6


LIMITS = Limits()
_FEWEST_ON_ONE_BOARD = 30
_FEWEST_LOPSIDED = 150


@dataclass(frozen=True)
class Gate:
    """One figure against its limit.

    Attributes:
        name: What it is, with its unit.
        value: The worst one found.
        limit: The largest one allowed (the smallest where `least` holds).
        where: The placement, laser or zone of the worst one; empty where there is none.
        advice: What is wrong if it fails, and what to do.
        least: The limit is a least one.
    """

    name: str
    value: float
    limit: float
    where: str
    advice: str
    least: bool = False

    @property
    def passed(self) -> bool:
        """Whether the figure keeps its limit; NaN does not."""
        return self.value >= self.limit if self.least else self.value <= self.limit

    def sentence(self) -> str:
        """What was found, what is allowed, what to do."""
        where = f" ({self.where})" if self.where else ""
        bound = "at least" if self.least else "at most"
        return f"{self.name.replace('_', ' ')}{where}: {self.value:.3g}, {bound} {self.limit:g}. {self.advice}"


def corner_gates(fit: Fit, names: tuple[str, ...], limits: Limits = LIMITS) -> list[Gate]:
    """Gates on the corners of a fit: scatter, and the worst placement."""
    scatter = float(max(fit.scale_px[group] for group in (0, 1) if np.any(fit.rows.group == group)))
    rms, rejected = zip(*(placement_corners(fit, p) for p in range(len(names))), strict=True)
    worst, most = int(np.argmax(rms)), int(np.argmax(rejected))
    again = (
        "Repeat this placement: clean the board, check that it lies flat and firm, and keep the head still at stops."
    )
    whole = (
        "The pictures fit no machine of this design; check scanner.toml, the encoder and the lens, and record again."
    )
    return [
        Gate("corner_scatter_px", scatter if fit.settled else np.inf, limits.corner_px, "", whole),
        Gate("placement_corners_px", rms[worst], limits.placement_corner_px, f"placement {names[worst]}", again),
        Gate("placement_rejected_corners", rejected[most], limits.rejected_corners, f"placement {names[most]}", again),
    ]


def placement_corners(fit: Fit, placement: int) -> tuple[float, float]:
    """RMS (px, each residual counted up to 3 px) and share of rejected corners of one placement at its stops."""
    own = (fit.rows.placement == placement) & (fit.rows.group == 0)
    if not np.any(own):
        return np.inf, 1.0
    residual = np.minimum(np.abs(np.nan_to_num(fit.residual_px[own], nan=3.0)), 3.0)
    return float(np.sqrt(np.mean(residual**2))), float(np.mean(fit.weight[own] == 0.0))


def placement_stripes(fit: Fit, placement: int) -> tuple[float, float]:
    """Robust scatter about zero (px) and share of rejected stripe places of one placement (-1: the footboard)."""
    own = (fit.rows.placement == placement) & (fit.rows.laser >= 0)
    if np.count_nonzero(own) < _FEWEST_ON_ONE_BOARD:
        return 0.0, 0.0
    return 1.4826 * float(np.median(np.abs(fit.residual_px[own]))), float(np.mean(fit.weight[own] == 0.0))


def joint_gates(joint: JointFit, holdouts: list[HoldOut], limits: Limits = LIMITS) -> list[Gate]:
    """All gates of a joint fit, in the order in which a technician should read them."""
    fit, names = joint.fit, joint.intake.placement_names
    return [
        *corner_gates(fit, names, limits),
        *_stripe_gates(joint, limits),
        *_holdout_gates(holdouts, names, limits),
        _sheets_gate(joint, limits),
        _halves_gate(joint, limits),
        _spread_gate(fit.estimate, limits),
        *_coverage_gates(joint, limits),
        Gate(
            "condition",
            condition(fit),
            limits.condition,
            "",
            "The placements are too alike; lean and turn the board differently.",
        ),
        *_expected_gates(fit, limits),
    ]


def _stripe_gates(joint: JointFit, limits: Limits) -> list[Gate]:
    fit, names = joint.fit, joint.intake.placement_names
    places = [*range(len(names)), FLOOR_PLACEMENT]
    scatter, rejected = zip(*(placement_stripes(fit, p) for p in places), strict=True)
    worst, most = int(np.argmax(scatter)), int(np.argmax(rejected))

    def where(k: int) -> str:
        return f"placement {names[k]}" if k < len(names) else "bare footboard"

    advice = (
        "The stripe does not lie where this laser's sheet meets the surface: check that the labels are right, that the "
        "surface is flat and dull, and that nothing shines; repeat it."
    )
    return [
        Gate("stripe_scatter_px", scatter[worst], limits.stripe_px, where(worst), advice),
        Gate("rejected_stripe_places", rejected[most], limits.rejected_stripes, where(most), advice),
        _lopsided_gate(fit, limits),
    ]


def _lopsided_gate(fit: Fit, limits: Limits) -> Gate:
    """Far-off stripe places on one side of the sheet more than on the other: noise is even, reflections are not."""
    shares: dict[str, float] = {}
    for code, name in enumerate(LASER_NAMES):
        for where, on_floor in (("boards", False), ("bare footboard", True)):
            own = (fit.rows.laser == code) & ((fit.rows.placement == FLOOR_PLACEMENT) == on_floor)
            if np.count_nonzero(own) >= _FEWEST_LOPSIDED:
                ratio = fit.residual_px[own] / fit.scale_px[fit.rows.group[own]]
                shares[f"{name} laser on {where}"] = abs(float(np.mean(ratio > 2.5) - np.mean(ratio < -2.5)))
    worst = max(shares, key=lambda key: shares[key], default="")
    advice = "Many stripe places lie off on one side: something shines or covers a laser. Remove it and record again."
    return Gate("stripe_lopsided_share", shares.get(worst, 0.0), limits.lopsided, worst, advice)


def _holdout_gates(holdouts: list[HoldOut], names: tuple[str, ...], limits: Limits) -> list[Gate]:
    corner = max(holdouts, key=lambda h: h.corner_rms_px)
    sheet = max(holdouts, key=lambda h: h.worst_sheet_mm)
    advice = (
        "A fit without this placement does not predict it: the board moved, is bent, or the machine changed. Repeat it."
    )
    return [
        Gate(
            "holdout_corners_px",
            corner.corner_rms_px,
            limits.holdout_px,
            f"placement {names[corner.placement]}",
            advice,
        ),
        Gate(
            "holdout_sheet_mm", sheet.worst_sheet_mm, limits.holdout_mm, f"placement {names[sheet.placement]}", advice
        ),
    ]


def _sheets_gate(joint: JointFit, limits: Limits) -> Gate:
    """Both sheets on the same boards: the largest difference of their mean distances, right minus left."""
    advice = "The two lasers see one board at different depths; check that neither moved while recording, and repeat."
    off = sheet_disagreements_mm(joint)
    worst = max(off, key=lambda p: abs(off[p]), default=None)
    if worst is None:
        return Gate("sheets_disagree_mm", 0.0, limits.sheets_mm, "no board seen by both", advice)
    name = "bare footboard" if worst == FLOOR_PLACEMENT else f"placement {joint.intake.placement_names[worst]}"
    return Gate("sheets_disagree_mm", abs(off[worst]), limits.sheets_mm, name, advice)


def sheet_disagreements_mm(joint: JointFit) -> dict[int, float]:
    """Per placement (-1: footboard) on which both sheets left enough places: right minus left distance from it, mm."""
    fit, stripes = joint.fit, joint.sightings.stripes
    kept = fit.kept()[2 * len(joint.sightings.corners) :]
    height = _surface_distance_mm(joint)
    result: dict[int, float] = {}
    for placement in (*range(len(joint.intake.placement_names)), FLOOR_PLACEMENT):
        sides = [height[kept & (stripes.placement == placement) & (stripes.laser == code)] for code in (0, 1)]
        if min(len(side) for side in sides) >= _FEWEST_ON_ONE_BOARD:
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


def _halves_gate(joint: JointFit, limits: Limits) -> Gate:
    advice = "Two halves of the data give different sheets: a laser moved or is loose. Fix it and record again."
    off = halves_difference_mm(joint)
    worst = max(off, key=lambda name: off[name])
    return Gate("sheet_of_halves_mm", off[worst], limits.halves_mm, f"{worst} laser", advice)


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


def _spread_gate(estimate: Estimate, limits: Limits) -> Gate:
    """The largest angle between two boards."""
    normals = estimate.world_from_board[:, :3, 2]
    angle = np.degrees(np.arccos(np.clip(normals @ normals.T, -1.0, 1.0)))
    advice = "All placements are parallel; turn and lean the board differently in each."
    return Gate("boards_spread_deg", float(angle.max()), limits.spread_deg, "", advice, least=True)


def _coverage_gates(joint: JointFit, limits: Limits) -> list[Gate]:
    advice = "Place the board so that it also fills the other parts of the picture and heights up to 12 cm."
    image, heights = image_coverage(joint), {name: height_coverage(joint, name) for name in LASER_NAMES}
    low = min(LASER_NAMES, key=lambda name: heights[name])
    return [
        Gate("image_coverage", image, limits.image_coverage, "", advice, least=True),
        Gate("height_coverage", heights[low], limits.height_coverage, f"{low} laser", advice, least=True),
    ]


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


def _expected_gates(fit: Fit, limits: Limits) -> list[Gate]:
    advice = "More placements, spread over the volume, are needed to be surer."
    errors = expected_error_mm(fit)
    return [
        Gate("expected_error_mm", float(np.sqrt(np.mean(error**2))), limits.expected_mm, f"{name} laser", advice)
        for name, error in errors.items()
    ]


_OTHER_MACHINE = (
    "No workshop is so far off: scanner.toml or the frames belong to another machine, or the lens was exchanged. "
    "Correct scanner.toml and try again."
)


def design_gates(machine: Calibration, scanner: Scanner) -> list[Gate]:
    """How far the machine is from its design: further than any workshop builds means frames of another machine."""
    design = calibration_from_design(scanner)
    floor_lean_deg = float(np.degrees(np.arccos(min(1.0, machine.floor.normal[2]))))
    gates = [*camera_gates(machine, scanner), Gate("floor_lean_deg", floor_lean_deg, 1.5, "", _OTHER_MACHINE)]
    for built, planned in zip(machine.lasers, design.lasers, strict=True):
        turn = np.degrees(_apart_rad(alpha_from_sheet(built), alpha_from_sheet(planned)))
        lean = abs(np.degrees(np.arcsin(built.normal[2])))
        where = f"{built.name} laser"
        gates += [
            Gate("sheet_turned_deg", float(turn), 4.0, where, _swapped(machine, design) or _OTHER_MACHINE),
            Gate("sheet_leans_deg", float(lean), 2.0, where, _OTHER_MACHINE),
            Gate("sheet_off_axis_mm", abs(built.offset_mm), 6.0, where, _OTHER_MACHINE),
        ]
    return gates


def camera_gates(machine: Calibration, scanner: Scanner) -> list[Gate]:
    """The part of `design_gates` that corners alone show: lens, camera and how late frames are stamped."""
    design = calibration_from_design(scanner)
    own, made = machine.camera, design.camera
    shift = np.subtract(own.principal_point_px, made.principal_point_px)
    moved = np.subtract(machine.pose.translation_mm, design.pose.translation_mm)
    figures = {
        "focal_length_off_percent": (100.0 * abs(own.focal_length_mm / made.focal_length_mm - 1.0), 6.0),
        "principal_point_off_percent": (100.0 * float(np.hypot(*shift)) / made.width_px, 8.0),
        "phi_off_deg": (abs(np.degrees(machine.pose.phi_rad - design.pose.phi_rad)), 4.0),
        "sigma_off_deg": (abs(np.degrees(machine.pose.sigma_rad - design.pose.sigma_rad)), 3.0),
        "camera_off_mm": (float(np.linalg.norm(moved)), 45.0),
        "latency_s": (abs(machine.latency_s), 0.2),
    }
    return [Gate(name, float(value), limit, "", _OTHER_MACHINE) for name, (value, limit) in figures.items()]


def _swapped(machine: Calibration, design: Calibration) -> str:
    """What to say when each sheet stands where the other one should."""
    right, left = (alpha_from_sheet(sheet) for sheet in machine.lasers)
    wanted_right, wanted_left = (alpha_from_sheet(sheet) for sheet in design.lasers)
    right_is_left = _apart_rad(right, wanted_left) < _apart_rad(right, wanted_right)
    if right_is_left and _apart_rad(left, wanted_right) < _apart_rad(left, wanted_left):
        return (
            "The lasers are mislabelled: what is called right stands where the left one should, and vice versa. "
            "Exchange their outputs in the rig file and record again."
        )
    return ""


def _apart_rad(one: float, other: float) -> float:
    """Angle between two upright sheets, whichever way their normals point."""
    return float(abs((one - other + 0.5 * np.pi) % np.pi - 0.5 * np.pi))
