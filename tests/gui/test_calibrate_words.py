"""What the technician reads: the page's own fields and next steps, no command's options, nothing outdated."""

from dataclasses import replace
from pathlib import Path

import pytest

from footscan.calibration.quality import SCALE_UNVERIFIED
from footscan.gui import texts
from footscan.gui.panel_machine import machine_words
from footscan.gui.state import CalibrationChoice
from footscan.gui.tab_calibrate import placements_html
from footscan.gui.visit_calibrate import lengths_afterwards
from footscan.scanning.session.states import Snapshot, State
from footscan.workflow.guided_calibration import PlacementReport

OPEN = CalibrationChoice(
    Path("recording"), (PlacementReport("1", 16, (0.1, 0.2, 0.3), 71),), "expected error 0.017 mm", enough=True
)


def test_the_scale_note_names_the_fields_of_the_page_and_no_option() -> None:
    words = f"{SCALE_UNVERIFIED} {lengths_afterwards()}"

    assert texts.BOARD_ROW in words and texts.BOARD_COLUMN in words
    assert "--" not in words


def test_a_recording_that_is_closed_is_not_asked_for_another_placement() -> None:
    open_words, closed_words = placements_html(OPEN), placements_html(replace(OPEN, recorded=True))

    assert texts.CALIBRATE_ENOUGH in open_words and texts.CALIBRATE_RECORDED not in open_words
    assert texts.CALIBRATE_ENOUGH not in closed_words and texts.CALIBRATE_RECORDED in closed_words
    assert "71 corners" in closed_words
    assert placements_html(CalibrationChoice()) == ""


@pytest.mark.parametrize("choice", [CalibrationChoice(), replace(OPEN, recorded=True)])
def test_nobody_is_invited_on_to_the_board_while_the_calibration_is_recorded(choice: CalibrationChoice) -> None:
    parked = Snapshot(State.PARKED)

    assert machine_words(parked, OPEN) == texts.CALIBRATE_PARKED
    assert machine_words(parked, choice) == State.PARKED.value
    assert machine_words(Snapshot(State.PARKED, "no encoder counts"), OPEN) == "no encoder counts"


def test_a_closed_machine_says_what_opens_it_again() -> None:
    assert texts.EXAMINE in machine_words(Snapshot(State.CLOSED), CalibrationChoice())


def test_a_machine_whose_head_has_no_home_says_which_button_finds_it() -> None:
    assert texts.CHECK.split()[-1] in machine_words(Snapshot(State.CONNECTED), CalibrationChoice())
