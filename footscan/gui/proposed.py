"""In the Patient tab: what an earlier visit says of the feet, and whether it holds today."""

import html

import viser

from footscan.gui import texts
from footscan.gui.binding import on_press, put
from footscan.gui.earlier import Earlier
from footscan.gui.state import PageState
from footscan.gui.tab import Tools
from footscan.gui.visit import facts_words

_STYLE = "margin:4px 1em;padding:4px 8px;font-size:13.5px;border-left:4px solid #a85b00;background:#fff6e8"


class Proposed:
    """Handles; nothing is shown when nothing is proposed."""

    def __init__(self, tools: Tools) -> None:
        gui, desk, work = tools.server.gui, tools.desk, tools.patients
        self._words = gui.add_html("", visible=False)
        self._holds = gui.add_button(
            texts.EARLIER_HOLDS, hint=texts.EARLIER_HOLDS_HINT, icon=viser.Icon.CHECK, visible=False
        )
        self._not = gui.add_button(texts.EARLIER_NOT, hint=texts.EARLIER_NOT_HINT, color="gray", visible=False)
        on_press(desk, self._holds, lambda _: work.confirm_earlier())
        on_press(desk, self._not, lambda _: work.dismiss_earlier())

    def show(self, state: PageState) -> None:
        """What the desk says."""
        proposed = bool(state.earlier)
        put(self._words, content=earlier_html(state.earlier), visible=proposed)
        for button in (self._holds, self._not):
            put(button, visible=proposed, disabled=state.job is not None)


def earlier_html(earlier: Earlier) -> str:
    """What is proposed, in words."""
    lines = [
        f"{day.isoformat()}: {html.escape(facts_words(foot))}"
        for foot, day in zip(earlier.feet, earlier.days, strict=True)
    ]
    said = [texts.LOADS[earlier.load]] if earlier.load is not None else []
    said += [texts.SURFACES[earlier.surface]] if earlier.surface is not None else []
    lines += [texts.EARLIER_SCANNED.format(how=", ".join(said))] if said else []
    items = "".join(f"<li>{line}</li>" for line in lines)
    listed = f'<ul style="margin:0;padding-left:1.2em">{items}</ul>'
    return f'<div style="{_STYLE}"><b>{texts.EARLIER_TITLE}</b>{listed}</div>'
