"""`footscan drill records`."""

from dataclasses import asdict
from typing import Annotated

import typer

from footscan.cli.console import STDOUT, print_json, progress_bar
from footscan.errors import QualityError
from footscan.records.drill import drill_records


def drill_records_command(
    kills: Annotated[int, typer.Option(help="How many storing programs are killed.", min=1, max=100_000)] = 300,
    seed: Annotated[int, typer.Option(help="Seed of what is stored and when it is killed.", min=0)] = 0,
    json_only: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Kill (-9) programs while they store, in folders of their own, and look whether anything acknowledged is gone."""
    with progress_bar("kills", quiet=json_only) as progress:
        report = drill_records(kills, seed, progress)
    if json_only:
        print_json(asdict(report))
    else:
        struck = ", ".join(f"{what} {count}" for what, count in sorted(report.struck.items()))
        STDOUT.print(f"{report.kills} kills in {report.seconds:.0f} s over {report.folders} data folders ({struck})")
        STDOUT.print(f"{report.acknowledged} acknowledged calls, {report.half_done} kills left files half done")
        STDOUT.print(f"{len(report.problems)} problems")
        for problem in report.problems:
            STDOUT.print(f"  {problem}")
    if report.problems:
        raise QualityError(f"{len(report.problems)} problems after {report.kills} kills; the records are not safe.")
