"""Simulated recordings, and the demo: simulate, process, compare with the truth."""

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from footscan.config import load_calibration
from footscan.config.toml_file import write_whole
from footscan.coordinates import Side
from footscan.optics.scanner import Scanner
from footscan.scanning.recording import open_recording
from footscan.scanning.sweep import Progress
from footscan.sim.machine import ideal_machine, workshop_machine
from footscan.sim.motion import SweepPlan
from footscan.sim.objects import build_object
from footscan.sim.record import prepare_scan, simulate_recording
from footscan.sim.surface import Surface
from footscan.workflow.process import ProcessSettings, process_recording
from footscan.workflow.results import save_results
from footscan.workflow.truth import distance_to_surface_mm

DEMO_MARK = ".footscan-demo"


@dataclass(frozen=True)
class SimulateSettings:
    """What stands on the board, and on which machine: a workshop machine by seed, or the ideal one (seed None)."""

    thing: str
    unit: str = "mm"
    side: Side = "left"
    seed: int | None = None
    frames_per_sweep: int = 240
    size: float = 1.0


def simulate_scan(scanner: Scanner, settings: SimulateSettings, folder: Path, progress: Progress) -> Surface:
    """Write the recording of one simulated scan; returns the surface that stood on the board.

    Raises:
        InputError: No such object, a wrong unit, an impossible size.
        RecordingError: The folder already holds a recording.
        StorageError: The folder cannot be written.
    """
    surface = build_object(settings.thing, settings.unit, settings.side, settings.size)
    machine = ideal_machine(scanner) if settings.seed is None else workshop_machine(scanner, settings.seed)
    plan = SweepPlan(frames_per_sweep=settings.frames_per_sweep)
    scan = prepare_scan(machine, surface, plan, seed=settings.seed or 0)
    simulate_recording(folder, scan, settings.side, f"simulated: {settings.thing}", progress=progress)
    return scan.surface


@dataclass(frozen=True)
class DemoResult:
    """Where the demo's files lie, and what it has to say."""

    folder: Path
    rms_mm: float
    lines: list[str]


def run_demo(scanner: Scanner, seed: int, folder: Path, progress: Progress, frames_per_sweep: int = 240) -> DemoResult:
    """Simulate a scan of the built-in foot, process it with the machine's true calibration, compare with the truth.

    Raises:
        FootscanError: As `simulate_scan` and `process_recording`.
    """
    recording, results = folder / "recording", folder / "results"
    if (folder / DEMO_MARK).is_file():
        shutil.rmtree(recording, ignore_errors=True)
    elif not recording.exists():
        write_whole(folder / DEMO_MARK, b"made by footscan demo; replaced by the next one\n")
    settings = SimulateSettings("foot", side="left", seed=seed, frames_per_sweep=frames_per_sweep)
    surface = simulate_scan(scanner, settings, recording, progress)
    process = ProcessSettings()
    calibration = load_calibration(recording / "truth-calibration.toml")
    result = process_recording(open_recording(recording), calibration, process)
    report = save_results(result, process, results)
    off_mm = distance_to_surface_mm(result.cloud.xyz_world, surface.xyz_world, surface.faces)
    rms_mm = float(np.sqrt(np.mean(off_mm**2)))
    return DemoResult(folder, rms_mm, _lines(report, rms_mm, float(np.median(off_mm)), results))


def _lines(report: dict[str, object], rms_mm: float, median_mm: float, results: Path) -> list[str]:
    frames, points, seconds = report["frames"], report["points"], report["seconds"]
    assert isinstance(frames, dict)
    assert isinstance(points, dict)
    assert isinstance(seconds, dict)
    return [
        f"{frames['used']} of {frames['seen']} frames used, {points['kept']} points kept, "
        f"processed in {sum(seconds.values()):.1f} s",
        f"against the true foot: {rms_mm:.3f} mm RMS, {median_mm:.3f} mm median",
        f"look at {results / 'report.png'} and {results / 'preview.png'}; the foot is in {results / 'surface.stl'}",
    ]
