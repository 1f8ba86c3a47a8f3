"""The operator's whole visit in a real browser, by clicking, dragging and typing."""

import re

import pytest

from footscan.gui import texts
from footscan.gui.visitor import Visitor as Operator
from tests.gui.conftest import Served
from tests.gui.until import until

pytestmark = pytest.mark.browser


def test_a_visit_from_new_patient_to_both_feet_in_use(served: Served, me: Operator) -> None:
    me.enters("Željko Đorđević 李", "1950-02-28")
    me.sees(texts.PATIENT_EMPTY)
    me.goes_to(texts.TAB_SCAN)
    me.sees("Next: the left foot.")
    me.scans()
    me.sees(re.compile("Lasers agree within"))
    me.sees(re.compile("Skin seen .* assumed"))
    me.types(texts.REMARK_LABEL, "of the left foot alone")
    me.presses(texts.ACCEPT)
    me.sees("Next: the right foot.")
    me.scans()
    me.presses(texts.REMARK)
    me.sees(texts.REMARK_NEEDED)
    me.types(texts.REMARK_LABEL, "swollen ankle")
    me.presses(texts.REMARK)
    me.sees(texts.BOTH_DONE)
    me.sees(re.compile("Olga Operator: swollen ankle"))
    takes = served.page.desk.state.takes

    assert [(take.said.side, take.verdict, take.in_use) for take in takes] == [
        ("right", "with_remark", True),
        ("left", "accepted", True),
    ]
    assert {take.said.operator for take in takes} == {"Olga Operator"}
    assert (takes[0].verdict_remark, takes[0].verdict_by) == ("swollen ankle", "Olga Operator")


def test_a_dragged_threshold_changes_the_binary_picture_of_a_laser_held_on(served: Served, me: Operator) -> None:
    me.takes_patient("Anna Example")
    me.checks()
    me.presses("Binary")
    shine = me.button(texts.SHINE)
    shine.hover()
    me.tab.mouse.down()
    me.sees(texts.LASER_ON.format(lasers="right"))
    until(lambda: bool(served.page.camera.shown_points))
    automatic = served.page.camera.shown_points
    me.tab.mouse.up()
    me.misses(texts.LASER_ON.format(lasers="right"))
    value = me.drags_to(texts.THRESHOLD, 110, near=15)
    until(lambda: served.page.desk.state.camera.threshold == value)
    shine.hover()
    me.tab.mouse.down()
    me.sees(texts.LASER_ON.format(lasers="right"))
    until(lambda: served.page.camera.shown_points not in (0, automatic))
    me.tab.mouse.up()

    assert not served.page.desk.state.camera.automatic
    assert 0 < served.page.camera.shown_points < automatic
    me.tab.get_by_role("checkbox").first.click()  # automatic again
    until(lambda: served.page.desk.state.camera.automatic)


def test_a_double_click_starts_one_scan_and_stop_keeps_what_there_is(served: Served, me: Operator) -> None:
    me.enters("Dora Double")
    me.checks()
    me.presses(texts.START, clicks=2)
    me.sees(re.compile("s to go"))
    me.presses(texts.STOP, clicks=2)
    me.sees(re.compile("What was captured lies in"))
    snapshot = served.page.station.session.snapshot()
    kept = served.page.desk.state.kept

    assert not snapshot.lasers and not snapshot.motor_on and not snapshot.armed
    assert len(kept) == 1 and not kept[0].finished and kept[0].frames > 0
    assert served.log().count("machine: scanning: stand still") >= 1
    me.unfolds(texts.KEPT_SCANS)
    me.presses(texts.KEPT_FILE)
    until(lambda: bool(served.page.desk.state.takes) and not served.page.desk.state.kept)

    assert [take.said.side for take in served.page.desk.state.takes] == ["left"]
