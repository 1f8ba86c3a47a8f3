"""`footscan calibrate`, `board`, `accept`, `study calibration`: the technician's commands."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from footscan.calibration.board_sheet import DEFAULT_BOARD, draw_board, page_of
from footscan.calibration.joint import Choices
from footscan.calibration.quality import quality_lines
from footscan.calibration.renew import PARTS
from footscan.cli.body_rig import record_body
from footscan.cli.calibrate_rig import GuidedChoices, record_guided
from footscan.cli.console import STDOUT, print_json, progress_bar
from footscan.cli.scan import chosen_rig
from footscan.cli.study import study_app
from footscan.config import Board, board_toml, load_calibration, load_calibration_record, load_scanner
from footscan.config.toml_file import write_whole
from footscan.errors import InputError, QualityError
from footscan.records.data_folder import data_folder
from footscan.workflow.accept import accept_recording, save_acceptance
from footscan.workflow.acceptance_words import summary_lines
from footscan.workflow.calibrate import CalibrateSettings, measured_board, run_calibration, tables_path
from footscan.workflow.calibration_checks import renew_recording
from footscan.workflow.calibration_log import in_force_path, machine_name
from footscan.workflow.calibration_study import run_study, save_plot, study_table
from footscan.workflow.designs import builtin_scanner
from footscan.workflow.machines_study import MOST_RMS_MM, MachineOutcome, missed, ratio_rms, run_machines

_MEASURED = "Length of the print over all squares, by calliper, mm, without the white border."


def calibrate(
    recording: Annotated[
        Path, typer.Argument(help="Folder of a calibration recording; with --rig the folder to record into.")
    ],
    out: Annotated[Path, typer.Option(help="calibration.toml to write; a refusal leaves it as it is.")],
    rig: Annotated[Path | None, typer.Option(help="Record first, at this machine: you place the board.")] = None,
    board_file: Annotated[Path | None, typer.Option("--board", help="board.toml of the board used at the rig.")] = None,
    stops: Annotated[int, typer.Option(help="Head angles per placement.", min=8, max=120)] = 16,
    placements: Annotated[int, typer.Option(help="Placements at most.", min=4, max=30)] = 8,
    yes: Annotated[bool, typer.Option("--yes", help="I have looked: no face is at beam height.")] = False,
    fast: Annotated[bool, typer.Option("--fast", help="Simulated machine: do not wait for the wall clock.")] = False,
    measured_x: Annotated[float | None, typer.Option(help=f"{_MEASURED} Along a row.")] = None,
    measured_y: Annotated[float | None, typer.Option(help=f"{_MEASURED} Along a column.")] = None,
    horizontal_scale: Annotated[
        bool, typer.Option("--horizontal-scale", help="Estimate the camera's horizontal scale too.")
    ] = False,
    renew: Annotated[
        str | None, typer.Option(help="Only this part anew: right-laser, left-laser, encoder, footboard.")
    ] = None,
    parent: Annotated[
        Path | None, typer.Option("--from", help="With --renew: the calibration that still holds; default: --out.")
    ] = None,
    in_force: Annotated[
        bool, typer.Option("--in-force", help="Also put it in force in the data folder, with its history.")
    ] = False,
    data: Annotated[Path | None, typer.Option(help="Data folder; default: FOOTSCAN_DATA or the user's own.")] = None,
    json_only: Annotated[bool, typer.Option("--json", help="Print the [quality] table and nothing else.")] = False,
) -> None:
    """Find camera, lasers, axis and latency from a calibration recording; exit status 4 when a gate refuses them."""
    if rig is not None:
        record_guided(chosen_rig(rig, fast), recording, GuidedChoices(board_file, stops, placements, yes))
    if (measured_x is None) != (measured_y is None):
        raise InputError("one measured length of the board was given; give both, --measured-x and --measured-y.")
    measured = None if measured_x is None or measured_y is None else (measured_x, measured_y)
    kept = data_folder(data) if in_force or data is not None else None
    if renew is not None:
        _renew(recording, out, renew, parent or out, measured, kept)
        return
    settings = CalibrateSettings(measured, Choices(horizontal_scale=horizontal_scale), kept)
    with progress_bar("frames", quiet=json_only) as progress:
        result = run_calibration(recording, out, settings, progress)
    if json_only:
        print_json(load_calibration_record(out).quality)
        return
    for line in quality_lines(result):
        STDOUT.print(line)
    STDOUT.print(f"Calibration in {out}, its tables in {tables_path(out).name} ({sum(result.seconds.values()):.1f} s)")
    if kept is not None:
        STDOUT.print(f"In force: {in_force_path(kept, machine_name(result.calibration))}")


def _renew(
    recording: Path, out: Path, part: str, parent: Path, measured: tuple[float, float] | None, kept: Path | None
) -> None:
    if part not in PARTS:
        raise InputError(f"--renew takes one of {', '.join(PARTS)}; found {part!r}. For the rest leave it out.")
    with progress_bar("frames", quiet=False) as progress:
        made = renew_recording(recording, parent, out, part, measured_board(recording, measured), kept, progress)
    for gate in made.gates:
        STDOUT.print(f"{gate.name.replace('_', ' ')} ({gate.where}): {gate.value:.3f}, at most {gate.limit:g}")
    STDOUT.print(f"Renewed: {part}; everything else stays. Calibration in {out}, its tables in {tables_path(out).name}")


def board(
    out: Annotated[Path, typer.Option(help="PDF to write; board.toml goes beside it.")],
    squares_x: Annotated[int, typer.Option(help="Squares in a row.", min=3, max=50)] = DEFAULT_BOARD.squares_x,
    squares_y: Annotated[int, typer.Option(help="Squares in a column.", min=3, max=50)] = DEFAULT_BOARD.squares_y,
    square: Annotated[float, typer.Option(help="Side of a square, mm.", min=5, max=200)] = DEFAULT_BOARD.square_mm,
    marker: Annotated[float, typer.Option(help="Side of a marker, mm.", min=3, max=180)] = DEFAULT_BOARD.marker_mm,
    dictionary: Annotated[str, typer.Option(help="OpenCV's dictionary of markers.")] = DEFAULT_BOARD.dictionary,
    measured_x: Annotated[float | None, typer.Option(help=f"{_MEASURED} Along a row.")] = None,
    measured_y: Annotated[float | None, typer.Option(help=f"{_MEASURED} Along a column.")] = None,
) -> None:
    """Print a calibration board at 1:1 with rulers, and write its board.toml; measured lengths go in there too."""
    if marker >= square:
        raise InputError(f"a marker ({marker:g} mm) must be smaller than its square ({square:g} mm).")
    made = Board(squares_x, squares_y, square, marker, dictionary, measured_x, measured_y)
    toml = out.with_name("board.toml")
    write_whole(out, draw_board(made))
    write_whole(toml, board_toml(made))
    page, _, _ = page_of(made)
    STDOUT.print(f"{out}: print it on {page} landscape at 100 % (no fitting to the page); {toml} describes it.")
    if not made.measured:
        STDOUT.print(
            f"Then measure over all {squares_x} squares of a row ({squares_x * square:g} mm wanted) and all "
            f"{squares_y} of a column ({squares_y * square:g} mm wanted), without the white edge, and run this again "
            "with --measured-x and --measured-y: the scale of everything rests on it."
        )


def accept(
    recording: Annotated[
        Path, typer.Argument(help="Folder of a scan of a test body; with --rig the folder to record into.")
    ],
    calibration: Annotated[Path, typer.Option(help="calibration.toml of the machine.")],
    out: Annotated[Path | None, typer.Option(help="Folder for acceptance.json and the one-page PDF.")] = None,
    rig: Annotated[Path | None, typer.Option(help="Scan the test body first, at this machine.")] = None,
    yes: Annotated[bool, typer.Option("--yes", help="I have looked: no face is at beam height.")] = False,
    fast: Annotated[bool, typer.Option("--fast", help="Simulated machine: do not wait for the wall clock.")] = False,
    artefact: Annotated[Path | None, typer.Option(help="artefact.toml; default: the one in the recording.")] = None,
    json_only: Annotated[bool, typer.Option("--json", help="Print acceptance.json and nothing else.")] = False,
) -> None:
    """Acceptance figures on a sphere, ball bar or plane of known size; exit status 4 when a limit is broken."""
    machine = load_calibration(calibration)
    if rig is not None:
        recording = record_body(chosen_rig(rig, fast), recording, machine, artefact, yes)
    with progress_bar("frames", quiet=json_only) as progress:
        result = accept_recording(recording, machine, artefact, progress=progress)
    if json_only:
        print_json(result.report)
    else:
        for line in summary_lines(result):
            STDOUT.print(line)
    if out is not None:
        save_acceptance(result, out)
    elif result.broken:
        raise QualityError(f"not accepted ({result.of_what}): {'; '.join(result.broken)}.")


@study_app.command("calibration")
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


@study_app.command("machines")
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
