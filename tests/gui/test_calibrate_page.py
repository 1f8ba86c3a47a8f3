"""The technician's tab in a real browser: a new calibration is computed, looked at, and put in force."""

import re

import pytest

from footscan.app import true_machine
from footscan.gui import texts
from footscan.gui.visitor import Visitor as Operator
from footscan.sim.calibration_run import PLACEMENTS, CalibrationPlan, prepare_calibration, simulate_calibration
from tests.gui.conftest import Served
from tests.gui.until import until

pytestmark = pytest.mark.browser


@pytest.fixture
def recorded(served: Served) -> str:
    """A recording of the board by the very machine of the page, as the guided procedure leaves it."""
    station = served.page.station
    folder = station.calibration_recordings / "20260101-000000"
    plan = CalibrationPlan(placements=PLACEMENTS[:4], stops=12, sweep_frames=24)
    run = prepare_calibration(true_machine(station.rig), plan, seed=1)
    simulate_calibration(folder, run, "for a test", progress=lambda done, total: None)
    return folder.name


def test_a_calibration_is_computed_kept_out_and_then_put_in_force(served: Served, me: Operator, recorded: str) -> None:
    page = served.page
    truth = page.station.calibration
    page.desk.post(page.desk.change)
    me.goes_to(texts.TAB_CALIBRATE)
    me.unfolds(texts.CALIBRATE_AGAIN)
    me.chooses(texts.CALIBRATE_RECORDING, recorded)
    me.presses(texts.CALIBRATE_GO)
    me.sees(re.compile("Expected error in the working volume"))
    assert "not verified" in " ".join(page.desk.state.calibration.lines)
    me.presses(texts.CALIBRATE_KEEP)
    me.sees(texts.CALIBRATE_KEPT)
    assert page.station.calibration == truth
    with me.tab.expect_download() as board:
        me.presses(texts.BOARD_PRINT)
    assert board.value.path().read_bytes().startswith(b"%PDF")
    me.types(texts.BOARD_ROW, "210.00")
    me.presses(texts.CALIBRATE_GO)
    me.sees(texts.BOARD_BOTH)
    me.types(texts.BOARD_COLUMN, "150.00")
    me.presses(texts.CALIBRATE_GO)
    me.sees(re.compile("Expected error in the working volume"))
    assert "not verified" not in " ".join(page.desk.state.calibration.lines)
    me.presses(texts.CALIBRATE_ACCEPT)
    me.tab.get_by_role("dialog").get_by_role("button", name=texts.CALIBRATE_ACCEPT).click()
    me.sees(texts.CALIBRATE_DONE)
    until(lambda: page.desk.state.job is None)
    found = page.station.calibration

    assert truth is not None and found is not None and found != truth
    assert found.camera.focal_length_mm == pytest.approx(truth.camera.focal_length_mm, rel=2e-3)
    assert page.station.calibration_days() == 0
    assert page.station.session.setup.calibration == found
    me.sees(re.compile(texts.CALIBRATION_TODAY))


def test_a_recording_is_begun_stopped_and_given_up_and_nothing_else_runs_meanwhile(
    served: Served, me: Operator
) -> None:
    served.page.calibration.stops = 8
    me.takes_patient("Jürgen Muster")
    me.goes_to(texts.TAB_CALIBRATE)
    me.presses(texts.CALIBRATE_BEGIN)
    me.presses(texts.CALIBRATE_YES)
    me.sees(re.compile("Placement 1:"))
    until(lambda: served.page.desk.state.job is None)
    me.presses(texts.CALIBRATE_PLACE)
    me.presses(texts.CALIBRATE_YES)
    me.sees(re.compile("of the stops"))
    me.presses(texts.CANCEL)
    until(lambda: served.page.desk.state.job is None)
    me.goes_to(texts.TAB_SCAN)
    me.presses(texts.CHECK)
    me.sees(texts.CALIBRATION_OPEN)
    me.goes_to(texts.TAB_CALIBRATE)
    assert me.button(texts.CALIBRATE_FINISH).is_disabled()
    me.presses(texts.CALIBRATE_ABANDON)
    me.tab.get_by_role("dialog").get_by_role("button", name=texts.CALIBRATE_ABANDON).click()
    me.button(texts.CALIBRATE_BEGIN).wait_for()

    assert not served.page.calibration.recording
    assert not served.page.station.session.snapshot().armed
