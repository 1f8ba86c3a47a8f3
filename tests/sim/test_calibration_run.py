import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from footscan.config import Board
from footscan.coordinates import Floats
from footscan.errors import InputError
from footscan.optics.calibration import theta_from_encoder
from footscan.scanning.recording import Recording, open_recording
from footscan.sim.board import PrintFaults
from footscan.sim.calibration_run import (
    DEFAULT_CALIBRATION_PLAN,
    PLACEMENTS,
    CalibrationPlan,
    MovedBoard,
    prepare_calibration,
    simulate_calibration,
)
from footscan.sim.machine import TrueMachine

SMALL = CalibrationPlan(placements=PLACEMENTS[:2], stops=3, sweep_frames=4)


@pytest.fixture(scope="module")
def folder(machine: TrueMachine, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("calibration") / "run"
    simulate_calibration(folder, prepare_calibration(machine, SMALL, seed=4))
    return folder


@pytest.fixture(scope="module")
def recording(folder: Path) -> Recording:
    return open_recording(folder)


def test_every_placement_and_the_empty_board_have_every_stop_in_every_light(recording: Recording):
    static = Counter((record.setup, record.laser) for record in recording.frames if record.sweep == "static")
    moving = Counter((record.setup, record.laser, record.sweep) for record in recording.frames[-8:])

    assert recording.info.kind == "calibration"
    assert recording.board == SMALL.board
    assert static == {(setup, laser): 3 for setup in ("0", "1", "empty") for laser in ("none", "right", "left")}
    assert moving == {("0", "none", "ccw"): 4, ("0", "none", "cw"): 4}


def test_counts_give_the_true_angles_once_the_latency_is_known(
    machine: TrueMachine, folder: Path, recording: Recording
):
    truth = json.loads((folder / "truth-board.json").read_text())
    exposure_s = np.array([record.time_s for record in recording.frames]) - machine.calibration.latency_s
    count = np.interp(exposure_s, recording.encoder.time_s, recording.encoder.count)
    theta = theta_from_encoder(count, machine.calibration.encoder)

    assert np.max(np.abs(theta - truth["theta_rad"])) < np.pi / 8000
    assert np.ptp(theta[-8:]) > np.deg2rad(60.0)


def test_whole_recording_has_the_size_of_a_workshop_calibration(machine: TrueMachine):
    schedule = prepare_calibration(machine).schedule

    assert len(schedule) == 7 * 24 * 3 + 80
    assert len({job.setup for job in schedule}) == 7


def lowest_mm(machine: TrueMachine, plan: CalibrationPlan, seed: int) -> Floats:
    boards = {id(job.board): job.board for job in prepare_calibration(machine, plan, seed=seed).schedule if job.board}
    return np.array([board.surface.xyz_world[:, 2].min() for board in boards.values()])


@pytest.mark.parametrize("seed", range(4))
def test_no_board_reaches_into_the_footboard(machine: TrueMachine, seed: int):
    low_mm = lowest_mm(machine, DEFAULT_CALIBRATION_PLAN, seed)

    assert len(low_mm) == 6
    assert low_mm.min() >= 1.99
    assert low_mm.max() < 60.0


def test_a_board_slips_at_its_stop_and_stays_there(machine: TrueMachine):
    plan = replace(SMALL, moved=MovedBoard(1, 2, (1.0, 0.0, 0.0)))
    schedule = prepare_calibration(machine, plan).schedule
    one = [job.board for job in schedule if job.setup == "1"]
    zero = {id(job.board) for job in schedule if job.setup == "0"}
    middle = [np.mean(board.corners_world(), axis=0) for board in one if board is not None]

    assert len(zero) == 1
    assert np.allclose(np.diff(middle, axis=0)[:5], 0.0)
    assert np.allclose(middle[6] - middle[5], [1.0, 0.0, 0.0])
    assert np.allclose(np.diff(middle, axis=0)[6:], 0.0)


def test_what_cannot_be_recorded_is_said(machine: TrueMachine):
    large = Board(11, 9, 30.0, 22.0, "DICT_4X4_50")
    with pytest.raises(InputError, match=r"a board of 330 x 270 mm reaches .*choose a smaller board"):
        prepare_calibration(machine, replace(SMALL, board=large))
    with pytest.raises(InputError, match="placement 5, but there are placements 0 to 1"):
        prepare_calibration(machine, replace(SMALL, moved=MovedBoard(5, 1)))
    with pytest.raises(InputError, match="at least 1 placement"):
        prepare_calibration(machine, replace(SMALL, placements=()))


def test_faults_are_in_the_truth_and_not_in_the_board_file(machine: TrueMachine, tmp_path: Path):
    faults = PrintFaults(1.002, 0.999, 1.0)
    plan = CalibrationPlan(placements=PLACEMENTS[:1], stops=1, sweep_frames=0, faults=faults)
    simulate_calibration(tmp_path / "run", prepare_calibration(machine, plan))
    truth = json.loads((tmp_path / "run" / "truth-board.json").read_text())

    assert truth["faults"] == {"scale_x": 1.002, "scale_y": 0.999, "bow_mm": 1.0}
    assert open_recording(tmp_path / "run").board == plan.board
