"""The page is loaded again in the middle of a scan."""

import pytest

from footscan.gui import texts
from footscan.gui.visitor import Visitor as Operator
from tests.gui.conftest import Served

pytestmark = pytest.mark.browser


def test_a_reload_in_the_middle_of_a_scan_does_not_spoil_it(served: Served, me: Operator) -> None:
    me.enters("Rene Reload")
    me.starts()
    me.tab.reload()
    me.sees(texts.YOU_CONTROL)
    me.goes_to(texts.TAB_SCAN)
    me.button(texts.ACCEPT).wait_for()

    assert served.page.desk.state.take is not None
    assert not served.page.desk.state.kept
