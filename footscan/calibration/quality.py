"""What a calibration says of itself: the `[quality]` table of calibration.toml, and the same in sentences."""

import hashlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from footscan.calibration.calibrate import Calibrated
from footscan.calibration.gates import placement_corners
from footscan.calibration.residuals import GROUP_NAMES
from footscan.calibration.uncertainty import error_shares_mm, expected_error_mm, standard_deviations
from footscan.config import Board
from footscan.coordinates import LASER_NAMES

SCALE_VERIFIED = "verified: lengths of the board were measured with a calliper"
SCALE_UNVERIFIED = (
    "scale not verified: every length rests on the nominal size of the print; measure the board with a calliper in "
    "both directions and calibrate with both lengths, or check a gauge block or ball bar with footscan accept"
)

_IN_WORDS = {
    "focal_length_mm": "the focal length",
    "principal_point_y_px": "the lens centre across the rows",
    "principal_point_z_px": "the lens centre along the rows",
    "k1_per_mm2": "the lens distortion (K1)",
    "k2_per_mm4": "the lens distortion (K2)",
    "phi_rad": "the camera's direction (phi)",
    "sigma_rad": "the camera's direction (sigma)",
    "t_x_mm": "the camera's place (t_x)",
    "t_y_mm": "the camera's place (t_y)",
    "t_z_mm": "the camera's place (t_z)",
    "right_azimuth_rad": "the right laser's direction",
    "right_lean_rad": "the right laser's lean",
    "right_offset_mm": "the right laser's distance from the axis",
    "left_azimuth_rad": "the left laser's direction",
    "left_lean_rad": "the left laser's lean",
    "left_offset_mm": "the left laser's distance from the axis",
    "floor_slope_x": "the footboard's slope (x)",
    "floor_slope_y": "the footboard's slope (y)",
    "eccentricity_cos_rad": "the encoder's eccentricity",
    "eccentricity_sin_rad": "the encoder's eccentricity",
    "latency_s": "how late frames are stamped",
}


def quality_table(result: Calibrated, recording_sha256: str) -> dict[str, Any]:
    """Plain values for `[quality]`: residuals, views, hold-out figures, standard deviations, scale, gates."""
    fit, names = result.joint.fit, result.intake.placement_names
    corners = result.joint.sightings.corners
    views = {name: len(np.unique(corners.frame[corners.placement == p])) for p, name in enumerate(names)}
    return {
        "recording_sha256": recording_sha256,
        "scale_verified": result.intake.board.measured,
        "scale": scale_sentence(result.intake.board),
        "placements": list(names),
        "placements_without_board": list(result.intake.without_board),
        "views": views,
        "corners": len(corners),
        "stripe_places": len(result.joint.sightings.stripes),
        "rejected_frames": dict(result.intake.rejected),
        "residual_px": {
            name: _round(fit.scale_px[k]) for k, name in enumerate(GROUP_NAMES) if np.any(fit.rows.group == k)
        },
        "placement_corner_rms_px": {name: _round(placement_corners(fit, p)[0]) for p, name in enumerate(names)},
        "expected_error_mm": {name: _round(np.sqrt(np.mean(e**2))) for name, e in expected_error_mm(fit).items()},
        "standard_deviation": {name: _round(value) for name, value in standard_deviations(fit).items()},
        "standard_deviation_mm": {name: _round(value) for name, value in error_shares_mm(fit).items()},
        "holdout": _holdout_table(result),
        "board": {
            "unequal_scale": _round(result.shape.unequal),
            "largest_sag_mm": _round(result.shape.sag_mm.max()),
        },
        "gates": {gate.name + (f" ({gate.where})" if gate.where else ""): _round(gate.value) for gate in result.gates},
        "decisions": list(result.joint.decisions),
        "seconds": result.seconds,
    }


def scale_sentence(board: Board) -> str:
    """Whether the scale of everything is known, and what to do if it is not."""
    return SCALE_VERIFIED if board.measured else SCALE_UNVERIFIED


def _holdout_table(result: Calibrated) -> dict[str, Any]:
    return {
        result.intake.placement_names[h.placement]: {
            "corner_rms_px": _round(h.corner_rms_px),
            **{f"{name}_mm": _round(x) for name, x in zip(LASER_NAMES, h.sheet_mm, strict=True) if np.isfinite(x)},
        }
        for h in result.holdouts
    }


def _round(value: float | np.floating[Any]) -> float:
    return float(f"{float(value):.4g}")


def recording_sha256(folder: Path) -> str:
    """sha256 over a recording's frames, CSV and TOML files in name order."""
    digest = hashlib.sha256()
    for path in _in_name_order(folder):
        digest.update(path.relative_to(folder).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _in_name_order(folder: Path) -> Iterable[Path]:
    kinds = (".png", ".csv", ".toml")
    found = [path for path in folder.rglob("*") if path.suffix in kinds and not path.name.startswith("truth")]
    return sorted(found, key=lambda path: path.relative_to(folder).as_posix())


def quality_lines(result: Calibrated) -> list[str]:
    """What the command line says of an accepted calibration."""
    fit = result.joint.fit
    errors = {name: np.sqrt(np.mean(e**2)) for name, e in expected_error_mm(fit).items()}
    corners, stripes = result.joint.sightings.corners, result.joint.sightings.stripes
    shares = sorted(error_shares_mm(fit).items(), key=lambda item: -item[1])[:3]
    worst = max(result.holdouts, key=lambda h: h.corner_rms_px)
    return [
        f"{len(result.intake.placement_names)} placements, {len(np.unique(corners.frame))} views of the board, "
        f"{len(corners)} corners (scatter {fit.scale_px[0]:.3f} px), {len(stripes)} stripe places",
        f"Expected error in the working volume: right {errors['right']:.3f} mm, left {errors['left']:.3f} mm RMS; "
        f"most of it from {', '.join(dict.fromkeys(_IN_WORDS.get(name, name) for name, _ in shares))}",
        f"Placements never seen by the fit: corners within {worst.corner_rms_px:.3f} px RMS (worst: "
        f"{result.intake.placement_names[worst.placement]}), sheets within "
        f"{max(h.worst_sheet_mm for h in result.holdouts):.3f} mm",
        *(f"Note: {sentence}" for sentence in result.joint.decisions),
        *(f"Note: no board was found in placement {name}; it was left out" for name in result.intake.without_board),
        f"Scale: {scale_sentence(result.intake.board)}",
    ]
