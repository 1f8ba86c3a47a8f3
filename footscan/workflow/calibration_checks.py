"""Between calibrations: align lasers before one, re-check the one in force, renew one part of it.

```
align_recording(folder)                      -> Alignment   where the sheets are and what to turn
recheck_recording(folder, calibration)       -> Rechecked   does the calibration still hold? one placement, two minutes
renew_recording(folder, parent, out, part)   -> Renewed     one part anew, the rest must still hold
daily_check(folder, calibration, reference)  -> DailyCheck  a test body, thirty seconds
```

All take a folder with a recording and a progress callback `(done, total)`; nothing here asks or prints.
"""

from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from footscan.calibration.alignment import Alignment, measure_alignment
from footscan.calibration.intake import Intake, Progress, take_in
from footscan.calibration.one_placement import Recheck, recheck
from footscan.calibration.quality import recording_sha256
from footscan.calibration.renew import Part, Renewed, renew
from footscan.calibration.sightings import StripePoints
from footscan.calibration.stripes import find_stripes
from footscan.config import Board, calibration_toml, load_calibration_record
from footscan.config.toml_file import write_whole
from footscan.errors import RecordingError
from footscan.optics.calibration import Calibration, fingerprint
from footscan.optics.table_store import tables_bytes
from footscan.optics.tables import build_tables
from footscan.scanning.recording import open_recording
from footscan.workflow.accept import Acceptance, accept_recording
from footscan.workflow.calibrate import tables_path
from footscan.workflow.calibration_log import keep_in_force, log_event, machine_name, refuse_outdated
from footscan.workflow.process import check_machine


@dataclass(frozen=True)
class RecheckLimits:
    """What is allowed of a calibration that still holds; noise alone gives about a fifth of each."""

    corner_px: float = 0.12
    sheet_mm: float = 0.1
    turned_mm: float = 0.15
    floor_mm: float = 0.2
    floor_lean_deg: float = 0.08


RECHECK_LIMITS = RecheckLimits()


def _quiet(done: int, total: int) -> None:
    """Nobody looks."""


def _seen(folder: Path, board: Board | None, progress: Progress) -> tuple[Intake, StripePoints]:
    intake = take_in(open_recording(folder), board, progress, fewest=1)
    return intake, find_stripes(intake, progress)


def align_recording(
    folder: Path, machine: Calibration | None = None, board: Board | None = None, progress: Progress = _quiet
) -> Alignment:
    """The alignment view of a recording with one placement (or more) and the bare footboard.

    Args:
        folder: The recording.
        machine: Where to start; default: the design in its scanner.toml.
        board: With measured lengths; default: the recording's own.
        progress: Called with frames done and in all.

    Raises:
        RecordingError: No board was found; why is said.
        PoorFitError: A laser is not seen.
    """
    intake, raw = _seen(folder, board, progress)
    return measure_alignment(intake, raw, machine)


@dataclass(frozen=True)
class Rechecked:
    """What a re-check found; the calibration holds if nothing is broken."""

    recheck: Recheck
    broken: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether the calibration may go on being used."""
        return not self.broken


def recheck_recording(
    folder: Path,
    calibration: Calibration,
    board: Board | None = None,
    limits: RecheckLimits = RECHECK_LIMITS,
    progress: Progress = _quiet,
) -> Rechecked:
    """Hold a calibration against one placement of the board and the bare footboard.

    Raises:
        RecordingError: No board was found; why is said.
        MachineMismatchError: The recording is of another machine.
        PoorFitError: A laser is not seen.
    """
    check_machine(open_recording(folder), calibration)
    intake, raw = _seen(folder, board, progress)
    found = recheck(intake, raw, calibration)
    return Rechecked(found, tuple(broken_limits(found, limits)))


def broken_limits(found: Recheck, limits: RecheckLimits) -> list[str]:
    """Which limits a re-check breaks, by the part of the machine that is to blame."""
    broken: list[str] = []
    if found.corner_rms_px > limits.corner_px:
        broken.append(
            f"camera or axis: corners lie {found.corner_rms_px:.2f} px off, at most {limits.corner_px:g}: the lens or "
            "the camera was knocked"
        )
    for name, off in found.sheet_mm.items():
        if abs(off) > limits.sheet_mm or found.sheet_turned_mm[name] > limits.turned_mm:
            broken.append(
                f"{name} laser: its sheet lies {off:+.2f} mm off the board, at most {limits.sheet_mm:g}, and is turned "
                f"by {found.sheet_turned_mm[name]:.2f} mm over 100 mm, at most {limits.turned_mm:g}"
            )
    for name, height in found.floor_mm.items():
        if abs(height) > limits.floor_mm:
            broken.append(f"footboard: the {name} laser sees it {height:+.2f} mm off, at most {limits.floor_mm:g}")
    if found.floor_lean_deg > limits.floor_lean_deg:
        broken.append(f"footboard: it leans by {found.floor_lean_deg:.2f} degrees, at most {limits.floor_lean_deg:g}")
    return broken


def recheck_lines(found: Rechecked) -> list[str]:
    """For the screen."""
    seen = found.recheck
    sheets = ", ".join(f"{n} {mm:+.3f} mm (turned {seen.sheet_turned_mm[n]:.3f})" for n, mm in seen.sheet_mm.items())
    floor = ", ".join(f"{name} {mm:+.3f} mm" for name, mm in seen.floor_mm.items())
    return [
        f"Corners {seen.corner_rms_px:.3f} px RMS; sheets on the board: {sheets}",
        f"Bare footboard: {floor}, leans {seen.floor_lean_deg:.3f} degrees",
        "The calibration holds." if found.holds else "The calibration does NOT hold: " + "; ".join(found.broken) + ".",
    ]


def renew_recording(
    folder: Path,
    parent_file: Path,
    out: Path,
    part: Part,
    board: Board | None = None,
    data: Path | None = None,
    progress: Progress = _quiet,
) -> Renewed:
    """Renew one part of a calibration from a recording and write the result; a refusal changes no file.

    Raises:
        ConfigError: The parent is no calibration.
        RecordingError: No board was found; why is said.
        MachineMismatchError: The recording is of another machine.
        InputError: It is to come into force, and was recorded before an intervention.
        PoorFitError: More than this part has changed; the calibration in force stays.
        StorageError: A file could not be written.
    """
    parent = load_calibration_record(parent_file)
    recording = open_recording(folder)
    check_machine(recording, parent.calibration)
    if data is not None:
        refuse_outdated(data, machine_name(parent.calibration), recording.info.created)
    intake, raw = _seen(folder, board, progress)
    now = datetime.now(UTC).isoformat(timespec="seconds")
    renewed = renew(intake, raw, parent.calibration, part)
    calibration = replace(renewed.calibration, created=now)
    quality = parent.quality | {
        "recorded_at": recording.info.created,
        "renewed": _renewed_table(renewed, folder, now),
    }
    history = {
        "renewed": part,
        "parents": [fingerprint(parent.calibration), *parent.history.get("parents", [])],
        "parent_created": parent.calibration.created,
    }
    write_whole(tables_path(out), tables_bytes(build_tables(calibration)))
    write_whole(out, calibration_toml(calibration, quality, history))
    if data is not None:
        keep_in_force(data, calibration, quality, history)
    return replace(renewed, calibration=calibration)


def _renewed_table(renewed: Renewed, folder: Path, now: str) -> dict[str, Any]:
    gates = {
        gate.name + (f" ({gate.where})" if gate.where else ""): float(f"{gate.value:.4g}") for gate in renewed.gates
    }
    return {"part": renewed.part, "recording_sha256": recording_sha256(folder), "made_at": now, "gates": gates}


DAILY_D95_MM, DAILY_SIZE_MM, DAILY_APART_MM = 0.1, 0.15, 0.15
"""How far D95, size and the lasers' distance of the test body may be from the first check after calibrating."""


