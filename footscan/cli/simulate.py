"""`footscan simulate` and `footscan demo`."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

import typer

from footscan.cli.console import STDOUT, progress_bar
from footscan.config import load_board, load_scanner
from footscan.coordinates import Side
from footscan.sim.artefacts import ArtefactChoice
from footscan.sim.board import PrintFaults
from footscan.sim.calibration_run import DEFAULT_CALIBRATION_PLAN, MovedBoard
from footscan.sim.obstacles import OBSTACLES
from footscan.workflow.designs import builtin_scanner
from footscan.workflow.simulate import SimulateSettings, run_demo, simulate_board, simulate_scan

Unit = Literal["mm", "cm", "m"]
BOARD = "board"
_OBJECT = "A mesh file, or foot, board, sphere, ball-bar, plane."


_BOARD_ONLY = ("board_file", "print_scale", "bow", "slip")
_ARTEFACT = ("at", "heading", "tilt")
_SCAN = ("side", "unit", "frames", "obstacle", "unlit_every", "alternate", "exposure")
_KNOBS: dict[str, tuple[str, ...]] = {
    BOARD: _BOARD_ONLY,
    "foot": (*_SCAN, "wedge", "size", "arch", "hallux_valgus", "missing_toe"),
    "sphere": (*_SCAN, "diameter", "at"),
    "ball-bar": (*_SCAN, "diameter", "spacing", *_ARTEFACT),
    "plane": (*_SCAN, *_ARTEFACT),
}
"""Which options mean something for which object; all others are a mesh or a body without options."""
_ALWAYS = ("thing", "out", "scanner", "seed", "ideal", "side", "unit")


def simulate(  # one option a knob: the command is the list of them
    context: typer.Context,
    thing: Annotated[str, typer.Argument(metavar="OBJECT", help=_OBJECT)],
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
    arch: Annotated[float, typer.Option(help="Arch of the built-in foot: 0 flat, 1 usual, 1.5 high.")] = 1.0,
    hallux_valgus: Annotated[float, typer.Option(help="How far its big toe leans, degrees, up to 28.")] = 0.0,
    missing_toe: Annotated[
        list[int] | None, typer.Option(help="Number 1 (big toe) to 5 of an amputated toe; may be given several times.")
    ] = None,
    obstacle: Annotated[
        list[str] | None,
        typer.Option(help=f"{', '.join(OBSTACLES)}: beside or around the foot; may be given several times."),
    ] = None,
    unlit_every: Annotated[int, typer.Option(help="Every n-th frame without a laser; 0: none.", min=0)] = 0,
    alternate: Annotated[bool, typer.Option("--alternate", help="One sweep, right and left laser in turn.")] = False,
    exposure: Annotated[float, typer.Option(help="Of the camera, relative to the usual one.", min=0.01, max=100)] = 1.0,
    wedge: Annotated[
        float, typer.Option(help="Height in mm of a wedge under the heel; the foot is bent on to it.", min=0, max=100)
    ] = 0.0,
    diameter: Annotated[float | None, typer.Option(help="Of sphere or balls, mm.")] = None,
    spacing: Annotated[float | None, typer.Option(help="Between the centres of a ball bar, mm.")] = None,
    at: Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Middle of an artefact, mm.")] = None,
    heading: Annotated[float, typer.Option(help="Of ball bar or plane, degrees from X.")] = 0.0,
    tilt: Annotated[float | None, typer.Option(help="Of ball bar or plane, degrees.")] = None,
    board_file: Annotated[Path | None, typer.Option("--board", help="board.toml; default: 7 x 5 squares.")] = None,
    print_scale: Annotated[str, typer.Option(metavar="X,Y", help="Size of the print over intended size.")] = "1,1",
    bow: Annotated[float, typer.Option(help="How far the middle of a bent board stands out, mm.")] = 0.0,
    slip: Annotated[int | None, typer.Option(help="Placement at which the board slips by 1 mm half-way.")] = None,
) -> None:
    """Make the recording that a simulated machine would make, with its truth beside it."""
    if ideal and seed is not None:
        raise typer.BadParameter("--ideal and --seed contradict each other; give one of them.")
    design = load_scanner(scanner) if scanner is not None else builtin_scanner("prototype")
    number = None if ideal else (seed or 0)
    scale_x, scale_y = _numbers("--print-scale", print_scale, 2)
    faults = PrintFaults(scale_x, scale_y, bow)
    _refuse_idle_options(context, thing)
    if thing == BOARD:
        moved = MovedBoard(slip, DEFAULT_CALIBRATION_PLAN.stops // 2) if slip is not None else None
        board = load_board(board_file) if board_file is not None else DEFAULT_CALIBRATION_PLAN.board
        plan = replace(DEFAULT_CALIBRATION_PLAN, board=board, faults=faults, moved=moved)
        with progress_bar("frames", quiet=False) as progress:
            simulate_board(design, plan, number, out, progress)
        STDOUT.print(f"Calibration recording in {out}; the machine's true calibration and the board's true poses too.")
        return
    artefact = ArtefactChoice(
        diameter_mm=diameter,
        spacing_mm=spacing,
        centre_world=_place(at),
        heading_rad=math.radians(heading),
        tilt_rad=math.radians(tilt) if tilt is not None else None,
    )
    settings = SimulateSettings(
        thing,
        unit,
        side,
        number,
        frames,
        size=size,
        arch=arch,
        hallux_valgus_rad=math.radians(hallux_valgus),
        missing_toes=tuple(missing_toe or ()),
        obstacles=tuple(obstacle or ()),
        unlit_every=unlit_every,
        alternating=alternate,
        exposure=exposure,
        artefact=artefact,
        wedge_mm=wedge,
    )
    with progress_bar("frames", quiet=False) as progress:
        simulate_scan(design, settings, out, progress)
    STDOUT.print(f"Recording in {out}; the machine's true calibration and the true surface lie beside it.")


def _refuse_idle_options(context: typer.Context, thing: str) -> None:
    """An option that would change nothing is a mistake in the command, not in the recording.

    Raises:
        BadParameter: An option that belongs to another object.
    """
    meaningful = {*_ALWAYS, *_KNOBS.get(thing, (*_SCAN, "wedge"))}
    options = {str(option.name): option.opts[0] for option in context.command.params}
    for name, value in context.params.items():
        source = context.get_parameter_source(name)
        if name not in meaningful and source is not None and source.name == "COMMANDLINE" and value is not None:
            owners = [owner for owner, own in _KNOBS.items() if name in own] or ["a scan"]
            raise typer.BadParameter(f"{options[name]} means nothing for OBJECT {thing}; it belongs to {_or(owners)}.")


def _or(names: list[str]) -> str:
    return " or ".join(filter(None, [", ".join(names[:-1]), names[-1]]))


def _place(text: str | None) -> tuple[float, float, float] | None:
    if text is None:
        return None
    x, y, z = _numbers("--at", text, 3)
    return x, y, z


def _numbers(option: str, text: str, count: int) -> list[float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise typer.BadParameter(f"{option} takes {count} numbers with commas between, found {text!r}.")
    return values


def demo(
    out: Annotated[Path, typer.Option(help="Folder for the demo; results of an earlier demo are replaced.")],
    seed: Annotated[int, typer.Option(help="Which simulated machine.", min=0, max=2**31)] = 7,
) -> None:
    """Scan the built-in foot on a simulated machine, process the recording, and say how exact the result is."""
    with progress_bar("simulating", quiet=False) as progress:
        recorded = run_demo(builtin_scanner("prototype"), seed, out, progress)
    for line in recorded.lines:
        STDOUT.print(line)
