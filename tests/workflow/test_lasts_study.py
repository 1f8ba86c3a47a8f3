"""Deformed feet of the study are deformed, and their customised lasts hold them."""

from pathlib import Path

import pytest

from footscan.shoelast.customise import CustomSettings
from footscan.shoelast.last_library import LastLibrary
from footscan.workflow.lasts_study import DEFORMITIES, StudyCase, lasts_study_cases, run_lasts_study

FOUR = tuple(StudyCase(k, "right" if k % 2 else "left", 0.97, name, 0.9) for k, name in enumerate(DEFORMITIES[1:]))


@pytest.mark.parametrize("case", FOUR, ids=[one.deformity for one in FOUR])
def test_the_customised_last_holds_a_deformed_foot(case: StudyCase, tmp_path: Path):
    (outcome,) = run_lasts_study((case,), LastLibrary(tmp_path), CustomSettings())

    assert outcome.reason == ""
    assert outcome.well


def test_fifty_cases_hold_every_deformity_on_both_sides():
    cases = lasts_study_cases(50)

    assert {case.deformity for case in cases} == set(DEFORMITIES)
    assert {case.side for case in cases} == {"left", "right"}
    assert cases == lasts_study_cases(50)
