"""Acceptance: a scan of a test body, its figures for both lasers and each apart, against stated limits."""

import json
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

import numpy as np

import footscan
from footscan.calibration.artefact import (
    FormFigures,
    Sphere,
    find_plane,
    find_sphere,
    plane_figures,
    sphere_figures,
)
from footscan.config.artefact_file import Artefact, load_artefact
from footscan.config.toml_file import write_whole
from footscan.coordinates import LASER_NAMES, Floats
from footscan.errors import EmptyScanError, QualityError, RecordingError
from footscan.geometry.plane import fit_plane
from footscan.optics.calibration import Calibration, fingerprint
from footscan.optics.tables import build_tables
from footscan.scanning.cleaning import smooth_skin
from footscan.scanning.cloud import Cloud, cloud_from_matrix
from footscan.scanning.footboard import BOARD_MARGIN_MM, height_above
from footscan.scanning.recording import Recording, open_recording
from footscan.scanning.sweep import Progress, SweepSettings, sweep_frames
from footscan.workflow.acceptance_page import draw_page
from footscan.workflow.acceptance_words import sheet_lines
from footscan.workflow.process import check_machine

Which = Literal["both", "right", "left"]
_FEWEST = 300


@dataclass(frozen=True)
class AcceptanceLimits:
    """What is allowed; internal limits, not those of a standard.

    Attributes:
        size_mm: |PS|, error of a sphere's diameter.
        spacing_mm_per_300: |SD| per 300 mm of spacing.
        flatness_d95_mm: D95 width about a plane.
        form_d95_mm: D95 width about a sphere.
        lasers_apart_mm: Distance between what both lasers make of the same body.
        least_coverage_deg: Half angle of the cap of a sphere that must be seen.
    """

    size_mm: float = 0.3
    spacing_mm_per_300: float = 0.5
    flatness_d95_mm: float = 0.6
    form_d95_mm: float = 0.8
    lasers_apart_mm: float = 0.3
    least_coverage_deg: float = 60.0


USUAL_LIMITS = AcceptanceLimits()


@dataclass(frozen=True)
class BodyPart:
    """One sphere or plane: its points, the laser of each, residuals, and figures for both lasers and each apart."""

    name: str
    xyz_world: Floats
    residual_mm: Floats
    laser: Floats
    figures: dict[str, FormFigures]
    centres: dict[str, Floats]


@dataclass(frozen=True)
class Acceptance:
    """An acceptance test: what of, its figures, and which limits they break."""

    of_what: str
    artefact: Artefact
    parts: list[BodyPart]
    spacing_error_mm: dict[str, float]
    lasers_apart_mm: float | None
    broken: list[str]
    report: dict[str, Any]


def accept_recording(
    folder: Path,
    calibration: Calibration,
    artefact_file: Path | None = None,
    limits: AcceptanceLimits = USUAL_LIMITS,
    progress: Progress = lambda done, total: None,
) -> Acceptance:
    """Measure a test body with a calibration.

    Raises:
        ConfigError: artefact.toml is wrong.
        RecordingError: No scan recording, or no artefact.toml.
        EmptyScanError: The body was not found.
    """
    recording = open_recording(folder)
    artefact = load_artefact(_artefact_path(folder, artefact_file))
    if recording.info.kind != "scan":
        raise RecordingError(
            f"{folder} is a {recording.info.kind} recording; acceptance needs a scan of the test body."
        )
    cloud = _body_points(recording, calibration, progress)
    parts = _plane_part(cloud) if artefact.kind == "plane" else _sphere_parts(cloud, artefact)
    spacing = _spacing_errors(parts, artefact)
    apart = _lasers_apart(parts)
    broken = _broken(parts, artefact, spacing, apart, limits)
    simulated = (folder / "truth-calibration.toml").is_file() or recording.info.notes.startswith("simulated")
    name = f" {artefact.name}" if artefact.name else ""
    of_what = f"{'simulated' if simulated else 'real'} {artefact.kind}{name}"
    made = Acceptance(of_what, artefact, parts, spacing, apart, broken, {})
    return replace(made, report=_report(made, recording, calibration, limits))


