"""The page is loaded again in the middle of a scan; what came of it is measured again and repeated."""

import pytest

from footscan.gui import texts
from footscan.gui.visitor import Visitor as Operator
from tests.gui.conftest import Served
from tests.gui.until import until

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def reloaded(olga: Operator) -> Operator:
    """The page with the result of a scan in whose middle it was loaded again."""
    me = olga
    me.begins_afresh()
    me.enters("Rene Reload")
    me.starts()
    me.tab.reload()
    me.sees(texts.YOU_CONTROL)
    me.goes_to(texts.TAB_SCAN)
    me.button(texts.ACCEPT).wait_for()
    return me


def test_a_reload_in_the_middle_of_a_scan_does_not_spoil_it(served: Served, reloaded: Operator) -> None:
    assert served.page.desk.state.take is not None
    assert not served.page.desk.state.kept


def test_a_take_is_measured_again_with_another_threshold_and_repeated(served: Served, reloaded: Operator) -> None:
    me = reloaded
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
