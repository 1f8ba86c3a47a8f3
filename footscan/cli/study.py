"""`footscan study ...`: seeded simulations that measure what a part of footscan is worth."""

import os
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from footscan import app as rig_app
from footscan.cli.console import STDERR, STDOUT, print_json, progress_bar
from footscan.cli.study_calibration import study_calibration, study_machines
from footscan.cli.study_lasts import study_lasts
from footscan.cli.study_ranking import study_ranking
from footscan.config.io_models import Dialect
from footscan.config.rig_file import load_rig
from footscan.errors import ConfigError, InputError, QualityError
from footscan.workflow.designs import builtin_config, builtin_scanner
from footscan.workflow.driver_study import BAUDS, DIALECTS, REPLAYED_MM, SAME_MM, DriverRun, run_driver_study
from footscan.workflow.motion_study import CALIBRATIONS, Outcome, Tally, outcome_report, run_study, study_cases, tally

study_app = typer.Typer(help="Seeded simulations that say what a part of footscan is worth.", no_args_is_help=True)
study_app.command("lasts")(study_lasts)
study_app.command("ranking")(study_ranking)
study_app.command("calibration")(study_calibration)
study_app.command("machines")(study_machines)


@study_app.callback()
def _study() -> None:
    """Seeded simulations that say what a part of footscan is worth."""