def save_acceptance(acceptance: Acceptance, folder: Path) -> None:
    """Write acceptance.json and acceptance.pdf; a test that fails is written too, then refused.

    Raises:
        StorageError: The folder cannot be written.
        QualityError: A limit is broken.
    """
    write_whole(folder / "acceptance.json", (json.dumps(acceptance.report, indent=1) + "\n").encode())
    title = f"Acceptance of machine {acceptance.report['machine_id'] or 'without an id'}"
    write_whole(
        folder / "acceptance.pdf", draw_page(title, acceptance.broken, acceptance.parts, sheet_lines(acceptance))
    )
    if acceptance.broken:
        raise QualityError(f"not accepted ({acceptance.of_what}): {'; '.join(acceptance.broken)}.")


def _artefact_path(folder: Path, given: Path | None) -> Path:
    path = given if given is not None else folder / "artefact.toml"
    if not path.is_file():
        raise RecordingError(
            f"{path} is missing: say with --artefact what was scanned (kind, diameters_mm, spacing_mm)."
        )
    return path


def _body_points(recording: Recording, calibration: Calibration, progress: Progress) -> Cloud:
    """All points above the footboard, as a scan of a foot would keep them."""
    check_machine(recording, calibration)
    tables = build_tables(calibration)
    sweep = sweep_frames(recording, calibration, tables, SweepSettings(), progress)
    cloud = cloud_from_matrix(sweep.matrix, tables)
    above = cloud.where(height_above(calibration.floor, cloud.xyz_world) > BOARD_MARGIN_MM)
    if len(above) < _FEWEST:
        raise EmptyScanError(f"only {len(above)} points lie above the footboard; was the test body on it, and lit?")
    return smooth_skin(above)[0]


def _masks(cloud: Cloud) -> dict[str, np.ndarray]:
    every = {"both": np.ones(len(cloud), dtype=bool)}
    return every | {name: cloud.laser == code for code, name in enumerate(LASER_NAMES)}


def _sphere_parts(cloud: Cloud, artefact: Artefact) -> list[BodyPart]:
    rest, parts = cloud, []
    for number, diameter_mm in enumerate(artefact.diameters_mm, start=1):
        sphere, on = find_sphere(rest.xyz_world, diameter_mm)
        parts.append(_sphere_part(f"sphere {number}", rest.where(on), sphere, diameter_mm))
        far = np.linalg.norm(rest.xyz_world - sphere.centre, axis=1) > 0.5 * sphere.diameter_mm + 2.0
        rest = rest.where(far)
    return parts


def _sphere_part(name: str, own: Cloud, sphere: Sphere, calibrated_mm: float) -> BodyPart:
    figures: dict[str, FormFigures] = {}
    centres: dict[str, Floats] = {}
    for which, mask in _masks(own).items():
        if np.count_nonzero(mask) >= _FEWEST:
            fitted, figures[which] = sphere_figures(own.xyz_world[mask], calibrated_mm, sphere.centre)
            centres[which] = fitted.centre
    residual = np.linalg.norm(own.xyz_world - sphere.centre, axis=1) - 0.5 * sphere.diameter_mm
    return BodyPart(name, own.xyz_world, residual, own.laser.astype(np.float64), figures, centres)


def _plane_part(cloud: Cloud) -> list[BodyPart]:
    own = cloud.where(find_plane(cloud.xyz_world))
    masks = {which: mask for which, mask in _masks(own).items() if np.count_nonzero(mask) >= _FEWEST}
    figures = {which: plane_figures(own.xyz_world[mask]) for which, mask in masks.items()}
    plane = fit_plane(own.xyz_world)
    middle = own.xyz_world.mean(axis=0)
    heights = {which: float(np.mean(plane.distance_mm(own.xyz_world[mask]))) for which, mask in masks.items()}
    centres = {which: middle + height * plane.normal_array for which, height in heights.items()}
    residual = plane.distance_mm(own.xyz_world)
    return [BodyPart("plane", own.xyz_world, residual, own.laser.astype(np.float64), figures, centres)]