@dataclass(frozen=True)
class DailyCheck:
    """A test body today, against the first time after the calibration (`reference`, None: this is the first)."""

    figures: dict[str, float]
    reference: dict[str, float] | None
    broken: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether the calibration may go on being used."""
        return not self.broken


def daily_check(
    folder: Path,
    calibration: Calibration,
    reference: dict[str, float] | None = None,
    artefact: Path | None = None,
    progress: Progress = _quiet,
) -> DailyCheck:
    """Measure a test body and compare it with its size, and with the first check after the calibration.

    Raises:
        RecordingError: No scan recording, or no artefact.toml.
        EmptyScanError: The body was not found.
    """
    accepted = accept_recording(folder, calibration, artefact, progress=progress)
    figures = _daily_figures(accepted)
    broken = list(accepted.broken)
    for name, most in (("d95_mm", DAILY_D95_MM), ("size_error_mm", DAILY_SIZE_MM), ("lasers_apart_mm", DAILY_APART_MM)):
        if reference is not None and name in reference and name in figures:
            change = figures[name] - reference[name]
            if abs(change) > most:
                broken.append(
                    f"{name.removesuffix('_mm').replace('_', ' ')} has changed by {change:+.2f} mm, at most {most:g}"
                )
    return DailyCheck(figures, reference, tuple(broken))


def _daily_figures(accepted: Acceptance) -> dict[str, float]:
    both = [part.figures["both"] for part in accepted.parts if "both" in part.figures]
    if not both:
        raise RecordingError("the test body was seen by too few points of both lasers together; place it freer.")
    figures = {"d95_mm": max(f.d95_mm for f in both)}
    sizes = [f.size_error_mm for f in both if np.isfinite(f.size_error_mm)]
    if sizes:
        figures["size_error_mm"] = max(sizes, key=abs)
    if accepted.lasers_apart_mm is not None:
        figures["lasers_apart_mm"] = accepted.lasers_apart_mm
    return {name: round(float(value), 4) for name, value in figures.items()}


def first_daily(events: list[dict[str, Any]], calibration: Calibration) -> dict[str, float] | None:
    """Figures of the first daily check under this calibration that held; None if there is none."""
    own = fingerprint(calibration)
    return next(
        (dict(e["figures"]) for e in events if e["kind"] == "daily" and e.get("sha256") == own and e.get("holds")), None
    )


def log_check(data: Path, calibration: Calibration, found: Rechecked | DailyCheck, folder: Path) -> None:
    """Note a check of the recording in a folder and its outcome in the machine's log.

    Raises:
        StorageError: The log could not be written.
    """
    content: dict[str, Any] = {"sha256": fingerprint(calibration), "holds": found.holds, "broken": list(found.broken)}
    content["recorded_at"] = open_recording(folder).info.created
    if isinstance(found, DailyCheck):
        log_event(data, machine_name(calibration), "daily", content | {"figures": found.figures})
    else:
        log_event(data, machine_name(calibration), "recheck", content)
