"""The Patient tab: find by typing, enter, choose; the visits of the chosen patient."""

import html

import viser

from footscan.gui import texts
from footscan.gui.binding import ask, on_press, on_value, plain, put, put_options
from footscan.gui.corrections import Corrections
from footscan.gui.declared import Declared
from footscan.gui.history import History
from footscan.gui.proposed import Proposed
from footscan.gui.state import PageState
from footscan.gui.tab import Tools
from footscan.gui.visit import chosen_from, facts_words, patient_words
from footscan.records import FootFacts, Patient, Take
from footscan.scanning.session.states import Snapshot

_MOST_TAKES = 12


class PatientTab:
    """Handles of the tab."""

    def __init__(self, tools: Tools) -> None:
        gui, desk, work = tools.server.gui, tools.desk, tools.patients
        self._desk, self._work = desk, work
        self._operator = gui.add_text(texts.OPERATOR, "", hint=texts.OPERATOR_HINT)
        self._chosen = gui.add_html("")
        self._proposed = Proposed(tools)
        self._typed = gui.add_text(texts.FIND, "", hint=texts.FIND_HINT)
        self._found = gui.add_dropdown(texts.FOUND, (texts.NOBODY_FOUND,))
        self._choose = gui.add_button(texts.CHOOSE, icon=viser.Icon.USER_CHECK)
        with gui.add_folder(texts.NEW_PATIENT):
            self._name = gui.add_text(texts.NAME, "")
            self._born = gui.add_text(texts.BORN, "", hint=texts.BORN_HINT)
            self._number = gui.add_text(texts.NUMBER, "", hint=texts.NUMBER_HINT)
            self._enter = gui.add_button(texts.ENTER, icon=viser.Icon.USER_PLUS)
        self._declared = Declared(tools)
        self._visits = gui.add_html("")
        self._corrections = Corrections(tools)
        self._history = History(tools)
        on_value(desk, self._operator, work.set_operator)
        on_value(desk, self._typed, work.find)
        on_press(desk, self._choose, lambda _: self._take_chosen())
        on_press(desk, self._enter, self._enter_new)

    def show(self, state: PageState) -> None:
        """What the desk says."""
        options = tuple(patient_words(patient) for patient in state.found) or (texts.NOBODY_FOUND,)
        kept = self._found.value if self._found.value in options else options[0]
        put_options(self._found, options, kept)
        put(self._choose, disabled=not state.found or state.job is not None)
        put(self._chosen, content=_box(_patient_html(state.patient)))
        self._proposed.show(state)
        self._declared.show(state)
        self._corrections.show(state)
        self._history.show(state)
        special = "".join(
            f"<div>{html.escape(facts_words(foot))}</div>" for foot in state.feet if foot.facts != FootFacts()
        )
        put(self._visits, content=_box(special + _takes_html(state)))

    def tick(self, snapshot: Snapshot) -> None:
        """Nothing here moves."""

    def _take_chosen(self) -> None:
        patient = chosen_from(self._found.value, self._desk.state)
        if patient is not None:
            self._work.choose(patient.id)

    def _enter_new(self, client: viser.ClientHandle, force: bool = False) -> None:
        name, born, number = self._name.value, self._born.value, self._number.value
        if self._work.enter(name, born, number, force=force):
            if self._desk.state.patient is not None and self._desk.state.operator:
                self._typed.value = ""
                self._name.value = self._born.value = self._number.value = ""
            return
        ask(
            self._desk,
            client,
            texts.NAMESAKE_TITLE,
            plain(f"{name} {born}"),
            texts.NAMESAKE_YES,
            texts.NAMESAKE_NO,
            lambda: self._enter_new(client, force=True),
        )


def _patient_html(patient: Patient | None) -> str:
    if patient is None:
        return texts.PATIENT_NONE
    born = f", {patient.born.isoformat()}" if patient.born else ""
    number = f", {html.escape(patient.number)}" if patient.number else ""
    return texts.PATIENT_IS.format(name=html.escape(patient.name), born=born, number=number)


def _takes_html(state: PageState) -> str:
    if state.patient is None:
        return ""
    if not state.takes:
        return texts.PATIENT_EMPTY
    rows = "".join(_row(take) for take in state.takes[:_MOST_TAKES])
    return f'<table style="width:100%;text-align:left;font-size:13px">{texts.VISITS_HEAD}{rows}</table>'


def _row(take: Take) -> str:
    used = texts.IN_USE if take.in_use else ""
    cells = (
        str(take.id),
        take.said.recorded.astimezone().strftime("%Y-%m-%d"),
        texts.SIDES[take.said.side],
        texts.LOADS[take.said.load],
        texts.VERDICTS[take.verdict],
        used,
    )
    return f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in cells)}</tr>"


def _box(content: str) -> str:
    return f'<div style="padding:2px 1em;font-size:14px">{content}</div>'
