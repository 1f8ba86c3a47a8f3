"""`footscan study calibration`, `study machines`: how good a calibration is, on machines that are known exactly."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from footscan.cli.console import STDOUT, print_json, progress_bar
from footscan.config import load_scanner
from footscan.errors import QualityError
from footscan.workflow.calibration_study import run_study, save_plot, study_table
from footscan.workflow.designs import builtin_scanner
from footscan.workflow.machines_study import MOST_RMS_MM, MachineOutcome, missed, ratio_rms, run_machines


def study_calibration(
    plot: Annotated[Path | None, typer.Option(help="PNG to draw both studies into.")] = None,
    json_only: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """RMS 3-D error against the number of control points and against image noise (the paper's Part II), synthetic."""
    with progress_bar("figures", quiet=json_only) as progress:
        points = run_study(builtin_scanner("prototype"), progress)
    if plot is not None:
        save_plot(points, plot)
    if json_only:
        print_json({"points": study_table(points)})
        return
    table = Table(title="RMS 3-D error in the working volume, mm")
    for column in ("method", "control points a view", "image noise (px)", "RMS (mm)", "trials"):
        table.add_column(column, justify="right")
    for point in points:
        numbers = (str(point.control_points), f"{point.noise_px:g}", f"{point.rms_mm:.4f}", str(point.trials))
        table.add_row(point.method, *numbers)
    STDOUT.print(table)


def study_machines(
    count: Annotated[int, typer.Option(help="Seeded workshop machines.", min=1, max=1000)] = 20,
    first: Annotated[int, typer.Option(help="Seed of the first one.", min=0)] = 1,
    scanner: Annotated[Path | None, typer.Option(help="scanner.toml; default: the paper's prototype.")] = None,
    points: Annotated[bool, typer.Option("--points", help="Fast: points with noise instead of pictures.")] = False,
    json_only: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Calibrate simulated machines and compare with the truth; exit status 4 when a limit is broken."""
    design = load_scanner(scanner) if scanner is not None else builtin_scanner("prototype")
    with progress_bar("machines", quiet=json_only) as progress:
        outcomes = run_machines(design, range(first, first + count), not points, progress)
    broken = missed(outcomes)
    if json_only:
        print_json({"machines": [asdict(o) for o in outcomes], "ratio_rms": ratio_rms(outcomes), "broken": broken})
    else:
        STDOUT.print(_machines_table(outcomes))
        worst = max((rms for o in outcomes for rms in o.rms_mm.values()), default=float("nan"))
        most = max((ratio for o in outcomes for ratio in o.ratios), default=float("nan"))
        STDOUT.print(f"Largest error {worst:.3f} mm RMS (at most {MOST_RMS_MM}); true over expected error")
        STDOUT.print(f"{ratio_rms(outcomes):.2f} RMS (0.5 to 2), {most:.2f} at most (3)")
    if broken:
        raise QualityError(f"not all machines keep the limits: {'; '.join(broken)}.")


def _machines_table(outcomes: list[MachineOutcome]) -> Table:
    table = Table(title="RMS error in the working volume, mm")
    for column in ("seed", "right", "expected", "left", "expected", "latency off (ms)", ""):
        table.add_column(column, justify="right")
    for o in outcomes:
        figures = [f"{x:.4f}" for name in o.rms_mm for x in (o.rms_mm[name], o.expected_mm[name])] or [""] * 4
        table.add_row(str(o.seed), *figures, "" if o.refused else f"{o.latency_error_ms:+.2f}", o.refused)
    return table
