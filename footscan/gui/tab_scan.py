"""The Scan tab: what is scanned, check, start, progress, and the verdict on what came."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import viser

from footscan.config import MOST_WEDGE_MM
from footscan.gui import texts
from footscan.gui.binding import ask, on_press, on_value, put, put_options
from footscan.gui.desk import Desk
from footscan.gui.fold import Fold
from footscan.gui.legend import legend_html
from footscan.gui.state import PageState
from footscan.gui.tab import Tools
from footscan.records import Take
from footscan.scanning.session.states import Snapshot, State

if TYPE_CHECKING:
    from footscan.workflow.scan import StoredScan

_GRADES = {"good": "#176b2c", "usable with remark": "#a85b00", "repeat": "#c81e1e"}


class ScanTab:
    """Handles of the tab."""

    def __init__(self, tools: Tools) -> None:
        self._desk, self._station, self._scan, self._result = tools.desk, tools.station, tools.scan, tools.result
        gui = tools.server.gui
        self._head = gui.add_html("")
        self._side = gui.add_dropdown(texts.SIDE, tuple(texts.SIDES.values()), hint=texts.SIDE_HINT)
        self._load = gui.add_dropdown(texts.LOAD, tuple(texts.LOADS.values()), hint=texts.LOAD_HINT)
        self._surface = gui.add_dropdown(texts.SURFACE, tuple(texts.SURFACES.values()), hint=texts.SURFACE_HINT)
        self._profile = gui.add_dropdown(texts.PROFILE, self._station.profiles, hint=texts.PROFILE_HINT)
        self._plan = gui.add_html("")
        self._check = gui.add_button(texts.CHECK, hint=texts.CHECK_HINT, icon=viser.Icon.CHECKLIST)
        self._start = gui.add_button(texts.START, hint=texts.START_HINT, icon=viser.Icon.PLAYER_PLAY, color="green")
        self._note = gui.add_html("")
        self._verdict = gui.add_html("")
        self._accept = gui.add_button(texts.ACCEPT, hint=texts.ACCEPT_HINT, color="green", visible=False)
        self._remark = gui.add_text(texts.REMARK_LABEL, "", visible=False, hint=texts.REMARK_LABEL_HINT)
        others = (texts.REMARK, texts.REPEAT, texts.REPROCESS)
        self._else = gui.add_button_group(texts.DECIDE_ELSE, others, visible=False, hint=texts.DECIDE_ELSE_HINT)
        self._remarked: int | None = None
        self._wedge = _wedge_field(gui, tools.desk)
        self._fold = Fold(gui, tools.desk, texts.KEPT_SCANS)
        with self._fold.inside:
            gui.add_html(_box(texts.KEPT_WORDS, small=True))
            self._kept = gui.add_dropdown(texts.KEPT, (texts.KEPT_NONE,))
            self._file = gui.add_button(texts.KEPT_FILE, hint=texts.KEPT_FILE_HINT, disabled=True)
        self._bind()

    def _bind(self) -> None:
        desk = self._desk
        on_value(desk, self._side, lambda words: self._choose(side=_key(texts.SIDES, words)))
        on_value(desk, self._load, lambda words: self._choose(load=_key(texts.LOADS, words)))
        on_value(desk, self._surface, lambda words: self._choose(surface=_key(texts.SURFACES, words)))
        on_value(desk, self._profile, lambda name: self._choose(profile=name))
        on_value(desk, self._wedge, lambda height_mm: self._choose(wedge_mm=float(height_mm)))
        on_press(desk, self._check, lambda client: self._armed(client, self._scan.check))
        on_press(desk, self._start, lambda client: self._armed(client, self._scan.start))
        on_press(desk, self._accept, lambda _: self._result.accept())
        on_value(desk, self._else, self._decide_else)
        on_press(desk, self._file, lambda _: self._file_kept())

    def _decide_else(self, pressed: str) -> None:
        if pressed == texts.REMARK:
            self._result.use_with_remark(self._remark.value)
        elif pressed == texts.REPEAT:
            self._result.repeat(self._remark.value)
        else:
            self._result.reprocess()

    def _file_kept(self) -> None:
        scan = next((scan for scan in self._desk.state.kept if _kept_words(scan) == self._kept.value), None)
        if scan is not None:
            self._scan.file_kept(scan.folder)

    def _choose(self, **values: Any) -> None:
        """Another foot or density was not checked yet."""
        self._desk.change(scan=replace(self._desk.state.scan, **values), step="idle", findings=(), note="")

    def _armed(self, client: viser.ClientHandle, act: Callable[[], None]) -> None:
        """Do something for which lasers or motor go on; ask whether anybody's face is there unless that was said."""
        why = self._scan.refusal()
        if why:
            self._desk.say(texts.FAILED, why, wrong=True)
            return
        if self._scan.armed:
            act()
            return

        def agreed() -> None:
            if not self._scan.refusal():
                self._scan.arm()
                act()

        ask(self._desk, client, texts.ARM_TITLE, texts.ARM_QUESTION, texts.ARM_YES, texts.ARM_NO, agreed)

    def show(self, state: PageState) -> None:
        """What the desk says."""
        choice, busy = state.scan, state.job is not None
        put(self._head, content=_box(_head(state)))
        put(self._side, value=texts.SIDES[choice.side], disabled=busy)
        put(self._load, value=texts.LOADS[choice.load], disabled=busy)
        put(self._surface, value=texts.SURFACES[choice.surface], disabled=busy)
        put(self._profile, value=choice.profile or self._station.profiles[0], disabled=busy)
        put(self._wedge, value=choice.wedge_mm, disabled=busy)
        put(self._plan, content=_box(_plan(self._station.plan(choice.profile).sentence(), choice.wedge_mm), small=True))
        put(self._check, disabled=busy or state.patient is None)
        put(self._start, disabled=busy or state.step != "checked")
        put(self._note, content=_box(_note(state)))
        put(self._verdict, content=_box(_verdict(state)))
        judged = undecided(state)
        if state.take is not None and state.take.id != self._remarked:
            self._remarked = state.take.id
            put(self._remark, value="")  # another take's remark is not signed for this one
        for handle in (self._accept, self._remark, self._else):
            put(handle, visible=judged)
        kept = tuple(_kept_words(scan) for scan in state.kept) or (texts.KEPT_NONE,)
        put_options(self._kept, kept, self._kept.value if self._kept.value in kept else kept[0])
        put(self._file, disabled=busy or not state.kept or state.patient is None)
        self._fold.show(bool(state.kept))

    def tick(self, snapshot: Snapshot) -> None:
        """Progress stands beside STOP; what was checked holds no longer when the machine was stopped."""
        if self._desk.state.step == "checked" and check_spoiled(snapshot):
            self._desk.post(self._scan.forget_check)


