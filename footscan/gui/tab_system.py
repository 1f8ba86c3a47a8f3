"""The System tab: devices in words, the doctor, drills, and the log."""

from __future__ import annotations

import html
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import viser

from footscan.errors import QualityError
from footscan.gui import texts
from footscan.gui.binding import ask, on_press, put
from footscan.gui.desk import Progress
from footscan.gui.state import PageState
from footscan.gui.station import Station
from footscan.gui.tab import Tools
from footscan.scanning.session.states import Snapshot
from footscan.workflow.designs import builtin_config

if TYPE_CHECKING:
    from footscan.devices.diagnosis import Finding as Examined
    from footscan.workflow.drill import Drill
    from footscan.workflow.drill_result import DrillResult

_LINES = 60
_KILLS = 10
_NOT_BROKEN_S = -1.0
_QUIET = "#555"
_GRADES = {"good": ("✔", "#176b2c"), "remark": ("●", "#a85b00"), "trouble": ("✖", "#c81e1e")}


class SystemTab:
    """Handles of the tab."""

    def __init__(self, tools: Tools) -> None:
        gui = tools.server.gui
        self._desk, self._station, self._log = tools.desk, tools.station, tools.log
        self._calibration = tools.calibration
        self._written = -1
        with gui.add_folder(texts.DEVICES):
            self._facts = gui.add_html("")
            self._examine = gui.add_button(texts.EXAMINE, hint=texts.EXAMINE_HINT, icon=viser.Icon.STETHOSCOPE)
            self._found = gui.add_html("")
        with gui.add_folder(texts.DRILL):
            gui.add_html(_box(texts.DRILL_WORDS))
            self._drill = gui.add_button(texts.DRILL_MACHINE, hint=texts.DRILL_MACHINE_HINT)
            self._drilled = gui.add_html("")
            self._kill = gui.add_button(texts.DRILL_RECORDS.format(kills=_KILLS), hint=texts.DRILL_RECORDS_HINT)
            self._killed = gui.add_html("")
        with gui.add_folder(texts.LOG):
            self._lines = gui.add_html(texts.LOG_EMPTY)
        on_press(self._desk, self._examine, self._ask_examine)
        on_press(self._desk, self._drill, lambda _: self._drill_machine())
        on_press(self._desk, self._kill, lambda _: self._drill_records())

    def _ask_examine(self, client: viser.ClientHandle) -> None:
        if self._desk.state.job is not None or self._calibration.recording:
            self._desk.say(
                texts.FAILED, texts.CALIBRATION_OPEN if self._calibration.recording else texts.BUSY, wrong=True
            )
            return
        ask(self._desk, client, texts.EXAMINE, texts.EXAMINE_SURE, texts.EXAMINE, texts.ARM_NO, self._examine_all)

    def _examine_all(self) -> None:
        self._desk.job(
            texts.JOB_EXAMINE,
            lambda progress: tuple(self._station.examine()),
            lambda found: self._desk.change(examined=found, step="idle", findings=()),
        )

    def _drill_machine(self) -> None:
        if not self._station.simulated:
            self._desk.say(texts.FAILED, texts.DRILL_REAL, wrong=True)
            return
        self._desk.change(drilled=())
        self._desk.job(texts.JOB_DRILL, self._break, lambda results: self._desk.change(drilled=results))

    def _break(self, progress: Progress) -> tuple[DrillResult, ...]:
        from footscan import app
        from footscan.workflow.drill import cases_of

        cases = cases_of(self._station.rig)
        results: tuple[DrillResult, ...] = ()
        with tempfile.TemporaryDirectory(prefix="footscan-drill-") as folder:
            for result in drill_on(app.build_drill(self._station.rig, 0, Path(folder)), cases):
                results = (*results, result)
                self._desk.post(lambda shown=results: self._desk.change(drilled=shown))  # stays when it is cancelled
                progress(len(results), len(cases))
        return results

    def _drill_records(self) -> None:
        def work(progress: Progress) -> str:
            from footscan.records.drill import drill_records

            report = drill_records(_KILLS, 0, progress)
            words = texts.DRILL_RECORDS_DONE.format(kills=report.kills, acknowledged=report.acknowledged)
            return f"{words} {'; '.join(report.problems) or texts.DRILL_NO_PROBLEMS}"

        self._desk.job(texts.JOB_DRILL, work, lambda words: self._desk.change(records_drill=words))

    def show(self, state: PageState) -> None:
        """What the desk says."""
        busy = state.job is not None
        for button in (self._examine, self._drill, self._kill):
            put(button, disabled=busy)
        put(self._facts, content=_table(device_facts(self._station)))
        put(self._found, content=_box("".join(examined_html(found) for found in state.examined)))
        put(self._drilled, content=_box(drill_table(state.drilled)))
        put(self._killed, content=_box(html.escape(state.records_drill)))

    def tick(self, snapshot: Snapshot) -> None:
        """New lines of the log."""
        if self._log.count != self._written:
            self._written = self._log.count
            lines = "".join(f"<div>{html.escape(line)}</div>" for line in self._log.latest(_LINES))
            style = "padding:0 1em;font:11.5px monospace;max-height:260px;overflow-y:auto;overflow-wrap:anywhere"
            put(self._lines, content=f'<div style="{style}">{lines}</div>')


