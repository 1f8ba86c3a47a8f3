"""Two browsers at one machine: one controls, the other watches, asks, and is told."""

import re
from collections.abc import Callable

import pytest

from footscan.gui import texts
from footscan.gui.visitor import Visitor as Operator
from tests.gui.conftest import Served
from tests.gui.until import until

pytestmark = pytest.mark.browser
Opens = Callable[..., Operator]


def test_the_second_browser_watches_until_control_is_given(served: Served, me: Operator, operator: Opens) -> None:
    first, second = me, operator(served.url)
    second.sees(texts.YOU_WATCH)
    first.is_known("Fiona First")
    second.goes_to(texts.TAB_SCAN)
    second.chooses(texts.SIDE, "right")
    second.sees(texts.ONLY_WATCHING)
    holder = served.page.keys.holder

    assert served.page.desk.state.operator == "Fiona First"
    assert served.page.desk.state.scan.side == "left"
    second.presses(texts.TAKE_OVER)
    first.presses(texts.KEEP)
    second.sees(texts.TAKE_OVER_REFUSED)
    assert served.page.keys.holder == holder
    second.presses(texts.TAKE_OVER)
    first.presses(texts.GIVE)
    second.sees(texts.YOU_CONTROL)
    first.sees(texts.YOU_WATCH)
    assert "was given control" in served.log()
    assert "keeps control" in served.log()
    second.chooses(texts.SIDE, "right")
    until(lambda: served.page.desk.state.scan.side == "right")
    first.sees(texts.YOU_WATCH)
    first.presses(texts.STOP)  # everybody may stop
    first.sees(re.compile(texts.STOPPED_BY))
    first.presses(texts.TAKE_OVER)
    second.presses(texts.GIVE)
    first.sees(texts.YOU_CONTROL)
    first.is_known("Olga Operator")
