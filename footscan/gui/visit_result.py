"""What becomes of a scan: accepted, kept with a remark, repeated, measured again. On the desk's thread."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

from footscan.errors import InputError
from footscan.gui import texts
from footscan.gui.desk import Desk
from footscan.gui.station import Station
from footscan.gui.visit import takes_of
from footscan.records import Take, Verdict


class ResultWork:
    """The result on the page."""

    def __init__(self, desk: Desk, station: Station) -> None:
        self._desk, self._station = desk, station

    def accept(self) -> None:
        """Use this take for its foot and load."""
        self._judge("accepted", "", texts.ACCEPTED)

    def use_with_remark(self, remark: str) -> None:
        """Use it all the same, and say why that is not quite right."""
        if not remark.strip():
            self._desk.say(texts.FAILED, texts.REMARK_NEEDED, wrong=True)
            return
        self._judge("with_remark", remark, texts.REMARKED)

    def repeat(self, remark: str) -> None:
        """Keep the take, do not use it, and scan this foot again."""
        state = self._desk.state
        take, remark = state.take, remark.strip() or _finding(state.report) or texts.REPEATED
        self._judge("repeat", remark, texts.REPEATED)
        if take is not None:
            self._desk.change(scan=replace(self._desk.state.scan, side=take.said.side))

    def reprocess(self) -> None:
        """Measure the recording again with the threshold of the camera panel."""
        state = self._desk.state
        take = state.take
        if take is None:
            return
        from footscan.scanning.sweep import SweepSettings
        from footscan.workflow.process import ProcessSettings
        from footscan.workflow.visit import reprocess_take

        settings = ProcessSettings(SweepSettings(threshold=state.camera.in_use))
        self._desk.job(
            texts.JOB_REPROCESS,
            lambda progress: reprocess_take(
                self._station.store,
                take.id,
                state.operator,
                f"threshold {state.camera.in_use or 'automatic'}",
                settings=settings,
                progress=progress,
            ),
            self._show,
        )

    def _judge(self, verdict: Verdict, remark: str, words: str) -> None:
        state, store = self._desk.state, self._station.store
        if state.take is None or state.job is not None:
            self._desk.say(texts.FAILED, texts.RESULT_NONE if state.take is None else texts.BUSY, wrong=True)
            return
        take = store.judge_take(state.take.id, verdict, state.operator, remark)
        if verdict != "repeat":
            try:
                take = store.use_take(take.id, state.operator)
            except InputError:
                self._desk.change(take=store.judge_take(take.id, "undecided", state.operator))
                raise
        self._desk.change(take=take, takes=takes_of(self._station, take.patient_id), step="idle")
        side = self._desk.state.next_side
        if side is not None:
            self._desk.change(scan=replace(self._desk.state.scan, side=side))
        self._desk.say(words, texts.NEXT_FOOT.format(side=side) if side else texts.BOTH_DONE)

    def _show(self, take: Take) -> None:
        takes = takes_of(self._station, take.patient_id)
        self._desk.change(step="result", take=take, takes=takes, report=report_of(self._station, take))


def report_of(station: Station, take: Take) -> dict[str, Any] | None:
    """scan.json of a take's latest result; None when it has none."""
    if take.result is None:
        return None
    path = station.store.results_folder(take.result.id) / "scan.json"
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return content


def _finding(report: dict[str, Any] | None) -> str:
    return str((report or {}).get("verdict", {}).get("finding", ""))
