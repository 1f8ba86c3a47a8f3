"""Check and scan as the operator does them. Every public method runs on the desk's thread."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from footscan.config import Subject
from footscan.errors import FootscanError
from footscan.gui import texts
from footscan.gui.adjust_light import shine_while_held
from footscan.gui.desk import Desk, Progress
from footscan.gui.placement import LitFrame, look_at_foot
from footscan.gui.state import PageState
from footscan.gui.station import Station
from footscan.gui.view_foot import FootView
from footscan.gui.visit import kept_scans, takes_of
from footscan.gui.visit_calibrate import CalibrationWork
from footscan.gui.visit_result import report_of
from footscan.records import Take
from footscan.scanning.session.states import Finding, State

if TYPE_CHECKING:
    from footscan.scanning.session.control import Session
    from footscan.workflow.scan import ScanSettings

_ARM_S = 5.0
_ABOUT_THE_FOOT = ("no foot", "foot partly out of view")
"""Findings after which the machine itself is well, and the picture helps to place the foot."""


class ScanWork:
    """The scan on the page."""

    def __init__(self, desk: Desk, station: Station, view: FootView, calibration: CalibrationWork) -> None:
        self._desk, self._station, self._view, self._calibration = desk, station, view, calibration
        self._held_s = 0.0

    @property
    def armed(self) -> bool:
        """Somebody has looked, and nothing has happened since."""
        return self._session.snapshot().armed

    def refusal(self) -> str:
        """Why neither check nor scan can begin now; empty when they can."""
        state = self._desk.state
        if state.job is not None or self._session.snapshot().state is State.HOLDING:
            return texts.BUSY
        if self._session.snapshot().state is State.CLOSED:
            return texts.MACHINE_CLOSED
        if self._calibration.recording:
            return texts.CALIBRATION_OPEN
        if state.patient is None:
            return texts.NO_PATIENT_SCAN
        if not state.operator:
            return texts.NO_OPERATOR
        if self._station.calibration is None:
            return f"{self._station.calibration_words}. Calibrate the machine first."
        self._station.look_at_calibration()
        return texts.CALIBRATION_BAD.format(why=self._station.invalid) if self._station.invalid else ""

    def arm(self) -> None:
        """The operator has looked: lasers and motor may be switched on.

        Raises:
            DeviceError: The machine refuses.
        """
        self._session.post_arm(no_faces_at_beam_height=True).wait(_ARM_S)

    def check(self) -> None:
        """Home if needed, and look at everything that can spoil the scan; the machine is armed."""
        settings = self._settings()
        last = replace(self._desk.state.last, hidden=True)  # the place is the foot's
        self._desk.change(step="idle", findings=(), note="", take=None, report=None, last=last)
        self._view.hide_cloud()
        self._view.clear_placement()
        self._desk.job(texts.JOB_CHECK, lambda progress: self._look(settings), self._checked, self._stopped, self._stop)

    def _look(self, settings: ScanSettings) -> tuple[list[Finding], list[LitFrame]]:
        from footscan.workflow.scan import prepare_machine

        if self._station.opened.put_on_board is not None:
            self._station.opened.put_on_board(settings.side)
        findings = prepare_machine(self._session, settings, lambda snapshot: None)
        lit: list[LitFrame] = []
        if all(finding.cause in _ABOUT_THE_FOOT for finding in findings if finding.blocking):
            self._session.post(lambda machine: look_at_foot(machine, lit)).wait()
        return findings, lit

    def _stop(self) -> None:
        self._session.post_cancel(texts.STOPPED_BY)

    def _checked(self, seen: tuple[list[Finding], list[LitFrame]]) -> None:
        findings, lit = seen
        for each in lit:
            self._view.show_placement(each)
        good = not any(finding.blocking for finding in findings)
        self._desk.change(step="checked" if good else "idle", findings=tuple(findings))

    def forget_check(self) -> None:
        """The machine was stopped since it was checked."""
        if self._desk.state.step == "checked":
            self._desk.change(step="idle", findings=(), note=texts.CHECK_AGAIN)

    def start(self) -> None:
        """Countdown, sweep, measure, file; the machine is armed and was checked."""
        if self._desk.state.step != "checked":
            self._desk.say(texts.FAILED, texts.CHECK_FIRST, wrong=True)
            return
        settings, patient, operator = self._settings(), self._desk.state.patient, self._desk.state.operator
        assert patient is not None
        threshold = self._desk.state.camera.in_use
        if self._session.live is not None:
            self._session.live.threshold = threshold
        self._desk.change(step="idle", note="")
        self._desk.job(
            texts.JOB_SCAN,
            lambda progress: self._record(settings),
            lambda folder: self._measure(settings, patient.id, operator),
            lambda err: self._broken_off(err, settings.folder),
            self._stop,
        )

    def _record(self, settings: ScanSettings) -> Path:
        from footscan.workflow.scan import record_scan

        calibration = self._station.calibration
        assert calibration is not None
        return record_scan(self._session, settings, calibration, lambda snapshot: None)

    def _measure(self, settings: ScanSettings, patient_id: int, operator: str) -> None:
        from footscan.workflow.scan import measure_recorded
        from footscan.workflow.visit import Filing, file_scan

        def work(progress: Progress) -> Take:
            calibration = self._station.calibration
            assert calibration is not None
            try:
                measure_recorded(settings, calibration, progress)
            except FootscanError:
                if not (settings.folder / "results" / "scan.json").is_file():
                    raise  # points and reasons are there otherwise, and are filed with the take
            side, subject = settings.side, settings.subject
            filing = Filing(operator, side, subject.load, subject.surface, process=False)
            return file_scan(self._station.store, patient_id, settings.folder, filing)

        self._desk.job(texts.JOB_MEASURE, work, self._show, lambda err: self._broken_off(err, settings.folder))

    def _show(self, take: Take) -> None:
        state = self._desk.state
        takes = takes_of(self._station, take.patient_id)
        self._desk.change(
            step="result",
            take=take,
            takes=takes,
            report=report_of(self._station, take),
            inspect=replace(state.inspect, take_id=take.id, tried=None, shown="Seen / assumed"),
            kept=kept_scans(self._station),
        )

    def file_kept(self, folder: Path) -> None:
        """Measure a scan that was never filed, whole or broken off, and file it for the chosen patient."""
        from footscan.workflow.process import ProcessSettings
        from footscan.workflow.scan import RECORDING, lit_by_one_laser
        from footscan.workflow.visit import Filing, file_scan, reprocess_take

        state = self._desk.state
        if state.patient is None or not state.operator:
            self._desk.say(texts.FAILED, texts.NO_PATIENT_SCAN if state.operator else texts.NO_OPERATOR, wrong=True)
            return
        patient_id = state.patient.id
        choice, by, store = state.scan, state.operator, self._station.store
        filing = Filing(by, None, choice.load, choice.surface, unfinished=True, process=False)

        def work(progress: Progress) -> Take:
            settings = ProcessSettings(one_laser=lit_by_one_laser(folder / RECORDING))
            take = file_scan(store, patient_id, folder, filing)
            return reprocess_take(store, take.id, by, texts.KEPT_FILE, settings=settings, progress=progress)

        def failed(err: FootscanError) -> None:
            takes = takes_of(self._station, patient_id)  # it may be filed although nothing could be measured
            self._desk.change(kept=kept_scans(self._station), takes=takes)
            self._stopped(err)

        self._desk.job(texts.JOB_MEASURE, work, self._show, failed)

    def _broken_off(self, err: FootscanError, folder: Path) -> None:
        kept = folder if (folder / "recording").is_dir() else self._station.scans
        note = texts.SCAN_KEPT.format(why=err, folder=kept)
        self._desk.change(step="idle", note=note, kept=kept_scans(self._station))
        self._desk.say(texts.SCAN_STOPPED, str(err), wrong=True)

    def _stopped(self, err: FootscanError) -> None:
        self._desk.change(step="idle", note=str(err))
        self._desk.say(texts.FAILED, str(err), wrong=True)

    def hold_light(self) -> None:
        """The button for laser light is down; called again and again while it is."""
        snapshot = self._session.snapshot()
        self._held_s = self._session.clock.now_s()
        if snapshot.state is State.HOLDING or self._desk.state.job is not None:
            return
        laser = self._desk.state.camera.laser
        self._session.post(lambda machine: shine_while_held(machine, laser, lambda: self._held_s))
        time.sleep(0.05)  # the next message of the same press finds the machine in its new state

    @property
    def _session(self) -> Session:
        return self._station.session

    def _settings(self) -> ScanSettings:
        from footscan.scanning.sweep import SweepSettings
        from footscan.workflow.process import ProcessSettings
        from footscan.workflow.scan import ScanSettings, scan_folder

        state = self._desk.state
        choice = state.scan
        return ScanSettings(
            scan_folder(self._station.scans, choice.side),
            choice.side,
            self._station.plan(choice.profile),
            _subject(state),
            process=ProcessSettings(SweepSettings(threshold=state.camera.in_use), side=choice.side),
        )


def _subject(state: PageState) -> Subject:
    choice = state.scan
    return Subject(choice.load, surface=choice.surface, wedge_mm=choice.wedge_mm or None, absent=_missing(state))


def _missing(state: PageState) -> tuple[str, ...]:
    """What is declared to be missing on the foot that is scanned next."""
    return next((foot.facts.missing for foot in state.feet if foot.side == state.scan.side), ())
