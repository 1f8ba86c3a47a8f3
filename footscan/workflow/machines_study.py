"""Seeded workshop machines, each calibrated from its own simulated recording and held against the exact machine."""

import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from footscan.calibration.calibrate import Calibrated, calibrate_intake, calibrate_recording
from footscan.calibration.charuco import BoardFinder
from footscan.calibration.synthetic import SyntheticPlan, make_intake
from footscan.calibration.uncertainty import expected_error_mm, machine_difference_mm
from footscan.config import DEFAULT_BOARD
from footscan.coordinates import LaserName
from footscan.errors import FootscanError
from footscan.optics.calibration import Calibration
from footscan.optics.scanner import Scanner
from footscan.scanning.frames import read_frame
from footscan.scanning.recording import open_recording
from footscan.scanning.sweep import Progress
from footscan.sim.calibration_run import CalibrationPlan
from footscan.sim.machine import workshop_machine
from footscan.workflow.simulate import simulate_board

MOST_RMS_MM = 0.08
MOST_RATIO, RATIO_RMS = 3.0, (0.5, 2.0)


@dataclass(frozen=True)
class MachineOutcome:
    """One machine.

    Attributes:
        seed: Which one.
        rms_mm: True error in the working volume, per laser; empty where the calibration was refused.
        expected_mm: The error that the calibration itself expects.
        latency_error_ms: Found minus true latency.
        refused: Why no calibration came out; empty otherwise.
    """

    seed: int
    rms_mm: dict[LaserName, float]
    expected_mm: dict[LaserName, float]
    latency_error_ms: float
    refused: str = ""

    @property
    def ratios(self) -> list[float]:
        """True over expected error, per laser."""
        return [self.rms_mm[name] / self.expected_mm[name] for name in self.rms_mm]


def run_machines(
    scanner: Scanner, seeds: Iterable[int], pictures: bool, progress: Progress = lambda done, total: None
) -> list[MachineOutcome]:
    """Calibrate machines by their seeds, from simulated pictures or (fast) from points with the noise of pictures."""
    chosen = list(seeds)
    outcomes: list[MachineOutcome] = []
    for done, seed in enumerate(chosen, start=1):
        outcomes.append(_from_pictures(scanner, seed) if pictures else _from_points(scanner, seed))
        progress(done, len(chosen))
    return outcomes


def _from_pictures(scanner: Scanner, seed: int) -> MachineOutcome:
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "recording"
        simulate_board(scanner, CalibrationPlan(), seed, folder, lambda done, total: None)
        truth = workshop_machine(scanner, seed).calibration
        try:
            return _outcome(seed, calibrate_recording(open_recording(folder)), truth)
        except FootscanError as err:
            return MachineOutcome(seed, {}, {}, float("nan"), str(err))


def _from_points(scanner: Scanner, seed: int) -> MachineOutcome:
    truth = workshop_machine(scanner, seed).calibration
    known = replace(scanner, encoder=replace(scanner.encoder, zero_count=truth.encoder.zero_count))
    intake, made = make_intake(truth, known, DEFAULT_BOARD, SyntheticPlan(seed=seed, stripe_step_mm=3.0))
    try:
        return _outcome(seed, calibrate_intake(intake, made.sightings.stripes), truth)
    except FootscanError as err:
        return MachineOutcome(seed, {}, {}, float("nan"), str(err))


def _outcome(seed: int, found: Calibrated, truth: Calibration) -> MachineOutcome:
    off, expected = machine_difference_mm(found.calibration, truth), expected_error_mm(found.joint.fit)
    return MachineOutcome(
        seed,
        {name: float(np.sqrt(np.mean(d**2))) for name, d in off.items()},
        {name: float(np.sqrt(np.mean(e**2))) for name, e in expected.items()},
        1e3 * (found.calibration.latency_s - truth.latency_s),
    )


def ratio_rms(outcomes: list[MachineOutcome]) -> float:
    """RMS of true over expected error, all machines and lasers."""
    ratios = [ratio for outcome in outcomes for ratio in outcome.ratios]
    return float(np.sqrt(np.mean(np.square(ratios)))) if ratios else float("nan")


def missed(outcomes: list[MachineOutcome]) -> list[str]:
    """Which limits are broken, in words; empty when all are kept."""
    said = [f"machine {o.seed} was refused: {o.refused}" for o in outcomes if o.refused]
    for o in outcomes:
        said += [f"machine {o.seed}, {name}: {rms:.3f} mm RMS" for name, rms in o.rms_mm.items() if rms > MOST_RMS_MM]
        said += [f"machine {o.seed}: {r:.1f} times the expected error" for r in o.ratios if r > MOST_RATIO]
    if not RATIO_RMS[0] <= ratio_rms(outcomes) <= RATIO_RMS[1]:
        said.append(f"true over expected error {ratio_rms(outcomes):.2f} RMS, wanted {RATIO_RMS[0]} to {RATIO_RMS[1]}")
    return said


@dataclass(frozen=True)
class CalibrationTiming:
    """Seconds from recording to calibration, and of what OpenCV needs to find the board in the unlit frames alone."""

    frames: int
    wall_s: tuple[float, ...]
    cpu_s: tuple[float, ...]
    board_alone_s: tuple[float, ...]


def time_calibration(folder: Path, repeats: int) -> CalibrationTiming:
    """Calibrate from a recording `repeats` times, after one run that is not counted; OpenCV alone in the same turns."""
    recording = open_recording(folder)
    assert recording.board is not None
    unlit = [record for record in recording.frames if record.laser == "none"]
    calibrate_recording(recording)
    wall: list[float] = []
    cpu: list[float] = []
    alone: list[float] = []
    for _ in range(repeats):
        begin, used = time.perf_counter(), time.process_time()
        calibrate_recording(recording)
        wall.append(time.perf_counter() - begin)
        cpu.append(time.process_time() - used)
        begin, finder = time.perf_counter(), BoardFinder(recording.board)
        for record in unlit:
            finder.markers(read_frame(recording.path(record), recording.scanner.camera))
        alone.append(time.perf_counter() - begin)
    return CalibrationTiming(len(recording.frames), tuple(wall), tuple(cpu), tuple(alone))
