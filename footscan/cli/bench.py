"""`footscan bench ...`: speed and accuracy, each beside a baseline measured in the same run."""

import statistics
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from footscan import app as rig_app
from footscan.cli.bench_page import bench_page_command
from footscan.cli.console import STDERR, STDOUT, print_json
from footscan.cli.rig_option import chosen_rig
from footscan.compiled import announce_compilation
from footscan.config import load_scanner
from footscan.optics.scanner import Scanner
from footscan.optics.tables import build_tables
from footscan.scanning.session.assembly import SessionSetup
from footscan.sim.calibration_run import DEFAULT_CALIBRATION_PLAN
from footscan.workflow import (
    foot_bench,
    lasts_bench,
    machines_study,
    picture_bench,
    process_bench,
    session_bench,
    stripe_bench,
)
from footscan.workflow.designs import builtin_scanner
from footscan.workflow.simulate import simulate_board

bench_app = typer.Typer(help="Speed and accuracy beside a baseline measured in the same run.", no_args_is_help=True)

_TARGET_MS = {"582x500": 0.3, "1280x960": 0.6, "2448x2048": 1.8}
_TARGET_RATIO = {"582x500": 1.3, "1280x960": 2.0, "2448x2048": 3.5}


def _design(path: Path | None) -> Scanner:
    return load_scanner(path) if path is not None else builtin_scanner("prototype")


bench_app.command("page")(bench_page_command)


@bench_app.callback()
def _bench() -> None:
    """Speed and accuracy beside a baseline measured in the same run."""


