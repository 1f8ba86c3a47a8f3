"""`footscan simulate` and `footscan demo`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from footscan.cli.console import STDOUT, progress_bar
from footscan.config import load_scanner
from footscan.coordinates import Side
from footscan.workflow.designs import builtin_scanner
from footscan.workflow.simulate import SimulateSettings, run_demo, simulate_scan

Unit = Literal["mm", "cm", "m"]


def simulate(
    thing: Annotated[str, typer.Argument(metavar="OBJECT", help="A mesh file, or foot, sphere, ball-bar, plane.")],
    out: Annotated[Path, typer.Argument(help="Folder for the recording; must not hold one already.")],
    unit: Annotated[Unit, typer.Option(help="Unit of the mesh file.")] = "mm",
    scanner: Annotated[Path | None, typer.Option(help="scanner.toml; default: the paper's prototype.")] = None,
    side: Annotated[Side, typer.Option(help="Side of the foot.")] = "left",
    seed: Annotated[
        int | None, typer.Option(help="A machine as it leaves a workshop; the seed chooses which.", min=0, max=2**31)
    ] = None,
    ideal: Annotated[bool, typer.Option("--ideal", help="A machine exactly as designed.")] = False,
    frames: Annotated[int, typer.Option(help="Frames per sweep.", min=8, max=20000)] = 240,
    size: Annotated[float, typer.Option(help="Size of the built-in foot, 0.45 to 1.2.")] = 1.0,
) -> None:
    """Make the recording that a simulated machine would make, with its truth beside it."""
    if ideal and seed is not None:
        raise typer.BadParameter("--ideal and --seed contradict each other; give one of them.")
    design = load_scanner(scanner) if scanner is not None else builtin_scanner("prototype")
    settings = SimulateSettings(thing, unit, side, None if ideal else (seed or 0), frames, size)
    with progress_bar("frames", quiet=False) as progress:
        simulate_scan(design, settings, out, progress)
    STDOUT.print(f"Recording in {out}; the machine's true calibration and the true surface lie beside it.")


def demo(
    out: Annotated[Path, typer.Option(help="Folder for the demo; results of an earlier demo are replaced.")],
    seed: Annotated[int, typer.Option(help="Which simulated machine.", min=0, max=2**31)] = 7,
) -> None:
    """Scan the built-in foot on a simulated machine, process the recording, and say how exact the result is."""
    with progress_bar("simulating", quiet=False) as progress:
        recorded = run_demo(builtin_scanner("prototype"), seed, out, progress)
    for line in recorded.lines:
        STDOUT.print(line)
