"""Buttons that no other test presses: namesakes, repeat, measure again, give up, keep, doctor, drills."""

import re

import pytest

from footscan.gui import texts
from footscan.gui.visitor import Visitor as Operator
from tests.gui.conftest import Served
from tests.gui.until import until

pytestmark = pytest.mark.browser


def test_a_namesake_is_entered_only_when_somebody_says_so(served: Served, me: Operator) -> None:
    me.goes_to(texts.TAB_PATIENT)
    store = served.page.station.store
    for answer, count in ((texts.NAMESAKE_NO, 1), (texts.NAMESAKE_YES, 2)):
        me.types(texts.NAME, "Anna Example")
        me.types(texts.BORN, "1962-03-31")
        me.presses(texts.ENTER)
        me.presses(answer)
        me.misses(answer)
        until(lambda wanted=count: len(store.find_patients("Anna Example", 9)) == wanted)


def test_an_impossible_date_is_told_and_nobody_is_entered(served: Served, me: Operator) -> None:
    me.goes_to(texts.TAB_PATIENT)
    me.types(texts.NAME, "Ivo Impossible")
    me.types(texts.BORN, "1962-02-31")
    me.presses(texts.ENTER)
    me.sees(texts.FAILED)

    assert not served.page.station.store.find_patients("Ivo", 9)


def test_a_take_is_measured_again_with_another_threshold_and_repeated(served: Served, me: Operator) -> None:
    me.enters("Rita Repeat")
    me.scans()
    first = served.page.desk.state.takes[0].result
    me.drags(texts.THRESHOLD, -10)
    until(lambda: not served.page.desk.state.camera.automatic)
    me.presses(texts.REPROCESS)
    until(lambda: served.page.desk.state.takes[0].result != first and served.page.desk.state.job is None)
    again = served.page.desk.state.takes[0].result
    me.presses(texts.REPEAT)
    until(lambda: served.page.desk.state.takes[0].verdict == "repeat")

    assert first is not None and again is not None
    assert again.settings["threshold"] == served.page.desk.state.camera.threshold != first.settings["threshold_used"]
    assert served.page.desk.state.scan.side == "left"
    assert not served.page.desk.state.takes[0].in_use
    me.tab.get_by_role("checkbox").first.click()  # automatic again


def test_devices_are_examined_and_drills_run_and_are_cancelled(served: Served, me: Operator) -> None:
    me.goes_to(texts.TAB_SYSTEM)
    me.presses(texts.EXAMINE)
    me.tab.get_by_role("dialog").get_by_role("button", name=texts.EXAMINE).click()
    me.sees(re.compile("frames/s."))
    until(lambda: served.page.desk.state.job is None)

    assert {found.device for found in served.page.desk.state.examined} >= {"camera", "encoder", "io"}
    assert all(found.grade != "trouble" for found in served.page.desk.state.examined)
    me.presses(texts.DRILL_RECORDS.format(kills=10))
    me.sees(re.compile(texts.DRILL_NO_PROBLEMS))
    me.presses(texts.DRILL_MACHINE)
    me.presses(texts.CANCEL)
    me.sees(re.compile("cancelled"))


def test_the_stop_key_stops(served: Served, me: Operator) -> None:
    me.takes_patient("Jürgen Muster")
    me.goes_to(texts.TAB_SCAN)
    me.presses(texts.CHECK)
    me.presses(texts.ARM_YES)
    until(lambda: served.page.station.session.snapshot().armed)
    me.tab.mouse.click(600, 600)  # in the 3-D view
    me.tab.keyboard.press("x")
    me.sees(re.compile(texts.STOPPED_BY))

    assert not served.page.station.session.snapshot().armed


def test_a_take_of_the_wrong_load_is_put_right_with_a_reason(
    served: Served, me: Operator, measured_patient: str
) -> None:
    store = served.page.station.store
    me.takes_patient(measured_patient)
    before = served.page.desk.state.takes[0]
    me.tab.get_by_text(texts.CORRECT, exact=True).click()
    me.tab.get_by_role("combobox", name=texts.LOAD).first.click()
    me.tab.get_by_role("option", name=texts.LOADS["seated"]).first.click()
    me.presses(texts.CORRECT_GO)
    me.sees(texts.CORRECT_REASON_HINT)
    assert store.take(before.id) == before
    me.types(texts.CORRECT_REASON, "mixed up")
    me.presses(texts.CORRECT_GO)
    me.sees(texts.CORRECTED_WORDS.format(take=before.id, side=before.said.side))
    after = store.take(before.id)

    assert (after.said.load, after.said.side, after.stale) == ("seated", before.said.side, False)
    assert after.result is not None and before.result is not None and after.result.id != before.result.id
