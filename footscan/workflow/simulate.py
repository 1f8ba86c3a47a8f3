"""Simulated recordings, and the demo: simulate, process, compare with the truth."""

import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from footscan.config import Subject, load_calibration
from footscan.config.toml_file import write_whole
from footscan.coordinates import Side
from footscan.foot.wedge import FLAT_MM
from footscan.optics.scanner import Scanner
from footscan.scanning.recording import open_recording
from footscan.scanning.sweep import Progress
from footscan.sim.artefacts import ARTEFACT_NAMES, USUAL_ARTEFACT, ArtefactChoice, build_artefact
from footscan.sim.calibration_run import CalibrationPlan, prepare_calibration, simulate_calibration
from footscan.sim.foot import FootShape
from footscan.sim.machine import TrueMachine, ideal_machine, workshop_machine
from footscan.sim.motion import SweepPlan
from footscan.sim.objects import build_object
from footscan.sim.obstacles import build_obstacle
from footscan.sim.picture import DEFAULT_PICTURE
from footscan.sim.record import prepare_scan, simulate_recording
from footscan.sim.surface import Surface
from footscan.sim.wedge import raise_heel
from footscan.workflow.process import ProcessSettings, process_recording
from footscan.workflow.results import save_results
from footscan.workflow.truth import distance_to_surface_mm

DEMO_MARK = ".footscan-demo"


@dataclass(frozen=True)
class SimulateSettings:
    """What stands on the board, and on which machine.

    Attributes:
        thing: A named object or the path of a mesh file.
        unit: Of the mesh file: mm, cm or m.
        side: Of the foot.
        seed: A workshop machine by its seed, or the ideal one (None).
        frames_per_sweep: Pictures of one turn.
        size: Of the built-in foot.
        arch: Of the built-in foot: 0 flat, 1 usual, 1.5 high.
        hallux_valgus_rad: How far the big toe of the built-in foot leans to the others.
        missing_toes: Numbers of its amputated toes; the recording names them as absent.
        obstacles: Names of what stands beside or around the foot.
        unlit_every: Every n-th frame is taken without a laser; 0 is none.
        alternating: One sweep with the lasers in turn, instead of one sweep for either.
        exposure: Of the camera, relative.
        artefact: Size and place of a sphere, ball bar or plane.
        wedge_mm: Height of a wedge under the middle of the heel; the foot is bent on to it. 0 is the flat board.
    """

    thing: str
    unit: str = "mm"
    side: Side = "left"
    seed: int | None = None
    frames_per_sweep: int = 240
    size: float = 1.0
    arch: float = 1.0
    hallux_valgus_rad: float = 0.0
    missing_toes: tuple[int, ...] = ()
    obstacles: tuple[str, ...] = ()
    unlit_every: int = 0
    alternating: bool = False
    exposure: float = 1.0
    artefact: ArtefactChoice = USUAL_ARTEFACT
    wedge_mm: float = 0.0


def simulate_scan(scanner: Scanner, settings: SimulateSettings, folder: Path, progress: Progress) -> Surface:
    """Write the recording of one simulated scan; returns the surface that stood on the board.

    Raises:
        InputError: No such object or obstacle, a wrong unit, an impossible size.
        RecordingError: The folder already holds a recording.
        StorageError: The folder cannot be written.
    """
    artefact = build_artefact(settings.thing, settings.artefact) if settings.thing in ARTEFACT_NAMES else None
    surface = (
        artefact.surface
        if artefact is not None
        else build_object(settings.thing, settings.unit, settings.side, settings.size, _shape(settings))
    )
    beside = tuple(part for name in settings.obstacles for part in build_obstacle(name, surface, settings.side))
    if settings.wedge_mm > FLAT_MM:
        raised = raise_heel(surface, settings.side, settings.wedge_mm)
        surface, beside = raised.surface, (raised.body, *beside)
    plan = SweepPlan(
        frames_per_sweep=settings.frames_per_sweep,
        unlit_every=settings.unlit_every,
        alternating=settings.alternating,
    )
    picture = replace(DEFAULT_PICTURE, exposure=settings.exposure)
    scan = prepare_scan(_machine(scanner, settings.seed), surface, plan, picture, settings.seed or 0, beside)
    notes = ", ".join([f"simulated: {settings.thing}", *settings.obstacles])
    subject = Subject(
        absent=tuple(f"toe_{number}" for number in sorted(set(settings.missing_toes))),
        wedge_mm=settings.wedge_mm or None,
    )
    simulate_recording(folder, scan, settings.side, notes, progress=progress, artefact=artefact, subject=subject)
    return scan.surface


def _shape(settings: SimulateSettings) -> FootShape:
    missing = tuple(sorted(set(settings.missing_toes)))
    return FootShape(settings.side, settings.size, settings.arch, settings.hallux_valgus_rad, missing)


def simulate_board(scanner: Scanner, plan: CalibrationPlan, seed: int | None, folder: Path, progress: Progress) -> None:
    """Write the calibration recording of a simulated machine: a workshop machine by its seed, or the ideal one (None).

    Raises:
        InputError: A plan or a board that the machine cannot hold.
        RecordingError: The folder already holds a recording.
        StorageError: The folder cannot be written.
    """
    run = prepare_calibration(_machine(scanner, seed), plan, seed=seed or 0)
    simulate_calibration(folder, run, "simulated: board", progress=progress)


def _machine(scanner: Scanner, seed: int | None) -> TrueMachine:
    return ideal_machine(scanner) if seed is None else workshop_machine(scanner, seed)


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
