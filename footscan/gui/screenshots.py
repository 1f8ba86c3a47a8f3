"""Pictures of every tab and state of the page, as the documents show them; made by using it like a person."""

import re
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from footscan.config.rig_file import Rig
from footscan.errors import StorageError
from footscan.gui import texts
from footscan.gui.door import Address, url_of
from footscan.gui.headless import keep_calm, open_chromium
from footscan.gui.page import Page
from footscan.gui.serve import open_page
from footscan.gui.visitor import SCAN_MS, Visitor
from footscan.workflow.demo_patients import add_demo_patients

SIZES = ((1280, 800), (1920, 1080))
_PATIENCE_S = 300.0
_DRAWN_MS, _SETTLED_MS = 4000, 900
"""A browser without a graphics card needs as long for a new foot, and for a new size."""
_STOPS = 8
"""Head angles are enough to show what a placement of the calibration board looks like."""


def take_screenshots(rig: Rig, out: Path, say: Callable[[str], None]) -> list[Path]:
    """Use the page over a simulated machine, and keep what a browser shows.

    Args:
        rig: Of a simulated machine.
        out: Gets `page-<state>.png` of the smaller size, and `large/page-<state>.png` of the larger one.
        say: Told each picture.

    Raises:
        StorageError: The pictures cannot be written.
        InputError: No Chromium is installed.
    """
    made: list[Path] = []
    with tempfile.TemporaryDirectory(prefix="footscan-screenshots-") as data:
        address = Address(port=0)
        with open_page(rig, Path(data), address, _PATIENCE_S) as page:
            add_demo_patients(page.station.store)
            page.desk.post(lambda: page.desk.change(found=tuple(page.station.store.find_patients("", 20))))
            with open_chromium() as browser:
                context = browser.new_context(viewport={"width": SIZES[0][0], "height": SIZES[0][1]})
                keep_calm(context)
                tab = context.new_page()
                for state in _states(Visitor(tab, url_of(page.server, address)), page):
                    for (width, height), folder in zip(SIZES, (out, out / "large"), strict=True):
                        tab.set_viewport_size({"width": width, "height": height})
                        tab.wait_for_timeout(_SETTLED_MS)
                        path = folder / f"page-{state}.png"
                        try:
                            folder.mkdir(parents=True, exist_ok=True)
                            tab.screenshot(path=path)
                        except OSError as err:
                            raise StorageError(f"{path} cannot be written ({err.strerror}).") from err
                        made.append(path)
                        say(str(path))
                    tab.set_viewport_size({"width": SIZES[0][0], "height": SIZES[0][1]})
    return made


def _states(me: Visitor, page: Page) -> Iterator[str]:
    """Go from state to state; the name of each."""
    yield "start"
    me.tab.locator(".mantine-Notification-closeButton").first.click()  # of viser: there is no graphics card
    me.is_known("Olga Operator")
    me.takes_patient("Anna Example")
    yield "patient"
    yield from _scan(me, page)
    me.goes_to(texts.TAB_PATIENT)
    for fold in (texts.CORRECT, texts.HISTORY):
        me.unfolds(fold)
    me.tab.get_by_text(texts.HISTORY, exact=True).scroll_into_view_if_needed()
    yield "filed"
    yield from _inspect(me)
    yield from _last(me)
    yield from _calibrate(me, page)
    me.goes_to(texts.TAB_SYSTEM)
    me.presses(texts.EXAMINE)
    yield "question"
    me.tab.get_by_role("dialog").get_by_role("button", name=texts.EXAMINE).click()
    me.sees(re.compile("everything is off"))
    yield "system"


def _scan(me: Visitor, page: Page) -> Iterator[str]:
    me.goes_to(texts.TAB_SCAN)
    yield "scan-before"
    me.presses(texts.CHECK)
    me.button(texts.ARM_YES).wait_for()
    yield "arm"
    me.presses(texts.ARM_YES)
    me.sees(re.compile("^Checked"))
    yield "checked"
    me.presses(texts.START)
    me.tab.wait_for_function("document.body.innerText.match(/([4-9][0-9]) %/)")
    yield "scanning"
    me.button(texts.ACCEPT).wait_for(timeout=SCAN_MS)
    me.tab.wait_for_timeout(_DRAWN_MS)
    yield "scan"
    me.presses(texts.ACCEPT)
    me.sees(re.compile("Next: the right foot"))
    me.scans()
    me.presses(texts.ACCEPT)
    me.sees(texts.BOTH_DONE)
    yield "both-feet"


def _inspect(me: Visitor) -> Iterator[str]:
    me.goes_to(texts.TAB_INSPECT)
    me.sees(re.compile("tape girth"))
    me.chooses(texts.SHOW, "Shaded")
    me.tab.wait_for_timeout(_DRAWN_MS)
    yield "inspect"
    me.chooses(texts.SHOW, "Distance to points")
    me.drags(texts.SECTION_TILT, 60)
    yield "inspect-distance"
    me.tab.get_by_role("checkbox").last.click()
    me.tab.wait_for_timeout(_DRAWN_MS)
    yield "inspect-both"
    me.tab.get_by_text(texts.MEASUREMENTS, exact=True).scroll_into_view_if_needed()
    me.tab.get_by_text(texts.DOWNLOADS, exact=True).scroll_into_view_if_needed()
    yield "inspect-measurements"


def _last(me: Visitor) -> Iterator[str]:
    me.goes_to(texts.TAB_LAST)
    yield "last"
    me.presses(texts.LAST_RANK)
    me.button(texts.LAST_COMPARE).click()
    me.sees(re.compile("never seen|negative: the foot stands out"))
    me.tab.wait_for_timeout(_DRAWN_MS)
    yield "last-compared"
    me.chooses(texts.LAST_SHOW, "Clearance map")
    me.tab.wait_for_timeout(_DRAWN_MS)
    yield "last-clearance"
    me.presses(texts.LAST_CUSTOMISE)
    me.sees(re.compile("The last (holds|does not hold)"))
    me.misses(texts.LAST_MADE_HOLDS)  # the notification
    me.tab.wait_for_timeout(_DRAWN_MS)
    yield "last-customised"


def _calibrate(me: Visitor, page: Page) -> Iterator[str]:
    me.goes_to(texts.TAB_CALIBRATE)
    yield "calibrate"
    page.calibration.stops = _STOPS
    me.presses(texts.CALIBRATE_BEGIN)
    me.presses(texts.CALIBRATE_YES)
    me.sees(re.compile("Placement 1:"))
    me.button(texts.CALIBRATE_PLACE).and_(me.tab.locator("button:enabled")).click()
    me.presses(texts.CALIBRATE_YES)
    me.sees(re.compile("[1-9] % of the stops"))
    yield "calibrate-recording"
    me.presses(texts.CANCEL)
    me.button(texts.CALIBRATE_ABANDON).and_(me.tab.locator("button:enabled")).click()
    me.tab.get_by_role("dialog").get_by_role("button", name=texts.CALIBRATE_ABANDON).click()
    me.button(texts.CALIBRATE_BEGIN).wait_for()
