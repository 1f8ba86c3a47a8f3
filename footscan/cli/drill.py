"""`footscan drill`: break the machine on purpose and print what happened."""

import tempfile
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from footscan import app as rig_app
from footscan.cli.console import STDERR, STDOUT
from footscan.cli.drill_records import drill_records_command
from footscan.cli.rig_option import RigOption, chosen_rig
from footscan.config.rig_file import Rig
from footscan.errors import ConfigError, QualityError
from footscan.optics.tables import build_tables
from footscan.scanning.session.assembly import SessionSetup
from footscan.workflow.drill import CASES, EMULATED_CASES, Drill, cases_of
from footscan.workflow.drill_result import DrillResult

_KNOWN = tuple(dict.fromkeys((*CASES, *EMULATED_CASES)))

drill_app = typer.Typer(help="Break things on purpose: when do the outputs fall, what is told, what is kept?")
drill_app.command("records")(drill_records_command)


@drill_app.callback(invoke_without_command=True)
def drill(
    context: typer.Context,
    rig: RigOption = None,
    seed: Annotated[int, typer.Option(help="When in the scan each fault strikes.", min=0, max=2**31)] = 0,
    case: Annotated[list[str] | None, typer.Option(help=f"Only these cases: {', '.join(_KNOWN)}.")] = None,
    rounds: Annotated[int, typer.Option(help="How often, each time with the next seed.", min=1, max=1000)] = 1,
) -> None:
    """Break scans of a simulated or emulated machine in every known way and print the table."""
    if context.invoked_subcommand is not None:
        return
    chosen = _breakable(rig)
    known = cases_of(chosen)
    unknown = sorted(set(case or ()) - set(known))
    if unknown:
        raise typer.BadParameter(f"{unknown[0]!r} is no case of this machine; there are {', '.join(known)}.")
    results = [result for number in range(rounds) for result in _round(chosen, seed + number, tuple(case or known))]
    STDOUT.print(_table(results))
    bad = [result.case for result in results if not result.well]
    limits = " or ".join(f"{limit:g}" for limit in sorted({result.target_s for result in results}))
    STDOUT.print(f"{len(results) - len(bad)} of {len(results)} well: off within {limits} s, told, nothing lost")
    if bad:
        raise QualityError(f"the drill failed in: {', '.join(bad)}.")


def _breakable(rig: Path | None) -> Rig:
    chosen = chosen_rig(rig, fast=False)
    if chosen.devices.emulated:
        return chosen
    if not chosen.devices.simulated:
        raise ConfigError(f"{chosen.path} is a real machine; the drill breaks simulated and emulated ones only.")
    return chosen_rig(rig, fast=True)


def _round(chosen: Rig, seed: int, cases: tuple[str, ...]) -> list[DrillResult]:
    calibration = rig_app.true_machine(chosen).calibration
    setup = SessionSetup(chosen.scanner, chosen.motion, calibration, build_tables(calibration))
    results: list[DrillResult] = []
    with tempfile.TemporaryDirectory(prefix="footscan-drill-") as folder:
        drill = Drill(chosen, rig_app.open_rig, rig_app.serve_emulators, setup, seed, Path(folder))
        for result in drill.run(cases):
            STDERR.print(f"{result.case}: {'well' if result.well else 'NOT WELL'}{_again(result)}")
            results.append(result)
    return results


def _again(result: DrillResult) -> str:
    return f" (begun {result.spoiled + 1} times: the computer was too busy)" if result.spoiled else ""


def _table(results: list[DrillResult]) -> Table:
    table = Table(
        "broken", "off after", "at most", "frames captured", "named", "on disk", "the person is told", box=None
    )
    for result in results:
        asked = ("-" if result.captured is None else str(result.captured), str(result.named or "-"))
        table.add_row(
            result.case, f"{result.off_after_s:.3f} s", f"{result.target_s:g} s", *asked, str(result.kept), result.told
        )
    return table
