"""The page is lost in the middle of a scan: reloaded, killed, frozen. Beams go off, and the scan is kept."""

from collections.abc import Callable, Generator

import pytest

from footscan.gui import texts
from footscan.gui.visitor import Visitor as Operator
from tests.gui.conftest import Serve, Served
from tests.gui.until import until

pytestmark = pytest.mark.browser
Opens = Callable[..., Operator]
DEAD_MAN_S = 8.0
"""Shorter than the scan, which is 21 s long, and longer than a browser on a busy computer is silent."""
FREEZE = "setTimeout(() => { const end = Date.now() + 120000; while (Date.now() < end); }, 0)"


@pytest.fixture(scope="module")
def hasty(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> Generator[Served]:
    with serve(tmp_path_factory.mktemp("hasty"), DEAD_MAN_S, 1.0, "standard") as page:
        yield page


def _off_and_kept(served: Served) -> None:
    session = served.page.station.session
    until(lambda: not session.snapshot().armed)
    snapshot = session.snapshot()

    assert not snapshot.lasers and not snapshot.motor_on
    assert "nobody watches" in snapshot.message
    until(lambda: bool(served.page.desk.state.kept) and served.page.desk.state.job is None)
    assert served.page.desk.state.kept[0].frames > 0


def _scanning(served: Served, operator: Opens, name: str) -> Operator:
    me = operator(served.url)
    me.is_known("Olga Operator")
    me.enters(name)
    me.starts()
    return me


def test_a_reload_in_the_middle_of_a_scan_does_not_spoil_it(served: Served, me: Operator) -> None:
    me.enters("Rene Reload")
    me.starts()
    me.tab.reload()
    me.sees(texts.YOU_CONTROL)
    me.goes_to(texts.TAB_SCAN)
    me.button(texts.ACCEPT).wait_for()

    assert served.page.desk.state.take is not None
    assert not served.page.desk.state.kept


def test_a_killed_browser_switches_off_and_the_scan_is_kept(hasty: Served, operator: Opens) -> None:
    me = _scanning(hasty, operator, "Kim Killed")
    me.tab.context.close()
    _off_and_kept(hasty)


def test_a_frozen_browser_switches_off_and_the_scan_is_kept(hasty: Served, operator: Opens) -> None:
    me = _scanning(hasty, operator, "Fred Frozen")
    me.tab.evaluate(FREEZE)
    _off_and_kept(hasty)
