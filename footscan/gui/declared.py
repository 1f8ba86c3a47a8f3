"""In the Patient tab: what a person declares of a foot today - missing parts, dressings, deformity, why not scanned."""

from typing import Any

from footscan.coordinates import Side
from footscan.gui import texts
from footscan.gui.binding import on_press, on_value, put
from footscan.gui.fold import Fold
from footscan.gui.state import PageState
from footscan.gui.tab import Tools
from footscan.records import FootFacts


class Declared:
    """Handles of the folder."""

    def __init__(self, tools: Tools) -> None:
        gui = tools.server.gui
        self._desk, self._work = tools.desk, tools.patients
        self._entered: tuple[Any, ...] = ()
        self._fold = Fold(gui, tools.desk, texts.DECLARE)
        with self._fold.inside:
            self._side = gui.add_dropdown(texts.SIDE, tuple(texts.SIDES.values()))
            self._parts = {
                part: gui.add_checkbox(words, False, hint=texts.DECLARE_PART_HINT)
                for part, words in texts.DECLARE_PARTS.items()
            }
            self._dressings = gui.add_text(texts.DRESSINGS, "", hint=texts.DRESSINGS_HINT)
            self._deformity = gui.add_text(texts.DEFORMITY, "", hint=texts.DEFORMITY_HINT)
            self._reason = gui.add_text(texts.NOT_SCANNED, "", hint=texts.NOT_SCANNED_HINT)
            self._go = gui.add_button(texts.DECLARE_GO, hint=texts.DECLARE_GO_HINT)
        on_value(self._desk, self._side, lambda _: self._enter(self._desk.state))
        on_press(self._desk, self._go, lambda _: self._declare())

    def show(self, state: PageState) -> None:
        """Fill in what the records say when that is new; what is being typed stays otherwise."""
        self._fold.show(state.patient is not None)
        put(self._go, disabled=state.job is not None or state.patient is None)
        now = (None if state.patient is None else state.patient.id, state.feet)
        if now != self._entered:
            self._entered = now
            self._enter(state)

    def _enter(self, state: PageState) -> None:
        side = self._chosen_side()
        facts = next((foot.facts for foot in state.feet if foot.side == side), FootFacts())
        for part, box in self._parts.items():
            put(box, value=part in facts.missing)
        put(self._dressings, value=facts.dressings)
        put(self._deformity, value=facts.deformity)
        put(self._reason, value=facts.not_scanned)

    def _chosen_side(self) -> Side:
        return "left" if self._side.value == texts.SIDES["left"] else "right"

    def _declare(self) -> None:
        side = self._chosen_side()
        missing = tuple(part for part, box in self._parts.items() if box.value)
        said = (self._dressings.value, self._deformity.value, self._reason.value)
        self._work.declare(side, FootFacts(missing, *said))