def check_spoiled(snapshot: Snapshot) -> bool:
    """The machine is not as it was when it was checked."""
    return snapshot.state in (State.FAULT, State.STOPPED, State.CLOSED) or not snapshot.estop_ok


def _wedge_field(gui: viser.GuiApi, desk: Desk) -> viser.GuiInputHandle[float]:
    with Fold(gui, desk, texts.WEDGE_FOLD).inside:
        gui.add_html(_box(texts.WEDGE_WORDS, small=True))
        return gui.add_number(texts.WEDGE, 0.0, min=0.0, max=MOST_WEDGE_MM, step=1.0, hint=texts.WEDGE_HINT)


def _plan(sentence: str, wedge_mm: float) -> str:
    """The plan in a sentence; a wedge is always in sight, also where its field is folded away."""
    wedge = f"<b>{texts.ON_WEDGE.format(height=wedge_mm)}</b>, " if wedge_mm else ""
    return wedge + html.escape(sentence)


def _head(state: PageState) -> str:
    if state.patient is None:
        return f"<b>{texts.NO_PATIENT_SCAN}</b>"
    words = f"{texts.FOR_PATIENT.format(name=html.escape(state.patient.name))}<br>{_following(state)}"
    return f'{words}<br><b style="color:#a85b00">{texts.EARLIER_OPEN}</b>' if state.earlier else words


