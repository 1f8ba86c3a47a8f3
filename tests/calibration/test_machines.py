"""Machines as workshops build them: simulated calibration recordings, calibrated, and compared with the truth.

Three are part of `make test` as points without pictures; twenty with pictures are slow (`make drill`).
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from footscan.calibration.calibrate import calibrate_recording
from footscan.calibration.estimate import start_estimate
from footscan.calibration.solve import Fit, fit_estimate
from footscan.calibration.synthetic import SyntheticPlan, make_sightings
from footscan.calibration.uncertainty import expected_error_mm, machine_difference_mm
from footscan.calibration.unknowns import EVERYTHING
from footscan.config import DEFAULT_BOARD
from footscan.errors import PoorFitError
from footscan.optics import Calibration
from footscan.optics.scanner import Scanner, calibration_from_design
from footscan.scanning.recording import open_recording
from footscan.sim.board import PrintFaults
from footscan.sim.calibration_run import CalibrationPlan, MovedBoard
from footscan.sim.machine import workshop_machine
from footscan.workflow.simulate import simulate_board


def _errors_mm(found: Calibration, truth: Calibration, fit: Fit) -> tuple[list[float], list[float]]:
    """RMS error in the working volume per laser, and its ratio to the expected one."""
    true, expected = machine_difference_mm(found, truth), expected_error_mm(fit)
    rms = [float(np.sqrt(np.mean(true[name] ** 2))) for name in true]
    return rms, [r / float(np.sqrt(np.mean(expected[name] ** 2))) for r, name in zip(rms, true, strict=True)]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_workshop_machine_is_found_from_its_design_and_points(prototype: Scanner, seed: int):
    machine = workshop_machine(prototype, seed).calibration
    machine = replace(machine, encoder=replace(machine.encoder, eccentricity_rad=0.0))
    made = make_sightings(machine, DEFAULT_BOARD, SyntheticPlan(seed=seed, stripe_step_mm=3.0))
    design = replace(calibration_from_design(prototype), encoder=machine.encoder)
    fit = fit_estimate(start_estimate(design, made.truth.world_from_board), made.sightings, EVERYTHING)
    rms_mm, ratios = _errors_mm(fit.estimate.machine, machine, fit)

    assert max(rms_mm) < 0.05
    assert max(ratios) < 3.0
    assert abs(fit.estimate.machine.latency_s - machine.latency_s) < 1e-3


@pytest.mark.slow
def test_twenty_simulated_machines_are_found_and_the_expected_error_is_honest(prototype: Scanner, tmp_path: Path):
    every_rms, every_ratio = [], []
    for seed in range(1, 21):
        folder = tmp_path / str(seed)
        simulate_board(prototype, CalibrationPlan(), seed, folder, lambda done, total: None)
        result = calibrate_recording(open_recording(folder))
        rms_mm, ratios = _errors_mm(result.calibration, workshop_machine(prototype, seed).calibration, result.joint.fit)
        every_rms += rms_mm
        every_ratio += ratios

    assert max(every_rms) < 0.08
    assert 0.5 < float(np.sqrt(np.mean(np.square(every_ratio)))) < 2.0
    assert max(every_ratio) < 3.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("plan", "reason"),
    [
        (CalibrationPlan(faults=PrintFaults(scale_x=1.002)), "print scale unequal"),
        (CalibrationPlan(faults=PrintFaults(bow_mm=1.0)), "bent"),
        (CalibrationPlan(moved=MovedBoard(2, 13)), "placement 2: the board was moved by 1.0 mm"),
    ],
)
def test_a_simulated_fault_of_the_board_is_refused_by_its_name(
    prototype: Scanner, tmp_path: Path, plan: CalibrationPlan, reason: str
):
    simulate_board(prototype, plan, 4, tmp_path / "faulty", lambda done, total: None)

    with pytest.raises(PoorFitError, match=reason):
        calibrate_recording(open_recording(tmp_path / "faulty"))
