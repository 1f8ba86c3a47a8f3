"""Buttons that no other test presses: namesakes, give up, keep, what is declared, doctor, drills."""

import re
from datetime import UTC, datetime, timedelta

import pytest

from footscan.gui import texts
from footscan.gui.visitor import Visitor as Operator
from footscan.records import FootFacts, NewPatient
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


def test_devices_are_examined_and_drills_run_and_are_cancelled(served: Served, me: Operator) -> None:
    me.goes_to(texts.TAB_SYSTEM)
    me.presses(texts.EXAMINE)
    me.tab.get_by_role("dialog").get_by_role("button", name=texts.EXAMINE).click()
    until(lambda: bool(served.page.desk.state.examined) and served.page.desk.state.job is None)
    me.sees(re.compile("frames/s."))

    assert {found.device for found in served.page.desk.state.examined} >= {"camera", "encoder", "io"}
    assert all(found.grade != "trouble" for found in served.page.desk.state.examined)
    me.presses(texts.DRILL_RECORDS.format(kills=10))
    me.sees(re.compile(texts.DRILL_NO_PROBLEMS))
    me.presses(texts.DRILL_MACHINE)
    me.presses(texts.CANCEL)
    me.sees(re.compile("cancelled"))


def test_a_wedge_is_declared_stays_in_sight_and_is_of_this_patient_only(served: Served, me: Operator) -> None:
    me.takes_patient("Jürgen Muster")
    me.goes_to(texts.TAB_SCAN)
    me.presses(texts.WEDGE_FOLD)
    me.types(texts.WEDGE, "50")
    me.sees(re.compile(texts.ON_WEDGE.format(height=50)))

    assert served.page.tools.scan._settings().subject.wedge_mm == 50.0
    me.takes_patient("Anna Example")
    until(lambda: served.page.tools.scan._settings().subject.wedge_mm is None)


def test_the_stop_key_stops(served: Served, me: Operator) -> None:
    me.takes_patient("Jürgen Muster")
    me.goes_to(texts.TAB_SCAN)
    me.checks()
    until(lambda: served.page.station.session.snapshot().armed)
    me.tab.mouse.click(600, 600)  # in the 3-D view
    me.tab.keyboard.press("x")
    me.sees(re.compile(texts.STOPPED_BY))
    me.sees(texts.CHECK_AGAIN)

    assert not served.page.station.session.snapshot().armed
    assert me.button(texts.START).is_disabled()


def test_a_take_of_the_wrong_load_is_put_right_with_a_reason(
    served: Served, me: Operator, measured_patient: str
) -> None:
    store = served.page.station.store
    me.takes_patient(measured_patient)
    before = served.page.desk.state.takes[0]
    me.unfolds(texts.CORRECT)
    me.tab.get_by_role("combobox", name=texts.LOAD).first.click()
    me.tab.get_by_role("option", name=texts.LOADS["seated"]).first.click()
    me.presses(texts.CORRECT_GO)
    me.sees(texts.CORRECT_REASON_HINT)
    assert store.take(before.id) == before
    me.types(texts.CORRECT_REASON, "mixed up")
    me.presses(texts.CORRECT_GO)
    me.sees(
        texts.CORRECTED_WORDS.format(
            take=before.id, patient=measured_patient, side=before.said.side, load=texts.LOADS["seated"]
        )
    )
    after = store.take(before.id)

    other = store.find_patients("Anna Example", 1)[0]
    me.types(texts.CORRECT_PATIENT, f"#{other.id}")
    me.types(texts.CORRECT_REASON, "namesake")
    me.presses(texts.CORRECT_GO)
    me.tab.get_by_role("dialog").get_by_text("Anna Example").wait_for()
    me.presses(texts.CORRECT_MOVE_NO)

    assert store.take(before.id) == after
    assert (after.said.load, after.said.side, after.stale) == ("seated", before.said.side, False)
    assert after.result is not None and before.result is not None and after.result.id != before.result.id


def test_what_an_earlier_visit_declared_holds_only_after_somebody_says_so(
    served: Served, me: Operator, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk, store = served.page.desk, served.page.station.store
    toe = FootFacts(("toe_2",), deformity="hallux valgus")
    with monkeypatch.context() as earlier:
        earlier.setattr(store, "_now", lambda: datetime.now(UTC) - timedelta(days=90))
        for name in ("Rita Returning", "Hanna Healed"):
            patient = store.add_patient(NewPatient(name), "a test")
            store.declare_foot(store.open_visit(patient.id, "a test").id, "left", toe, "a test")
    me.takes_patient("Hanna Healed")
    me.sees(texts.EARLIER_TITLE)
    me.presses(texts.EARLIER_NOT)
    me.misses(texts.EARLIER_TITLE)
    assert desk.state.feet == ()
    me.takes_patient("Rita Returning")
    me.sees(texts.EARLIER_TITLE)
    me.presses(texts.EARLIER_HOLDS)
    until(lambda: bool(desk.state.feet) and desk.state.job is None)

    assert [(foot.side, foot.facts) for foot in desk.state.feet] == [("left", toe)]
    assert not desk.state.earlier


def test_a_missing_toe_and_a_dressing_are_declared_and_come_back_with_the_patient(served: Served, me: Operator) -> None:
    desk, store = served.page.desk, served.page.station.store
    me.enters("Mia Missing")
    me.unfolds(texts.DECLARE)
    toe = me.tab.get_by_label(texts.DECLARE_PARTS["toe_2"])
    until(lambda: not toe.is_checked())  # of the patient before
    toe.click()
    me.types(texts.DRESSINGS, "gauze on the heel")
    me.presses(texts.DECLARE_GO)
    me.sees(re.compile("toe 2 is missing; dressings: gauze on the heel"))
    until(lambda: desk.state.job is None)
    patient = desk.state.patient
    assert patient is not None
    (foot,) = store.feet(store.visits(patient.id)[0].id)
    me.takes_patient("Jürgen Muster")
    until(lambda: not desk.state.feet)
    me.takes_patient("Mia Missing")
    until(lambda: desk.state.feet == (foot,))

    assert (foot.side, foot.facts.missing, foot.facts.dressings) == ("left", ("toe_2",), "gauze on the heel")
    assert me.tab.get_by_label(texts.DECLARE_PARTS["toe_2"]).is_checked()
