"""Mouse, keyboard and eyes of one person in a browser: for the page's tests, screenshots and timings."""

import re
from pathlib import Path
from typing import Any

from playwright.sync_api import Locator, Page

from footscan.gui import texts

_WAIT_MS, SCAN_MS = 90_000, 400_000


class Visitor:
    """What a person does with mouse and keyboard in one browser."""

    def __init__(self, tab: Page, url: str) -> None:
        self.tab = tab
        tab.set_default_timeout(_WAIT_MS)
        tab.goto(url)
        self.sees(re.compile("controls? the machine"))

    def goes_to(self, name: str) -> None:
        """Open a tab."""
        self.tab.get_by_role("tab", name=name, exact=True).click()

    def button(self, name: str) -> Locator:
        """A button by its words."""
        return self.tab.get_by_role("button", name=name, exact=True)

    def presses(self, name: str, clicks: int = 1) -> None:
        """Press a button, once or twice."""
        self.button(name).click(click_count=clicks)

    def _field(self, label: str) -> Locator:
        """The field with a label that can be seen now: another tab may hold one of the same name."""
        return self.tab.locator(f'xpath=//label[.="{label}"]/ancestor::*[3]//input >> visible=true').first

    def unfolds(self, heading: str) -> None:
        """Open what a heading opens; it may be open already."""
        button = self.button(heading)
        if button.locator(".icon-tabler-chevron-right").count():
            button.click()
        button.locator(".icon-tabler-chevron-down").wait_for()

    def types(self, label: str, text: str) -> None:
        """Type into a field, in place of what stands there."""
        box = self._field(label)
        box.click()
        box.fill("")
        box.press_sequentially(text)

    def chooses(self, label: str, option: str) -> None:
        """Choose from a list."""
        self._field(label).click()
        self.tab.get_by_role("option", name=option).first.click()

    def sees(self, words: Any) -> None:
        """Wait until some words are there."""
        self.tab.get_by_text(words).first.wait_for()

    def misses(self, words: Any) -> None:
        """Wait until some words are gone."""
        self.tab.get_by_text(words).first.wait_for(state="hidden")

    def picture(self, path: Path) -> None:
        """What the browser shows now."""
        self.tab.screenshot(path=path)

    def html(self, words: str) -> str:
        """Text of the innermost block that holds some words."""
        return self.tab.get_by_text(words).first.inner_text()

    def slider(self, label: str) -> Locator:
        """The thumb of a slider."""
        return self.tab.locator(f'xpath=//label[.="{label}"]/ancestor::*[3]//*[@role="slider"]')

    def drags(self, label: str, pixels: int) -> int:
        """Drag a slider by its thumb; returns the value it shows afterwards."""
        thumb = self.slider(label)
        thumb.scroll_into_view_if_needed()
        box = thumb.bounding_box()
        if box is None:
            raise AssertionError(f"the slider {label} cannot be seen")
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        self.tab.mouse.move(x, y)
        self.tab.mouse.down()
        for step in range(1, 11):
            self.tab.mouse.move(x + pixels * step / 10, y)
        self.tab.mouse.up()
        return int(float(thumb.get_attribute("aria-valuenow") or "nan"))

    def drags_to(self, label: str, value: int, near: int) -> int:
        """Drag a slider until its value is near the one that is wanted, as a person does; returns what it shows."""
        thumb = self.slider(label)
        least, most = (int(float(thumb.get_attribute(name) or "nan")) for name in ("aria-valuemin", "aria-valuemax"))
        track = thumb.locator("xpath=..").bounding_box()
        if track is None:
            raise AssertionError(f"the slider {label} cannot be seen")
        for _ in range(5):
            now = int(float(thumb.get_attribute("aria-valuenow") or "nan"))
            if abs(now - value) <= near:
                return now
            self.drags(label, round((value - now) * track["width"] / (most - least)))
        raise AssertionError(f"the slider {label} cannot be dragged to {value}")

    # What takes more than one step

    def begins_afresh(self) -> None:
        """Let go of the mouse; where a question that was never answered covers the page, load it again."""
        self.tab.mouse.up()
        if self.tab.get_by_role("dialog").count():
            self.tab.reload()
            self.sees(texts.YOU_CONTROL)

    def is_known(self, name: str) -> None:
        """Type the operator's name."""
        self.goes_to(texts.TAB_PATIENT)
        self.types(texts.OPERATOR, name)

    def takes_patient(self, typed: str) -> None:
        """Find a patient by typing, and take the one that is found."""
        self.goes_to(texts.TAB_PATIENT)
        self.types(texts.FIND, typed)
        self.tab.wait_for_function(
            "words => [...document.querySelectorAll('input')].some(i => i.value.includes(words))", arg=typed
        )
        self.presses(texts.CHOOSE)
        self.tab.locator("b", has_text=typed).first.wait_for()

    def enters(self, name: str, born: str = "") -> None:
        """Enter a new patient; where somebody of that name is known, another person."""
        self.goes_to(texts.TAB_PATIENT)
        namesake, taken = self.button(texts.NAMESAKE_YES), self.tab.locator("b", has_text=name)
        again = taken.count() > 0
        self.types(texts.NAME, name)
        self.types(texts.BORN, born)
        self.types(texts.NUMBER, "")
        self.presses(texts.ENTER)
        (namesake if again else namesake.or_(taken)).first.wait_for()
        if namesake.count():
            namesake.click()
            namesake.wait_for(state="hidden")
        taken.first.wait_for()

    def checks(self) -> None:
        """Check before a scan, and say that nobody's face is there if that was not said already."""
        self.goes_to(texts.TAB_SCAN)
        question, checked = self.button(texts.ARM_YES), self.tab.get_by_text(re.compile("^Checked"))
        again = checked.count() > 0
        self.presses(texts.CHECK)
        for _ in range(_WAIT_MS // 50 if again else 0):  # what an earlier check said goes first
            if question.count() or not checked.count():
                break
            self.tab.wait_for_timeout(50)
        question.or_(checked).first.wait_for()
        if question.count():
            question.click()
        self.sees(re.compile("^Checked"))

    def starts(self) -> None:
        """Start a scan; it runs on."""
        self.checks()
        self.presses(texts.START)
        self.sees(re.compile("s to go"))

    def scans(self) -> None:
        """A whole scan, until there is something to decide."""
        self.checks()
        self.presses(texts.START)
        self.button(texts.ACCEPT).wait_for(timeout=SCAN_MS)
