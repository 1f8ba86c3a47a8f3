"""Gates that can fail: what a calibration must show before it may be used, each with a reason and what to do."""

from dataclasses import dataclass

import numpy as np

from footscan.calibration.agreement import FEWEST_ON_ONE_BOARD, halves_difference_mm, sheet_disagreements_mm
from footscan.calibration.coverage import height_coverage, image_coverage
from footscan.calibration.estimate import Estimate
from footscan.calibration.gate import Gate
from footscan.calibration.holdout import HoldOut
from footscan.calibration.joint import JointFit
from footscan.calibration.sightings import FLOOR_PLACEMENT
from footscan.calibration.solve import Fit
from footscan.calibration.uncertainty import condition, expected_error_mm
from footscan.coordinates import LASER_NAMES


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
_FEWEST_LOPSIDED = 150


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
        _of_placement("placement_corners_px", rms[worst], limits.placement_corner_px, names[worst], again),
        _of_placement("placement_rejected_corners", rejected[most], limits.rejected_corners, names[most], again),
    ]


def _of_placement(name: str, value: float, limit: float, placement: str, advice: str) -> Gate:
    """A gate on one placement, which may be repeated."""
    return Gate(name, value, limit, f"placement {placement}", advice, repeat=placement)


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
    if np.count_nonzero(own) < FEWEST_ON_ONE_BOARD:
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
            more=True,
        ),
        *_expected_gates(fit, limits),
    ]


def _stripe_gates(joint: JointFit, limits: Limits) -> list[Gate]:
    fit, names = joint.fit, joint.intake.placement_names
    places = [*range(len(names)), FLOOR_PLACEMENT]
    scatter, rejected = zip(*(placement_stripes(fit, p) for p in places), strict=True)
    worst, most = int(np.argmax(scatter)), int(np.argmax(rejected))

    def gate(name: str, value: float, limit: float, k: int) -> Gate:
        if k < len(names):
            return _of_placement(name, value, limit, names[k], advice)
        return Gate(name, value, limit, "bare footboard", advice)

    advice = (
        "The stripe does not lie where this laser's sheet meets the surface: check that the labels are right, that the "
        "surface is flat and dull, and that nothing shines; repeat it."
    )
    return [
        gate("stripe_scatter_px", scatter[worst], limits.stripe_px, worst),
        gate("rejected_stripe_places", rejected[most], limits.rejected_stripes, most),
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
        _of_placement("holdout_corners_px", corner.corner_rms_px, limits.holdout_px, names[corner.placement], advice),
        _of_placement("holdout_sheet_mm", sheet.worst_sheet_mm, limits.holdout_mm, names[sheet.placement], advice),
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


def _halves_gate(joint: JointFit, limits: Limits) -> Gate:
    advice = "Two halves of the data give different sheets: a laser moved or is loose. Fix it and record again."
    off = halves_difference_mm(joint)
    worst = max(off, key=lambda name: off[name])
    return Gate("sheet_of_halves_mm", off[worst], limits.halves_mm, f"{worst} laser", advice)


def _spread_gate(estimate: Estimate, limits: Limits) -> Gate:
    """The largest angle between two boards."""
    normals = estimate.world_from_board[:, :3, 2]
    angle = np.degrees(np.arccos(np.clip(normals @ normals.T, -1.0, 1.0)))
    advice = "All placements are parallel; turn and lean the board differently in each."
    return Gate("boards_spread_deg", float(angle.max()), limits.spread_deg, "", advice, True, more=True)


def _coverage_gates(joint: JointFit, limits: Limits) -> list[Gate]:
    advice = "Place the board so that it also fills the other parts of the picture and heights up to 12 cm."
    image, heights = image_coverage(joint), {name: height_coverage(joint, name) for name in LASER_NAMES}
    low = min(LASER_NAMES, key=lambda name: heights[name])
    return [
        Gate("image_coverage", image, limits.image_coverage, "", advice, True, more=True),
        Gate("height_coverage", heights[low], limits.height_coverage, f"{low} laser", advice, True, more=True),
    ]


def _expected_gates(fit: Fit, limits: Limits) -> list[Gate]:
    advice = "More placements, spread over the volume, are needed to be surer."
    errors = expected_error_mm(fit)
    return [
        Gate(
            "expected_error_mm",
            float(np.sqrt(np.mean(error**2))),
            limits.expected_mm,
            f"{name} laser",
            advice,
            more=True,
        )
        for name, error in errors.items()
    ]
