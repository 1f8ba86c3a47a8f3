"""`footscan calibration ...`: what is done between calibrations."""

from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from footscan.calibration.alignment import Alignment
from footscan.cli.body_rig import record_body
from footscan.cli.calibrate_rig import GuidedChoices, record_one_placement
from footscan.cli.console import STDOUT, print_json, progress_bar
from footscan.cli.rig_option import chosen_rig
from footscan.config import Board, load_board, load_calibration
from footscan.config.rig_file import load_rig
from footscan.errors import InputError, QualityError
from footscan.optics.calibration import Calibration
from footscan.optics.scanner import Scanner
from footscan.records.data_folder import data_folder
from footscan.scanning.recording import open_recording
from footscan.workflow.calibration_checks import (
    align_recording,
    daily_check,
    first_daily,
    log_check,
    recheck_lines,
    recheck_recording,
)
from footscan.workflow.calibration_log import (
    TOUCHES,
    in_force_path,
    log_service,
    machine_name,
    machines,
    read_log,
    reminders,
    zone_trends,
)

calibration_app = typer.Typer(help="Between calibrations: align, re-check, note interventions.", no_args_is_help=True)
DataOption = Annotated[Path | None, typer.Option(help="Data folder; default: FOOTSCAN_DATA or the user's own.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
InForceOption = Annotated[
    Path | None, typer.Option("--calibration", help="calibration.toml; default: the one in force of that machine.")
]
RigOption = Annotated[Path | None, typer.Option(help="Record first, at this machine: you place the board.")]
BodyRigOption = Annotated[Path | None, typer.Option("--rig", help="Scan the test body first, at this machine.")]
BoardOption = Annotated[Path | None, typer.Option("--board", help="board.toml; default: the recording's own.")]
YesOption = Annotated[bool, typer.Option("--yes", help="I have looked: no face is at beam height.")]
FastOption = Annotated[bool, typer.Option("--fast", help="Simulated machine: do not wait for the wall clock.")]
_FOLDER = "Folder of a recording with one placement and the bare footboard; with --rig the folder to record into."


@calibration_app.callback()
def _calibration() -> None:
    """Between calibrations: align lasers, re-check the one in force, note interventions, look at the history."""


def _board(path: Path | None) -> Board | None:
    return None if path is None else load_board(path)


def _in_force(given: Path | None, folder: Path, data: Path) -> Calibration:
    """The calibration as given, else the one in force of the machine that made a recording."""
    if given is not None:
        return load_calibration(given)
    return _of_machine(open_recording(folder).scanner, data)


def _of_rig(given: Path | None, rig: Path, data: Path) -> Calibration:
    """The calibration as given, else the one in force of a rig."""
    return load_calibration(given) if given is not None else _of_machine(load_rig(rig).scanner, data)


def _of_machine(scanner: Scanner, data: Path) -> Calibration:
    path = in_force_path(data, scanner.machine_id or scanner.name)
    if not path.is_file():
        raise InputError(f"there is no calibration in force at {path}; name one with --calibration.")
    return load_calibration(path)


def _recorded(rig: Path | None, folder: Path, board: Path | None, yes: bool, fast: bool) -> None:
    if rig is not None:
        record_one_placement(chosen_rig(rig, fast), folder, GuidedChoices(board, 16, 1, yes, passing=False))


@calibration_app.command("align")
def align(
    recording: Annotated[Path, typer.Argument(help=_FOLDER)],
    rig: RigOption = None,
    board_file: BoardOption = None,
    yes: YesOption = False,
    fast: FastOption = False,
    json_only: JsonOption = False,
) -> None:
    """Where both sheets are (offset, lean), how wide the line is, focus, exposure, and which way to turn."""
    _recorded(rig, recording, board_file, yes, fast)
    with progress_bar("frames", quiet=json_only) as progress:
        found = align_recording(recording, None, _board(board_file) if rig is None else None, progress)
    if json_only:
        print_json(_plain(asdict(found)) | {"advice": found.advice()})
        return
    for line in _alignment_lines(found):
        STDOUT.print(line)


def _alignment_lines(found: Alignment) -> list[str]:
    lines: list[str] = []
    for sheet in found.sheets:
        widths = ", ".join(
            f"{zone} {sheet.width_px[zone]:.1f} px ({sheet.width_mm[zone]:.1f} mm)" for zone in sheet.width_px
        )
        lines += [
            f"{sheet.laser:5} laser: {sheet.offset_mm:+.2f} mm off the axis (+ is right, seen from the laser), leans "
            f"{sheet.lean_deg:+.3f} degrees (+ is to the left), turned {sheet.turned_deg:+.2f} degrees from its design",
            f"             line: {widths}; peaks reach grey {sheet.peak_grey:.0f}, "
            f"{100 * sheet.saturated:.0f} % saturated",
        ]
    lines.append(
        f"camera: edges blurred by {found.blur_px:.2f} px, white paper grey {found.white_grey:.0f}, "
        f"print grey {found.black_grey:.0f}"
    )
    return [*lines, *(f"Do: {word}." for word in found.advice())] + ([] if found.advice() else ["Nothing to turn."])


def _plain(value: Any) -> Any:
    """NaN as null: JSON knows no NaN."""
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


@calibration_app.command("recheck")
def recheck(
    recording: Annotated[Path, typer.Argument(help=_FOLDER)],
    calibration: InForceOption = None,
    rig: RigOption = None,
    board_file: BoardOption = None,
    yes: YesOption = False,
    fast: FastOption = False,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Does the calibration still hold? Board in one placement, two minutes; exit status 4 when it does not."""
    _recorded(rig, recording, board_file, yes, fast)
    machine = _in_force(calibration, recording, data_folder(data))
    with progress_bar("frames", quiet=json_only) as progress:
        found = recheck_recording(recording, machine, _board(board_file) if rig is None else None, progress=progress)
    if calibration is None or data is not None:
        log_check(data_folder(data), machine, found, recording)
    if json_only:
        print_json(asdict(found.recheck) | {"holds": found.holds, "broken": list(found.broken)})
    else:
        for line in recheck_lines(found):
            STDOUT.print(line)
    if not found.holds:
        raise QualityError(f"the calibration does not hold: {'; '.join(found.broken)}. Calibrate the machine.")


@calibration_app.command("daily")
def daily(
    recording: Annotated[
        Path, typer.Argument(help="Folder of a scan of the test body; with --rig the folder to record into.")
    ],
    calibration: InForceOption = None,
    rig: BodyRigOption = None,
    yes: YesOption = False,
    fast: FastOption = False,
    artefact: Annotated[Path | None, typer.Option(help="artefact.toml; default: the one in the recording.")] = None,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """The daily check: a test body, half a minute; exit status 4 when the calibration no longer holds."""
    if rig is not None:
        machine = _of_rig(calibration, rig, data_folder(data))
        recording = record_body(chosen_rig(rig, fast), recording, machine, artefact, yes)
    else:
        machine = _in_force(calibration, recording, data_folder(data))
    reference = first_daily(read_log(data_folder(data), machine_name(machine)), machine)
    with progress_bar("frames", quiet=json_only) as progress:
        found = daily_check(recording, machine, reference, artefact, progress)
    if calibration is None or data is not None:
        log_check(data_folder(data), machine, found, recording)
    if json_only:
        print_json(asdict(found) | {"holds": found.holds})
    else:
        against = "first check under this calibration" if reference is None else "compared with the first check"
        words = ", ".join(
            f"{name.removesuffix('_mm').replace('_', ' ')} {x:+.3f} mm" for name, x in found.figures.items()
        )
        STDOUT.print(f"Test body ({against}): {words}")
        STDOUT.print("The calibration holds." if found.holds else "The calibration does NOT hold.")
    if not found.holds:
        raise QualityError(f"the calibration does not hold: {'; '.join(found.broken)}. Re-check or calibrate.")


@calibration_app.command("service")
def service(
    part: Annotated[str, typer.Argument(help=f"One of {', '.join(TOUCHES)}.")],
    what: Annotated[str, typer.Option(help="What was done, in your words.")] = "",
    machine: Annotated[str | None, typer.Option(help="Machine id; default: the only one in the data folder.")] = None,
    data: DataOption = None,
) -> None:
    """Note an intervention at the machine; what it touches is invalid until renewed, calibrated or re-checked."""
    folder = data_folder(data)
    names = machines(folder)
    if machine is None and len(names) != 1:
        raise InputError(f"{len(names)} machines are known in {folder} ({', '.join(names)}); say which with --machine.")
    touched = log_service(folder, machine or names[0], part, what)
    word = "is no longer known" if touched.blocking else "may have changed"
    STDOUT.print(f"Noted for {machine or names[0]}. Of its calibration {touched.parts} {word}; {touched.remedy}.")


@calibration_app.command("history")
def history(
    machine: Annotated[str | None, typer.Option(help="Machine id; default: every machine with a history.")] = None,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Calibrations, interventions, and how left and right disagree in scans of feet that were judged still."""
    folder = data_folder(data)
    names = [machine] if machine is not None else machines(folder)
    told = {name: _machine_history(folder, name) for name in names}
    if machine is not None and not told[machine]["events"]:
        raise InputError(f"{folder} has no history of a machine called {machine!r}; check --machine and --data.")
    if json_only:
        print_json({"machines": told})
        return
    for name, entry in told.items():
        _tell_history(name, entry)
    if not told:
        STDOUT.print(f"No calibration was put in force in {folder} yet; footscan calibrate --in-force does.")


def _machine_history(folder: Path, name: str) -> dict[str, Any]:
    events = read_log(folder, name)
    path = in_force_path(folder, name)
    notes = (
        reminders(load_calibration(path), events, datetime.now(UTC)) if path.is_file() else ["no calibration in force"]
    )
    trends = {
        trend.zone: {"scans": len(trend.median_mm), "drift_mm": trend.drift_mm, "median_mm": list(trend.median_mm)}
        for trend in zone_trends(events)
    }
    return {"events": events, "reminders": notes, "agreement": trends}


def _tell_history(name: str, entry: dict[str, Any]) -> None:
    STDOUT.print(f"Machine {name}")
    for event in entry["events"]:
        line = _event_line(event)
        if line:
            STDOUT.print(f"  {event['at']}  {line}")
    for zone, trend in entry["agreement"].items():
        values = " ".join(f"{x:+.2f}" for x in trend["median_mm"][-10:])
        STDOUT.print(f"  {zone:8} right minus left over {trend['scans']} still scans: {values} mm")
    for note in entry["reminders"]:
        STDOUT.print(f"  Reminder: {note}")


def _event_line(event: dict[str, Any]) -> str:
    kind = event["kind"]
    if kind == "calibration":
        errors = ", ".join(f"{laser} {mm:.3f}" for laser, mm in event.get("expected_error_mm", {}).items())
        renewed = f"renewed {event['renewed']}" if "renewed" in event else f"calibrated, expected error {errors} mm"
        return f"{renewed}  ({event['sha256'][:12]})"
    if kind == "service":
        return f"{event.get('part', 'intervention')}: {event.get('what', '')}"
    if kind in ("recheck", "daily"):
        name = "re-check" if kind == "recheck" else "daily check"
        return f"{name}: {'holds' if event.get('holds') else 'does not hold: ' + '; '.join(event.get('broken', []))}"
    return ""
