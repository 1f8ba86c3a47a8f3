"""`footscan calibrate`, `board`, `accept`: the technician's commands."""

from pathlib import Path
from typing import Annotated

import typer

from footscan.calibration.board_sheet import draw_board, page_of
from footscan.calibration.joint import Choices
from footscan.calibration.quality import quality_lines
from footscan.calibration.renew import PARTS
from footscan.cli.body_rig import record_body
from footscan.cli.calibrate_rig import GuidedChoices, record_guided
from footscan.cli.console import STDOUT, print_json, progress_bar
from footscan.cli.rig_option import chosen_rig
from footscan.config import DEFAULT_BOARD, Board, board_toml, load_calibration, load_calibration_record
from footscan.config.toml_file import write_whole
from footscan.errors import InputError, QualityError
from footscan.records.data_folder import data_folder
from footscan.workflow.accept import accept_recording, save_acceptance
from footscan.workflow.acceptance_words import summary_lines
from footscan.workflow.calibrate import CalibrateSettings, measured_board, run_calibration, tables_path
from footscan.workflow.calibration_checks import renew_recording
from footscan.workflow.calibration_log import in_force_path, machine_name

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
    paper_mode: Annotated[
        bool, typer.Option("--paper-mode", help="Also say what the paper's own model makes of this recording.")
    ] = False,
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
    settings = CalibrateSettings(measured, Choices(horizontal_scale=horizontal_scale), paper_mode, kept)
    with progress_bar("frames", quiet=json_only) as progress:
        result = run_calibration(recording, out, settings, progress)
    quality = load_calibration_record(out).quality
    if json_only:
        print_json(quality)
        return
    for line in [*quality_lines(result), *quality.get("paper_mode", [])]:
        STDOUT.print(line)
    if not result.intake.board.measured:
        STDOUT.print("Both lengths are given with --measured-x and --measured-y, also for this recording.")
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
        STDOUT.print(gate.finding())
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
