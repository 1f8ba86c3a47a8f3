"""What the technician does to calibrate, step by step. Every public method runs on the desk's thread."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from footscan.config import load_calibration_record
from footscan.errors import FootscanError, StoppedError
from footscan.gui import texts
from footscan.gui.desk import Desk, Progress
from footscan.gui.state import CalibrationChoice
from footscan.gui.station import Station
from footscan.scanning.recorder import MANIFEST
from footscan.workflow.calibration_log import in_force_path, keep_in_force, machine_name

if TYPE_CHECKING:
    from footscan.workflow.guided_calibration import GuidedCalibration, PlacementReport

STOPS = 16
_ARM_S = 5.0


class CalibrationWork:
    """The calibration on the page.

    Attributes:
        stops: Head angles per placement.
    """

    def __init__(self, desk: Desk, station: Station, stops: int = STOPS) -> None:
        self._desk, self._station, self.stops = desk, station, stops
        self._guided: GuidedCalibration | None = None

    @property
    def recording(self) -> bool:
        """A recording is open; nothing else may use the machine."""
        return self._guided is not None

    @property
    def can_finish(self) -> bool:
        """Enough placements are good."""
        if self._guided is None:
            return False
        from footscan.workflow.guided_calibration import FEWEST_PLACEMENTS

        return self._choice.good >= FEWEST_PLACEMENTS

    def begin(self) -> None:
        """The footboard is bare and nobody's face is near: open a recording and look at the board."""
        from footscan.config import DEFAULT_BOARD
        from footscan.workflow.guided_calibration import GuidedCalibration

        stamp = datetime.now(UTC).strftime("%Y%m%d-%H%M%S")
        folder = self._station.calibration_recordings / stamp
        guided = GuidedCalibration(self._station.session, folder, DEFAULT_BOARD, self.stops)

        def work(progress: Progress) -> None:
            self._put_board(None)
            self._arm()
            guided.begin(f"guided calibration of {self._station.rig.scanner.name}")
            self._guided = guided
            self._arm()
            guided.record_empty()

        self._job(texts.JOB_EMPTY, work, lambda _: self._change(CalibrationChoice(folder=folder, advice=guided.advice)))

    def record_placement(self) -> None:
        """The board stands where the advice says: look at it from all stops; the first one is also passed."""
        guided = self._guided
        if guided is None:
            return

        def work(progress: Progress) -> PlacementReport:
            self._put_board(guided.next_place)
            self._arm()
            report = guided.record_placement()
            if guided.needs_pass:
                self._arm()
                guided.record_pass()
            return report

        self._job(texts.JOB_PLACEMENT.format(number=len(guided.reports) + 1), work, self._judge)

    def _judge(self, report: PlacementReport) -> None:
        """How good a calibration would be that was made now."""
        from footscan.workflow.guided_calibration import ENOUGH_MM

        guided = self._guided
        assert guided is not None
        placements = (*self._choice.placements, report)
        self._change(replace(self._choice, placements=placements, advice=guided.advice, good=len(guided.good)))

        def told(expected: tuple[float | None, str]) -> None:
            error_mm, sentence = expected
            enough = error_mm is not None and error_mm <= ENOUGH_MM
            judged = replace(self._choice, expected=sentence, enough=enough)
            self._change(replace(judged, advice=guided.advice, good=len(guided.good)))

        self._job(texts.JOB_JUDGE, lambda progress: guided.expected_error_mm(), told)

    def finish(self, measured_mm: tuple[float, float] | None = None) -> None:
        """Close the recording; it is computed now, and can be at any time later."""
        guided = self._guided
        if guided is None:
            return

        def done(_: None) -> None:
            self._guided = None
            self._change(replace(self._choice, recorded=True))
            self.compute(guided.folder, measured_mm)

        self._job(texts.JOB_CLOSE, lambda progress: guided.finish(), done)

    def abandon(self) -> None:
        """Close the recording and do not use it; its pictures stay on the disk."""
        guided = self._guided
        if guided is None:
            return

        def done(_: None) -> None:
            self._guided = None
            self._change(CalibrationChoice())
            self._desk.say(texts.CALIBRATE_ABANDONED, str(guided.folder))

        self._job(texts.JOB_CLOSE, lambda progress: guided.finish(), done)

    def compute(self, folder: Path, measured_mm: tuple[float, float] | None = None) -> None:
        """A new calibration from a recording; the one in force stays in force.

        Args:
            folder: The recording.
            measured_mm: Lengths of the board over all squares, along a row and a column; None: nobody measured.
        """
        from footscan.calibration.quality import quality_lines
        from footscan.workflow.calibrate import CalibrateSettings, run_calibration

        out = folder.with_name(f"{folder.name}.calibration.toml")

        def work(progress: Progress) -> tuple[str, ...]:
            self._begin_history(out)
            try:
                made = run_calibration(folder, out, CalibrateSettings(measured_mm), progress)
            except BaseException:
                out.unlink(missing_ok=True)  # what lies there is a copy of the one in force
                raise
            return (*quality_lines(made), *([] if made.intake.board.measured else [lengths_afterwards()]))

        def refused(err: FootscanError) -> None:
            self._change(replace(self._choice, made=None, lines=(texts.CALIBRATE_REFUSED.format(why=err),)))
            self._desk.say(texts.FAILED, str(err), wrong=True)

        self._change(replace(self._choice, made=None, lines=()))
        self._job(
            texts.JOB_CALIBRATE, work, lambda lines: self._change(replace(self._choice, made=out, lines=lines)), refused
        )

    def accept(self) -> None:
        """Put the new calibration in force and open the machine again with it."""
        made = self._choice.made
        if made is None:
            return

        def work(progress: Progress) -> None:
            record = load_calibration_record(made)
            keep_in_force(self._station.data, record.calibration, record.quality, record.history)
            self._station.reopen()

        def done(_: None) -> None:
            self._change(CalibrationChoice(lines=(texts.CALIBRATE_DONE,)))
            self._desk.change(step="idle", findings=())
            self._desk.say(texts.CALIBRATE_DONE, "")

        self._job(texts.JOB_IN_FORCE, work, done)

    def keep_old(self) -> None:
        """Throw the new calibration away; its recording stays."""
        from footscan.workflow.calibrate import tables_path

        made = self._choice.made
        if made is not None:
            made.unlink(missing_ok=True)
            tables_path(made).unlink(missing_ok=True)
            self._change(CalibrationChoice(lines=(texts.CALIBRATE_KEPT,)))

    def recordings(self) -> list[Path]:
        """Finished calibration recordings in the data folder, the newest first."""
        found = self._station.calibration_recordings.glob(f"*/{MANIFEST}")
        return sorted((path.parent for path in found), reverse=True)

    def _begin_history(self, out: Path) -> None:
        """The new calibration descends from the one in force: calibrate() takes what lies in `out` as its parent."""
        scanner = self._station.rig.scanner
        in_force = self._station.calibration
        name = machine_name(in_force) if in_force is not None else scanner.machine_id or scanner.name
        path = in_force_path(self._station.data, name)
        out.unlink(missing_ok=True)
        if path.is_file():
            shutil.copyfile(path, out)

    def _put_board(self, setup: int | None) -> None:
        if self._station.opened.put_calibration_board is not None:
            self._station.opened.put_calibration_board(setup)

    def _arm(self) -> None:
        """Once for each drive of the step that the technician has confirmed."""
        self._station.session.post_arm(no_faces_at_beam_height=True).wait(_ARM_S)

    def _job(
        self,
        words: str,
        work: Callable[[Progress], Any],
        then: Callable[[Any], None],
        failed: Callable[[FootscanError], None] | None = None,
    ) -> None:
        self._desk.job(words, work, then, failed or self._failed, self._stop)

    def _stop(self) -> None:
        self._station.session.post_cancel(texts.STOPPED_BY)

    def _failed(self, err: FootscanError) -> None:
        self._desk.change()
        if isinstance(err, StoppedError):
            self._desk.say(texts.CALIBRATE_STOPPED, texts.CALIBRATE_STOPPED_NEXT.format(why=err))
        else:
            self._desk.say(texts.FAILED, str(err), wrong=True)

    @property
    def _choice(self) -> CalibrationChoice:
        return self._desk.state.calibration

    def _change(self, choice: CalibrationChoice) -> None:
        self._desk.change(calibration=choice)


def lengths_afterwards() -> str:
    """Where lengths of the board go that nobody gave."""
    return texts.BOARD_AFTERWARDS.format(row=texts.BOARD_ROW, column=texts.BOARD_COLUMN)