@bench_app.command("stripe")
def bench_stripe(
    frames: Annotated[int, typer.Option(help="Frames timed per size.", min=5, max=10000)] = 100,
    scanner: Annotated[Path | None, typer.Option(help="scanner.toml; default: the paper's prototype.")] = None,
    json_only: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Frame -> stripe -> table look-up against the plain way and the paper's, and the sub-pixel error."""
    design = _design(scanner)
    with announce_compilation(STDERR.print):
        timings = stripe_bench.time_sizes(design, frames)
        accuracy = [stripe_bench.measure_accuracy(angle) for angle in stripe_bench.ANGLES_DEG]
        step = stripe_bench.measure_step()
    if json_only:
        ratios = [asdict(timing) | {"times_as_fast": timing.times_as_fast} for timing in timings]
        print_json({"timings": ratios, "accuracy": [asdict(a) for a in accuracy], "step": asdict(step)})
        return
    STDOUT.print(_timing_table(timings))
    STDOUT.print(_accuracy_table(accuracy))
    STDOUT.print(
        f"Step of 20 px, within 5 rows: RMS {step.rms_px:.4f} px, {100 * step.share_within_006:.1f} % to 0.06 px, "
        f"largest {step.largest_px:.3f} px, at most {step.most_rows_dropped} rows dropped, {step.ghosts} ghosts"
    )


def _timing_table(timings: list[stripe_bench.Timing]) -> Table:
    table = Table(title="ms per frame, one thread: minimum / median")
    for column in ("size", "footscan", "target min", "plain way", "every pixel (paper)", "times as fast", "target"):
        table.add_column(column, justify="right")
    for t in timings:
        pairs = [f"{a:.2f} / {b:.2f}" for a, b in (t.ours_ms, t.plain_ms, t.paper_ms)]
        row = (t.size, pairs[0], f"{_TARGET_MS[t.size]}", pairs[1], pairs[2])
        table.add_row(*row, f"{t.times_as_fast:.2f}", f"{_TARGET_RATIO[t.size]}")
    return table


def _accuracy_table(accuracy: list[stripe_bench.Accuracy]) -> Table:
    table = Table(title="Error across a clean line (sigma 2 px, peak 200, background 10..30), px; target 0.04 RMS")
    for column in ("direction of the normal", "points", "RMS", "largest"):
        table.add_column(column, justify="right")
    for a in accuracy:
        table.add_row(f"{a.angle_deg:.0f} deg", str(a.points), f"{a.rms_px:.4f}", f"{a.largest_px:.3f}")
    return table


@bench_app.command("tables")
def bench_tables(
    scanner: Annotated[Path | None, typer.Option(help="scanner.toml; default: the paper's prototype.")] = None,
) -> None:
    """Building both calibration tables."""
    design = _design(scanner)
    for size, target_ms in (((582, 500), 10.0), ((2448, 2048), 200.0)):
        low, middle = stripe_bench.time_tables(design, *size)
        STDOUT.print(f"both tables {size[0]}x{size[1]}: {low:.1f} / {middle:.1f} ms (target {target_ms:.0f})")


@bench_app.command("foot")
def bench_foot(
    points: Annotated[int, typer.Option(help="Points of the cloud.", min=20000, max=2000000)] = 100_000,
    repeats: Annotated[int, typer.Option(help="Runs of each step.", min=2, max=100)] = 5,
) -> None:
    """Cloud -> surface -> mesh -> measurements, and a section, beside geomdl's fit and trimesh's cut."""
    with announce_compilation(STDERR.print):
        timings = foot_bench.time_foot(points, repeats)
    table = Table(title="ms: minimum / median")
    for column in ("step", "footscan", "target", "baseline", "ms", "times as fast"):
        table.add_column(column, justify="right" if column != "step" else "left")
    for t in timings:
        own = f"{t.ours_ms[0]:.1f} / {t.ours_ms[1]:.1f}"
        target = "" if t.target_ms is None else f"{t.target_ms:.0f}"
        other = "" if t.baseline_ms is None else f"{t.baseline_ms[0]:.1f} / {t.baseline_ms[1]:.1f}"
        ratio = "" if t.baseline_ms is None else f"{t.baseline_ms[1] / t.ours_ms[1]:.1f}"
        table.add_row(t.step, own, target, t.baseline, other, ratio)
    STDOUT.print(table)


@bench_app.command("process")
def bench_process(
    times: Annotated[int, typer.Option(help="How many times the frames the long recording has.", min=2, max=100)] = 10,
    repeats: Annotated[int, typer.Option(help="Runs of the short recording.", min=1, max=50)] = 3,
) -> None:
    """A recording of 480 frames from PNG to report, as a process of its own, and many times the frames."""
    short, long = process_bench.time_process(_design(None), times, repeats)
    for run in (short, long):
        STDOUT.print(
            f"{run.frames} frames: {run.wall_s:.2f} s wall, {run.stages_s:.2f} s in stages, "
            f"{run.loop_s:.2f} s frame loop, {run.peak_mb:.0f} MB peak"
        )
    loop, stages = long.loop_s / short.loop_s, long.stages_s / short.stages_s
    STDOUT.print(f"{times} times the frames: frame loop {loop:.1f} times, all stages {stages:.1f} times the time")


@bench_app.command("calibration")
def bench_calibration(
    recording: Annotated[
        Path | None, typer.Argument(help="Calibration recording; default: one of a simulated machine.")
    ] = None,
    repeats: Annotated[int, typer.Option(help="Runs, after one that is not counted.", min=1, max=50)] = 3,
) -> None:
    """From a calibration recording to an accepted calibration, beside OpenCV finding the board alone."""
    with tempfile.TemporaryDirectory() as place, announce_compilation(STDERR.print):
        folder = recording
        if folder is None:
            folder = Path(place) / "recording"
            simulate_board(_design(None), DEFAULT_CALIBRATION_PLAN, 1, folder, lambda done, total: None)
        timing = machines_study.time_calibration(folder, repeats)
    wall, cpu, alone = (
        f"{min(s):.1f} / {statistics.median(s):.1f}" for s in (timing.wall_s, timing.cpu_s, timing.board_alone_s)
    )
    ratio = statistics.median(timing.wall_s) / statistics.median(timing.board_alone_s)
    STDOUT.print(
        f"{timing.frames} frames to a calibration: {wall} s (minimum / median; target 30), {cpu} s of one core"
    )
    STDOUT.print(f"OpenCV finding the board in the unlit frames alone: {alone} s; {ratio:.1f} times that in all")


@bench_app.command("session")
def bench_session_command(
    rate: Annotated[
        list[float] | None,
        typer.Option(help="Frames a second; several are tried in turn.", min=1, max=2000),
    ] = None,
    slowed: Annotated[
        float, typer.Option(help="Seconds that processing is held up at each frame, on purpose.", min=0, max=5)
    ] = 0.0,
) -> None:
    """A whole scan at high frame rates, pictures made beforehand: what is kept, and how fast it reaches the disk."""
    rig = chosen_rig(None, fast=False)
    calibration = rig_app.true_machine(rig).calibration
    with announce_compilation(STDERR.print):
        setup = SessionSetup(rig.scanner, rig.motion, calibration, build_tables(calibration))
        for frames_per_s in rate or (25.0, 100.0, 200.0):
            run = session_bench.bench_session(rig, rig_app.open_rig(rig), setup, frames_per_s, slowed)
            frames, live = run.frames, run.live
            STDOUT.print(
                f"{frames_per_s:5.0f} frames/s: {frames.captured} captured, {frames.kept} kept, rejected: "
                f"{_counted(frames.rejected)}, {frames.lost} lost; {run.sustained_per_s:.0f} frames/s from camera to "
                f"disk; live view {live.shown} of {live.given} shown, skipped: {_counted(live.skipped)}"
            )


def _counted(reasons: dict[str, int]) -> str:
    return ", ".join(f"{count} {why}" for why, count in reasons.items()) or "none"


@bench_app.command("picture")
def bench_picture(
    frames: Annotated[int, typer.Option(help="Pictures timed of each object.", min=5, max=10000)] = 100,
    scanner: Annotated[Path | None, typer.Option(help="scanner.toml; default: the paper's prototype.")] = None,
    mesh: Annotated[Path | None, typer.Option(help="Mesh of a foot in metres, timed too.")] = None,
) -> None:
    """The simulator's pictures a second, one thread: all heads of a turn, both lasers in turn."""
    with announce_compilation(STDERR.print):
        for timing in picture_bench.time_pictures(_design(scanner), frames, mesh):
            low, middle = timing.ms
            STDOUT.print(
                f"{timing.name}, {timing.size}: {low:.1f} / {middle:.1f} ms a picture (minimum / median), "
                f"{1000 / middle:.0f} a second in the middle (target 50)"
            )


@bench_app.command("lasts")
def bench_lasts(
    repeats: Annotated[int, typer.Option(help="Runs of each step.", min=1, max=50)] = 3,
) -> None:
    """Rank, compare, customise and distances to a last; wall and processor seconds."""
    with announce_compilation(STDERR.print):
        timings = lasts_bench.time_lasts(repeats)
    table = Table(title="seconds: minimum / median on the clock, minimum of the processor")
    for column in ("step", "clock", "processor", "target", "baseline", "s"):
        table.add_column(column, justify="right" if column != "step" else "left")
    for t in timings:
        target = "" if t.target_s is None else f"{t.target_s:g}"
        other = "" if t.baseline_s is None else f"{t.baseline_s:.2f}"
        table.add_row(t.step, f"{t.wall_s[0]:.2f} / {t.wall_s[1]:.2f}", f"{t.cpu_s:.2f}", target, t.baseline, other)
    STDOUT.print(table)
