"""In the Patient tab: a take that was filed for the wrong patient, side, load or skin is put right, with a reason."""

from typing import Any

import viser

from footscan.errors import InputError
from footscan.gui import texts
from footscan.gui.binding import ask, on_press, plain, put, put_options
from footscan.gui.fold import Fold
from footscan.gui.state import PageState
from footscan.gui.tab import Tools
from footscan.gui.visit import patient_words
from footscan.records import Correction, Take


class Corrections:
    """Handles of the folder."""

    def __init__(self, tools: Tools) -> None:
        gui = tools.server.gui
        self._desk, self._work, self._store = tools.desk, tools.patients, tools.station.store
        self._fold = Fold(gui, tools.desk, texts.CORRECT)
        with self._fold.inside:
            self._take = gui.add_dropdown(texts.TAKE, (texts.CORRECT_NONE,))
            same = texts.CORRECT_SAME
            self._side = gui.add_dropdown(texts.SIDE, (same, *texts.SIDES.values()), hint=texts.CORRECT_HINT)
            self._load = gui.add_dropdown(texts.LOAD, (same, *texts.LOADS.values()), hint=texts.CORRECT_HINT)
            self._surface = gui.add_dropdown(texts.SURFACE, (same, *texts.SURFACES.values()), hint=texts.CORRECT_HINT)
            self._patient = gui.add_text(texts.CORRECT_PATIENT, "", hint=texts.CORRECT_PATIENT_HINT)
            self._reason = gui.add_text(texts.CORRECT_REASON, "", hint=texts.CORRECT_REASON_HINT)
            self._go = gui.add_button(texts.CORRECT_GO, hint=texts.CORRECT_GO_HINT)
        on_press(self._desk, self._go, self._put_right)

    def show(self, state: PageState) -> None:
        """Takes of the chosen patient."""
        words = tuple(_words(take) for take in state.takes) or (texts.CORRECT_NONE,)
        put_options(self._take, words, self._take.value if self._take.value in words else words[0])
        self._fold.show(bool(state.takes))
        put(self._go, disabled=state.job is not None or not state.takes)

    def _put_right(self, client: viser.ClientHandle) -> None:
        take = next((take for take in self._desk.state.takes if _words(take) == self._take.value), None)
        number = self._patient.value.strip().removeprefix("#")
        if take is None or (number and not number.isdecimal()):
            self._desk.say(texts.FAILED, texts.CORRECT_PATIENT_HINT if number else texts.CORRECT_NONE, wrong=True)
            return
        right = Correction(
            int(number) if number else None,
            _key(texts.SIDES, self._side.value),
            _key(texts.LOADS, self._load.value),
            _key(texts.SURFACES, self._surface.value),
        )
        reason = self._reason.value
        if right.patient_id is None:
            self._work.correct(take.id, right, reason, self._clear)
            return
        try:
            patient = self._store.patient(right.patient_id)
        except InputError:
            self._desk.say(texts.FAILED, texts.CORRECT_NOBODY.format(number=right.patient_id), wrong=True)
            return
        ask(
            self._desk,
            client,
            texts.CORRECT_MOVE_TITLE,
            texts.CORRECT_MOVE.format(take=take.id, patient=plain(patient_words(patient))),
            texts.CORRECT_MOVE_YES,
            texts.CORRECT_MOVE_NO,
            lambda: self._work.correct(take.id, right, reason, self._clear),
        )

    def _clear(self) -> None:
        """What was said of one take is not said of the next."""
        for choice in (self._side, self._load, self._surface):
            put(choice, value=texts.CORRECT_SAME)
        for words in (self._patient, self._reason):
            put(words, value="")


def _words(take: Take) -> str:
    return f"{texts.SIDES[take.said.side]}, {texts.LOADS[take.said.load]}  #{take.id}"


def _key(words_by_key: dict[Any, str], words: str) -> Any:
    return next((key for key, value in words_by_key.items() if value == words), None)