def _following(state: PageState) -> str:
    """What is to be done next: decide, scan the other foot, or look at both."""
    if undecided(state) and state.take is not None:
        return texts.DECIDE.format(side=texts.SIDES[state.take.said.side])
    side = state.next_side
    return (
        texts.BOTH_DONE if side is None else f"{texts.NEXT_FOOT.format(side=texts.SIDES[side])} {texts.PLACEMENT_HINT}"
    )


def undecided(state: PageState) -> bool:
    """A scan waits for somebody to say what becomes of it."""
    return state.take is not None and state.step == "result" and state.job is None


def _note(state: PageState) -> str:
    if state.note:
        return html.escape(state.note)
    if state.step == "checked" and not state.findings:
        return f'<b style="color:#176b2c">{texts.CHECK_GOOD}</b>'
    if not state.findings:
        return ""
    title = texts.CHECK_REMARKS if state.step == "checked" else texts.CHECK_BAD
    lines = "".join(
        f"<li><b>{html.escape(finding.cause)}</b>: {html.escape(finding.sentence)}</li>" for finding in state.findings
    )
    return f'<b>{title}</b><ul style="margin:0;padding-left:1.2em">{lines}</ul>'


def _verdict(state: PageState) -> str:
    if state.take is None:
        return ""
    report, take = state.report or {}, state.take
    verdict = report.get("verdict", {})
    grade = str(verdict.get("grade", ""))
    lines = [
        f"<b>{texts.RESULT_OF.format(side=texts.SIDES[take.said.side], number=take.number)}: "
        f'<span style="color:{_GRADES.get(grade, "#555")}">{html.escape(grade)}</span></b>',
        html.escape(str(verdict.get("finding", ""))),
    ]
    if verdict.get("kind", "none") != "none":
        lines.append(f"<b>{html.escape(str(verdict.get('action', '')))}</b>")
    lines += _agreement(report) + _coverage(report)
    used = f", {texts.IN_USE}" if take.in_use else ""
    lines.append(f"{texts.DECISION}: <b>{html.escape(texts.VERDICTS[take.verdict])}{used}</b>{_signed(take)}")
    return "<br>".join(line for line in lines if line)


def _signed(take: Take) -> str:
    if take.verdict == "undecided":
        return ""
    words = f"{take.verdict_by}: {take.verdict_remark}" if take.verdict_remark else str(take.verdict_by)
    return f" ({html.escape(words)})"


def _agreement(report: Mapping[str, Any]) -> list[str]:
    zones = [zone for zone in report.get("agreement", []) if zone["median_mm"] is not None]
    if not zones:
        return []
    worst = max(zones, key=lambda zone: abs(zone["median_mm"]))
    return [texts.AGREEMENT.format(median=abs(worst["median_mm"]), zone=html.escape(worst["zone"]))]


def _coverage(report: Mapping[str, Any]) -> list[str]:
    foot = report.get("foot", {})
    if foot.get("refused"):
        return [texts.REFUSED_FOOT.format(why=html.escape(str(foot["refused"])))]
    skin = foot.get("skin")
    if not skin:
        return []
    words = texts.COVERAGE.format(seen=skin["seen"], bridged=skin["bridged"], assumed=skin["assumed_sole"])
    return [words, legend_html(texts.LEGEND_ORIGIN)]


def _kept_words(scan: StoredScan) -> str:
    part = "" if scan.finished else f", {texts.BROKEN_OFF}"
    return f"{scan.folder.name}: {scan.frames} {texts.PICTURES}{part}"


def _key(words_by_key: Mapping[str, str], words: str) -> Any:
    return next(key for key, value in words_by_key.items() if value == words)


def _box(content: str, small: bool = False) -> str:
    return f'<div style="padding:2px 1em;font-size:{13 if small else 14}px">{content}</div>'