def _spacing_errors(parts: list[BodyPart], artefact: Artefact) -> dict[str, float]:
    """SD per laser: measured minus calibrated distance of the centres of spheres fitted with free radius."""
    if artefact.spacing_mm is None:
        return {}
    one, two = parts
    both = [which for which in one.centres if which in two.centres]
    return {
        which: float(np.linalg.norm(one.centres[which] - two.centres[which])) - artefact.spacing_mm for which in both
    }


def _lasers_apart(parts: list[BodyPart]) -> float | None:
    """Largest distance between what the two lasers take for the middle of one body."""
    apart = [
        float(np.linalg.norm(part.centres["right"] - part.centres["left"]))
        for part in parts
        if "right" in part.centres and "left" in part.centres
    ]
    return max(apart, default=None)


def _broken(
    parts: list[BodyPart],
    artefact: Artefact,
    spacing: dict[str, float],
    apart: float | None,
    limits: AcceptanceLimits,
) -> list[str]:
    form_limit = limits.flatness_d95_mm if artefact.kind == "plane" else limits.form_d95_mm
    broken: list[str] = []
    for part in parts:
        broken += [
            f"the {name} laser sees fewer than {_FEWEST} points of {part.name}: is it on, and the body in view?"
            for name in LASER_NAMES
            if name not in part.figures
        ]
        for which, figures in part.figures.items():
            where = f"{part.name}, {which}"
            if figures.d95_mm > form_limit:
                broken.append(f"D95 {figures.d95_mm:.2f} mm ({where}), at most {form_limit} mm")
            if abs(figures.size_error_mm) > limits.size_mm:
                broken.append(f"PS {figures.size_error_mm:+.2f} mm ({where}), at most {limits.size_mm} mm")
            if figures.coverage_deg < limits.least_coverage_deg:
                broken.append(f"cap of {figures.coverage_deg:.0f} degrees seen ({where}), at least 60: place it freer")
    most = limits.spacing_mm_per_300 * (artefact.spacing_mm or 0.0) / 300.0
    broken += [f"SD {x:+.2f} mm ({which}), at most {most:.2f} mm" for which, x in spacing.items() if abs(x) > most]
    if apart is not None and apart > limits.lasers_apart_mm:
        broken.append(f"the lasers see it {apart:.2f} mm apart, at most {limits.lasers_apart_mm} mm: recalibrate")
    return broken


def _report(
    acceptance: Acceptance, recording: Recording, calibration: Calibration, limits: AcceptanceLimits
) -> dict[str, Any]:
    return {
        "format": "footscan-acceptance/1",
        "of_what": acceptance.of_what,
        "accepted": not acceptance.broken,
        "broken": acceptance.broken,
        "artefact": asdict(acceptance.artefact),
        "parts": {part.name: {w: _plain(f) for w, f in part.figures.items()} for part in acceptance.parts},
        "spacing_error_mm": {which: round(x, 4) for which, x in acceptance.spacing_error_mm.items()},
        "lasers_apart_mm": None if acceptance.lasers_apart_mm is None else round(acceptance.lasers_apart_mm, 4),
        "limits": asdict(limits),
        "points": "above the footboard, off-surface points removed as in every scan; spheres fitted with free radius",
        "recording": str(recording.folder),
        "machine_id": calibration.machine_id,
        "calibration_sha256": fingerprint(calibration),
        "made_at": datetime.now(UTC).isoformat(timespec="seconds"),
        "version": footscan.__version__,
    }


def _plain(figures: FormFigures) -> dict[str, float | None]:
    return {key: None if np.isnan(value) else round(value, 4) for key, value in asdict(figures).items()}