def device_facts(station: Station) -> Iterator[tuple[str, str]]:
    """What the machine is made of, in words."""
    rig, facts = station.rig, station.session.facts
    size = f"{facts.width_px} x {facts.height_px} px, {facts.frames_per_s:g} frames/s"
    yield texts.FACT_MACHINE, rig.scanner.machine_id or rig.scanner.name
    built_in = rig.path == builtin_config("sim")
    yield texts.FACT_RIG, texts.FACT_RIG_BUILT_IN if built_in else str(rig.path)
    yield texts.FACT_CAMERA, f"{facts.name}: {size}, {1000.0 * facts.exposure_s:g}\u00a0ms"
    yield texts.FACT_ENCODER, f"{rig.devices.encoder.kind}, {rig.scanner.encoder.steps_per_rev} steps per turn"
    yield texts.FACT_OUTPUTS, rig.devices.io.kind
    yield texts.FACT_CALIBRATION, station.calibration_words
    yield texts.FACT_DATA, str(station.data)


def _table(facts: Iterator[tuple[str, str]]) -> str:
    rows = "".join(
        f'<tr><th style="text-align:left;vertical-align:top;padding-right:8px">{html.escape(what)}</th>'
        f'<td style="overflow-wrap:anywhere">{html.escape(value)}</td></tr>'
        for what, value in facts
    )
    return f'<table style="font-size:13px;padding:0 1em">{rows}</table>'


def examined_html(found: Examined) -> str:
    """How one device is, in words."""
    mark, colour = _GRADES[found.grade]
    device = texts.EXAMINED.get(found.device, found.device)
    words = f"<b>{html.escape(device)}</b>: {html.escape(found.sentence)}"
    return f'<div><span style="color:{colour}">{mark}</span> {words}</div>'


def drill_on(drill: Drill, cases: tuple[str, ...]) -> Iterator[DrillResult]:
    """All cases; one that could not be broken is told in its place, and the drill goes on behind it."""
    from footscan.workflow.drill_result import DrillResult

    done = 0
    while done < len(cases):
        try:
            for result in drill.run(cases[done:]):
                done += 1
                yield result
        except QualityError as err:
            yield DrillResult(cases[done], _NOT_BROKEN_S, str(err), None, None, 0, 0)
            done += 1


def drill_table(results: tuple[DrillResult, ...]) -> str:
    """How long the outputs stayed on after each fault, and what the person reads."""
    if not results:
        return ""
    rows = "".join(_drill_rows(result) for result in results)
    return f'<table style="width:100%;text-align:left;font-size:12.5px">{texts.DRILL_HEAD}{rows}</table>'


def _drill_rows(result: DrillResult) -> str:
    mark, colour = _GRADES["good" if result.well else "trouble"]
    told = html.escape(result.told)
    off = texts.DRILL_NOT_BROKEN if result.off_after_s < 0.0 else f"{result.off_after_s:.3f} s"
    return (
        f'<tr><td style="padding-top:4px"><b>{html.escape(result.case)}</b></td><td>{off}</td>'
        f'<td>{result.target_s:g} s</td><td style="color:{colour}">{mark}</td></tr>'
        f'<tr><td colspan="4" style="color:{_QUIET if result.well else colour}">{told}</td></tr>'
    )


def _box(content: str) -> str:
    return f'<div style="padding:2px 1em;font-size:13px">{content}</div>'
