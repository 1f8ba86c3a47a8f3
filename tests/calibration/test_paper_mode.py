"""The paper's own model beside the joint estimate: exact for its own machine, and what it costs on a real one."""

import numpy as np
import pytest

from footscan.calibration.calibrate import calibrate_intake
from footscan.calibration.joint import JointFit
from footscan.calibration.paper_mode import compare_with_paper, upright
from footscan.calibration.synthetic import SyntheticPlan, make_intake
from footscan.config import DEFAULT_BOARD
from footscan.optics import Calibration
from footscan.optics.scanner import Scanner


def _joint(machine: Calibration, design: Scanner) -> JointFit:
    intake, made = make_intake(machine, design, DEFAULT_BOARD, SyntheticPlan(seed=2, stripe_step_mm=3.0))
    return calibrate_intake(intake, made.sightings.stripes).joint


def test_on_the_papers_own_machine_both_agree(ideal: Calibration, prototype: Scanner):
    found = compare_with_paper(_joint(upright(ideal), prototype))

    assert max(found.off_mm.values()) < 0.04
    assert found.misfit_px[0] == pytest.approx(found.misfit_px[1], rel=0.05)
    assert found.focal_length_mm[0] == pytest.approx(found.focal_length_mm[1], rel=0.01)


def test_on_a_crooked_machine_one_angle_per_sheet_misses_by_what_the_sheets_lean_and_miss_the_axis(
    crooked: Calibration, prototype: Scanner
):
    found = compare_with_paper(_joint(crooked, prototype))

    assert min(found.off_mm.values()) > 0.1
    assert found.misfit_px[0] > 1.5 * found.misfit_px[1]
    assert any("held: lean and offset of both sheets" in line for line in found.lines())
    assert np.all(np.isfinite(list(found.off_mm.values())))
