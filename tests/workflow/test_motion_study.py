import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from footscan.scanning.motion import WHOLE_FOOT
from footscan.sim.motion import SweepPlan
from footscan.sim.person import Move
from footscan.workflow.imperfect_calibration import imperfect_calibration, world_points_off_mm
from footscan.workflow.motion_scans import ScanPlan, Visitor, judge_seen, see_scan
from footscan.workflow.motion_study import (
    CALIBRATION_ERRORS_MM,
    CALIBRATIONS,
    SHIFTS_MM,
    outcome_report,
    run_study,
    study_cases,
    tally,
)


def test_a_study_is_half_still_half_moved_and_the_same_again_with_its_seed():
    cases = study_cases(40, 7)

    assert cases == study_cases(40, 7)
    assert cases != study_cases(40, 8)
    assert sum(case.zone is None for case in cases) == 20
    assert {case.zone for case in cases if case.zone} == {WHOLE_FOOT, "heel", "midfoot", "ball", "toes", "ankle"}
    for move in (move for case in cases for move in case.visitor.moves):
        way_mm = np.linalg.norm(move.shift_mm)
        assert abs(move.turn_rad) == pytest.approx(np.radians(1.0)) or SHIFTS_MM[0] <= way_mm <= SHIFTS_MM[1]


@pytest.mark.parametrize("error_mm", CALIBRATION_ERRORS_MM)
def test_an_imperfect_calibration_is_off_by_what_is_asked(ideal, error_mm):
    found = imperfect_calibration(ideal, error_mm, 3)

    assert world_points_off_mm(ideal, found) == pytest.approx(error_mm, rel=0.05)
    assert found != imperfect_calibration(ideal, error_mm, 4)
    assert found.floor == ideal.floor


def test_a_small_sample_of_the_study_is_judged_rightly(prototype):
    cases = [case for case in study_cases(8, 11) if case.seed % 1000 in (0, 1, 7)]
    outcomes = run_study(prototype, cases, frames_per_sweep=120)

    assert [outcome.right for outcome in outcomes] == [True] * 6
    assert outcome_report(outcomes[2])["zone"] == WHOLE_FOOT


def test_a_head_that_turns_farther_sees_in_which_sweep_the_foot_moved(prototype):
    plan = ScanPlan(SweepPlan(frames_per_sweep=124), turn_rad=np.radians(375.0))
    during = Visitor(size=0.9, moves=(Move("foot", (1.5, 1.5, 0.0), at_s=0.7 * 124 / 20.0),))
    seen = see_scan(prototype, during, plan, 21)
    result = judge_seen(seen, seen.truth)

    assert result.finding is not None
    assert result.finding.when == "during sweep 1"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3])
def test_the_study_reaches_its_target(prototype, seed):
    shared = Path(os.environ.get("FOOTSCAN_SHARED", "")) / "data/feet"
    outcomes = run_study(prototype, study_cases(40, seed, tuple(sorted(shared.glob("*_foot.stl")))))

    for calibration in CALIBRATIONS:
        count = tally(outcomes, calibration)
        assert (count.moved, count.still) == (20, 20)
        assert count.moved_found >= 19
        assert count.still_called_moved <= 1


def test_tallies_count_a_wrong_zone_as_not_found(prototype):
    (case,) = study_cases(2, 11)[1:]
    outcomes = run_study(prototype, [replace(case, zone="heel")], frames_per_sweep=60)

    assert tally(outcomes, "true").moved_found == 0
