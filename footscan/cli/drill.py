"""`footscan drill`: break the machine on purpose and print what happened."""

import tempfile
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from footscan import app as rig_app
from footscan.cli.console import STDERR, STDOUT
from footscan.cli.drill_records import drill_records_command
from footscan.cli.scan import RigOption, chosen_rig
from footscan.errors import ConfigError, QualityError
from footscan.scanning.session.control import SessionSetup
from footscan.workflow.drill import CASES, TARGET_S, Drill, DrillResult
from footscan.workflow.process import build_tables

drill_app = typer.Typer(help="Break things on purpose: when do the outputs fall, what is told, what is kept?")
drill_app.command("records")(drill_records_command)


@drill_app.callback(invoke_without_command=True)
def drill(
    context: typer.Context,
    rig: RigOption = None,
    seed: Annotated[int, typer.Option(help="When in the scan each fault strikes.", min=0, max=2**31)] = 0,
    case: Annotated[list[str] | None, typer.Option(help=f"Only these cases: {', '.join(CASES)}.")] = None,
    rounds: Annotated[int, typer.Option(help="How often, each time with the next seed.", min=1, max=1000)] = 1,
) -> None:
    """Break scans of the simulated machine in every known way and print the table."""
    if context.invoked_subcommand is not None:
        return
    unknown = sorted(set(case or ()) - set(CASES))
    if unknown:
        raise typer.BadParameter(f"{unknown[0]!r} is no case; there are {', '.join(CASES)}.")
    results = [result for number in range(rounds) for result in _round(rig, seed + number, tuple(case or CASES))]
    STDOUT.print(_table(results), width=None if STDOUT.is_terminal else 200)
    bad = [result.case for result in results if not result.well]
    STDOUT.print(f"{len(results) - len(bad)} of {len(results)} well: off within {TARGET_S:g} s, told, nothing lost")
    if bad:
        raise QualityError(f"the drill failed in: {', '.join(bad)}.")


def _round(rig: Path | None, seed: int, cases: tuple[str, ...]) -> list[DrillResult]:
    chosen = chosen_rig(rig, fast=True)
    if not chosen.devices.simulated:
        raise ConfigError(f"{chosen.path} is a real machine; the drill breaks simulated ones only.")
    calibration = rig_app.true_machine(chosen).calibration
    setup = SessionSetup(chosen.scanner, chosen.motion, calibration, build_tables(calibration))
    results: list[DrillResult] = []
    with tempfile.TemporaryDirectory(prefix="footscan-drill-") as folder:
        for result in Drill(chosen, rig_app.open_rig, setup, seed, Path(folder)).run(cases):
            STDERR.print(f"{result.case}: {'well' if result.well else 'NOT WELL'}")
            results.append(result)
    return results


def _table(results: list[DrillResult]) -> Table:
    table = Table("broken", "off after", "frames captured", "named", "on disk", "the person is told", box=None)
    for result in results:
        asked = ("-" if result.captured is None else str(result.captured), str(result.named or "-"))
        table.add_row(result.case, f"{result.off_after_s:.3f} s", *asked, str(result.kept), result.told)
    return table