@study_app.command("motion")
def study_motion(
    scans: Annotated[int, typer.Option(help="How many; every other person moves.", min=2, max=1000)] = 40,
    seed: Annotated[int, typer.Option(help="Of machines, feet and moves.", min=0, max=10**6)] = 0,
    frames: Annotated[int, typer.Option(help="Frames per sweep.", min=60, max=2000)] = 240,
    mesh: Annotated[
        list[Path] | None, typer.Option(help="Mesh of a foot in metres for every fifth scan; may be repeated.")
    ] = None,
    json_only: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """People who stand still or move between the sweeps: is it said, and of the right zone?"""
    cases = study_cases(scans, seed, _meshes(mesh))
    with progress_bar("scans", quiet=json_only) as progress:
        outcomes = run_study(builtin_scanner("prototype"), cases, frames, progress)
    tallies = [tally(outcomes, calibration) for calibration in CALIBRATIONS]
    if json_only:
        print_json({"tallies": [_tally_row(t) for t in tallies], "scans": [outcome_report(o) for o in outcomes]})
        return
    STDOUT.print(_outcome_table(outcomes))
    STDOUT.print(_tally_table(tallies))


def _meshes(given: list[Path] | None) -> tuple[Path, ...]:
    """The meshes asked for, else those of the shared data when `FOOTSCAN_SHARED` names them.

    Raises:
        InputError: A mesh that is not there.
    """
    for path in given or []:
        if not path.is_file():
            raise InputError(f"there is no mesh file {path}; give an STL, PLY or OBJ file in metres.")
    shared = Path(os.environ.get("FOOTSCAN_SHARED", "")) / "data" / "feet"
    return tuple(given) if given else tuple(sorted(shared.glob("*_foot.stl")))


def _outcome_table(outcomes: list[Outcome]) -> Table:
    table = Table(title="Way of the zone that moved most (mm); zones as found, + where moved")
    for column in ("seed", "foot", "true move", "calibration", "said", "mm", "heel midfoot ball toes ankle"):
        table.add_column(column)
    for outcome in outcomes:
        row = outcome_report(outcome)
        zones = " ".join(_zone(zone) for zone in row["zones"].values())
        size = "" if row["displacement_mm"] is None else f"{row['displacement_mm']:.2f}"
        mark = "" if outcome.right else "  WRONG"
        error = f"{row['calibration']} {row['calibration_error_mm']:.2f}"
        table.add_row(str(row["seed"]), row["foot"], row["move"], error, f"{row['said']}{mark}", size, zones)
    return table


def _zone(zone: dict[str, Any]) -> str:
    if zone["displacement_mm"] is None:
        return "-"
    return f"{zone['displacement_mm']:.2f}{'+' if zone['moved'] else '?' if zone['moved'] is None else ''}"


def _tally_table(tallies: list[Tally]) -> Table:
    table = Table(title="Target: at least 19 of 20 moved found with the right zone, at most 1 of 20 still called moved")
    for column in ("calibration", "moved, right zone", "still, called moved"):
        table.add_column(column)
    for t in tallies:
        table.add_row(t.calibration, f"{t.moved_found} of {t.moved}", f"{t.still_called_moved} of {t.still}")
    return table


def _tally_row(t: Tally) -> dict[str, Any]:
    return {
        "calibration": t.calibration,
        "moved": t.moved,
        "moved_found": t.moved_found,
        "still": t.still,
        "still_called_moved": t.still_called_moved,
    }


@study_app.command("drivers")
def study_drivers(
    rig: Annotated[Path | None, typer.Option(help="Rig file of emulators; default: configs/rig-emulated.toml.")] = None,
    dialect: Annotated[
        list[str] | None, typer.Option(help="Of the output module; may be repeated. Default: adam4055, i7050.")
    ] = None,
    baud: Annotated[
        list[int] | None, typer.Option(help="Of its port; may be repeated. Default: 115200 and 9600.")
    ] = None,
    json_only: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """One foot by the pure simulation and over real drivers on emulators, in real time: the same cloud?"""
    chosen = load_rig(rig if rig is not None else builtin_config("rig-emulated"))
    if not chosen.devices.emulated or chosen.devices.simulated:
        raise ConfigError(f"{chosen.path}: all its devices must be emulated; take configs/rig-emulated.toml.")
    bauds = tuple(baud or BAUDS)
    dialects: tuple[Dialect, ...] = tuple(kind for kind in DIALECTS if dialect is None or dialect.count(kind))
    unknown = [*sorted(set(bauds) - set(BAUDS)), *sorted(set(dialect or ()) - set(DIALECTS))]
    if unknown:
        known = ", ".join(map(str, (*BAUDS, *DIALECTS)))
        raise InputError(f"{unknown[0]} is not studied; choose from {known}.")
    truth = rig_app.true_machine(chosen).calibration
    runs: list[DriverRun] = []
    for run in run_driver_study(chosen, truth, rig_app.open_rig, dialects, bauds):
        runs.append(run)
        if not json_only:
            STDERR.print(f"{run.name}: {'well' if run.well else 'NOT WELL'}")
    if json_only:
        print_json({"runs": [asdict(run) | {"well": run.well} for run in runs]})
    else:
        STDOUT.print(_driver_table(runs))
    bad = [run.name for run in runs if not run.well]
    if bad:
        raise QualityError(f"clouds differ by more than {SAME_MM} or {REPLAYED_MM} mm, or frames are missing: {bad}.")


def _driver_table(runs: list[DriverRun]) -> Table:
    title = (
        "RMS, mm: from the true skin (also turned back by what homing was off), from the simulated cloud, and from "
        "the same pictures with true counts (with the latency that a calibration finds, and without)"
    )
    table = Table(title=title)
    names = ("devices", "frames", "lost", "true skin", "turned back", "homing off", "simulated", "replayed", "without")
    for column in (*names, "late"):
        table.add_column(column, justify="left" if column == "devices" else "right")
    for run in runs:
        table.add_row(
            run.name,
            f"{run.frames.kept} of {run.frames.captured}",
            str(run.frames.lost),
            f"{run.truth_mm:.3f}",
            f"{run.turned_mm:.3f}",
            f"{run.home_off_deg:+.2f} deg",
            "" if run.same_mm is None else f"{run.same_mm:.3f}",
            "" if run.replayed_mm is None else f"{run.replayed_mm:.3f}",
            "" if run.late_replayed_mm is None else f"{run.late_replayed_mm:.3f}",
            "" if run.late_ms is None else f"{run.late_ms:+.2f} ms",
        )
    return table
