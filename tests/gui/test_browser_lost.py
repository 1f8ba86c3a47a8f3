"""The browser is lost in the middle of a scan: killed, frozen. Beams go off, and the scan is kept.

These run in real time and before the other pages of this folder are open, whose machines would take the processor.
"""

from collections.abc import Callable, Generator

import pytest

from footscan.gui.visitor import Visitor as Operator
from tests.gui.conftest import Serve, Served
from tests.gui.until import until

pytestmark = pytest.mark.browser
Opens = Callable[..., Operator]
DEAD_MAN_S = 8.0
"""Shorter than the scan, which is 21 s long, and longer than a browser on a busy computer is silent."""


@pytest.fixture(scope="module")
def hasty(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> Generator[Served]:
    with serve(tmp_path_factory.mktemp("hasty"), DEAD_MAN_S, 1.0, "standard") as page:
        yield page


def _off_and_kept(served: Served, before: int) -> None:
    session = served.page.station.session
    until(lambda: not session.snapshot().armed)
    snapshot = session.snapshot()

    assert not snapshot.lasers and not snapshot.motor_on
    assert "nobody watches" in snapshot.message
    until(lambda: len(served.page.desk.state.kept) > before and served.page.desk.state.job is None)
    assert len(served.page.desk.state.kept) == before + 1
    assert all(scan.frames > 0 for scan in served.page.desk.state.kept)


def _scanning(served: Served, operator: Opens, name: str) -> Operator:
    me = operator(served.url)
    me.is_known("Olga Operator")
    me.enters(name)
    me.starts()
    return me


def test_a_killed_browser_switches_off_and_the_scan_is_kept(hasty: Served, operator: Opens) -> None:
    before = len(hasty.page.desk.state.kept)
    me = _scanning(hasty, operator, "Kim Killed")
    me.tab.context.close()
    _off_and_kept(hasty, before)


def test_a_frozen_browser_switches_off_and_the_scan_is_kept(hasty: Served, operator: Opens) -> None:
    before = len(hasty.page.desk.state.kept)
    me = _scanning(hasty, operator, "Fred Frozen")
    debugger = me.tab.context.new_cdp_session(me.tab)
    debugger.send("Debugger.enable")
    debugger.send("Debugger.pause")  # no script runs any more, as in a browser that hangs, and the processor stays free
    _off_and_kept(hasty, before)
