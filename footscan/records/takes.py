"""Takes: recordings filed with their results, judged, and marked as the one in use."""

import contextlib
import time
from contextlib import ExitStack
from pathlib import Path
from typing import get_args

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from footscan.config.recording_file import Load, Surface
from footscan.errors import InputError
from footscan.records.data_folder import SCANS
from footscan.records.opened import find_row, patient_of_take
from footscan.records.results import CALIBRATION, ResultRecords, keep_calibration, take_from_row
from footscan.records.spelling import check_word, needed
from footscan.records.tables import FootRow, TakeRow
from footscan.records.tree_hash import hash_of_folder
from footscan.records.values import NewResult, NewTake, Take, Verdict
from footscan.records.vault import Staged
from footscan.records.visits import VisitRecords, foot_row
from footscan.scanning.recording import MANIFEST

LOADS: tuple[str, ...] = get_args(Load)
SURFACES: tuple[str, ...] = get_args(Surface)
_VERDICTS: tuple[str, ...] = get_args(Verdict)
QUIET_S = 10.0
"""A recording without checksums that changed more recently may still be running."""
_MUST_SAY_WHY: tuple[Verdict, ...] = ("with_remark", "repeat")


class TakeRecords(ResultRecords, VisitRecords):
    """Takes."""

    def file_take(
        self,
        patient_id: int,
        said: NewTake,
        recording: Path,
        result: NewResult | None = None,
        results: Path | None = None,
        calibration: Path | None = None,
        *,
        unfinished: bool = False,
    ) -> Take:
        """Take over a recording, and what was made of it, for a patient.

        When this returns, files and rows are on the disk. A scan folder inside the data folder is removed then (it is
        shared by hard links until that moment); any other source is copied and left as it is.

        Args:
            patient_id: The patient; the visit is that of the day of the recording.
            said: Side, load, surface, operator and the like.
            recording: The recording's folder.
            result: What processing gave; needs `results`.
            results: Folder of the results.
            calibration: The calibration file in force, kept so that the take can be processed again.
            unfinished: Accept a recording that was broken off (without its checksums).

        Raises:
            InputError: No such patient; the folder is no recording, unfinished, or filed already.
            StorageError: The disk is full or cannot be written; nothing was filed.
        """
        check_word(said.load, LOADS, "the load")
        check_word(said.surface, SURFACES, "the surface")
        finished = _check_recording(recording, unfinished)
        scan = self._scan_of(recording)
        with ExitStack() as stack:
            own = scan is not None and finished
            staged = stack.enter_context(self._vault.staged(recording, link=own))
            kept = stack.enter_context(self._staged_calibration(calibration))
            made = stack.enter_context(self._staged_result(result, results, kept, link=scan is not None))
            storing = stack.enter_context(self._storing())
            session = storing.session
            _refuse_second(session, staged)
            row = self._new_row(session, patient_id, said, finished)
            row.source = None if scan is None else scan.name
            row.recording_sha256 = storing.keep("recording", staged)
            row.calibration_files = keep_calibration(storing, kept)
            session.add(row)
            session.flush()
            detail = {"side": said.side, "load": said.load, "number": row.number}
            self._log_take(session, row, said.operator, "take filed", detail)
            self._add_result(storing, row, made, said.operator)
            take_id = row.id
        if scan is not None:
            with self._database.lock.held():
                self._give_up(scan, take_id)
        return self.take(take_id)

    def _new_row(self, session: Session, patient_id: int, said: NewTake, finished: bool) -> TakeRow:
        operator = needed(said.operator, "the name of the operator")
        visit = self._visit_on(session, patient_id, said.recorded.astimezone().date(), operator)
        foot = foot_row(session, visit.id, said.side)
        foot.not_scanned = ""
        return TakeRow(
            foot_id=foot.id,
            number=next_number(session, foot.id),
            load=said.load,
            load_kg=said.load_kg,
            surface=said.surface,
            surface_mm=said.surface_mm,
            wedge_mm=said.wedge_mm,
            operator=operator,
            machine=said.machine,
            recorded=said.recorded,
            filed=self._now(),
            finished=finished,
            verdict="undecided",
            verdict_by="",
            verdict_remark="",
            in_use=False,
        )

    def takes(self, visit_id: int) -> list[Take]:
        """The takes of a visit: left before right, in the order of their numbers."""
        query = select(TakeRow).join(FootRow).where(FootRow.visit_id == visit_id)
        with self._database.reading() as session:
            rows = session.scalars(query.order_by(FootRow.side, TakeRow.number))
            return [take_from_row(session, row) for row in rows]

    def stale_takes(self) -> list[Take]:
        """Takes whose latest result was made with another side, load or missing parts than are known now."""
        with self._database.reading() as session:
            takes = [take_from_row(session, row) for row in session.scalars(select(TakeRow).order_by(TakeRow.id))]
        return [take for take in takes if take.stale]

    def judge_take(self, take_id: int, verdict: Verdict, by: str, remark: str = "") -> Take:
        """A person's word on a take; `repeat` also takes the mark "in use" away.

        Raises:
            InputError: No such take, or no remark where one is needed.
        """
        check_word(verdict, _VERDICTS, "the verdict")
        if verdict in _MUST_SAY_WHY:
            remark = needed(remark, "the remark")
        with self._database.writing() as session:
            row = find_row(session, TakeRow, take_id)
            row.verdict, row.verdict_by, row.verdict_remark = verdict, needed(by, "the name of who decides"), remark
            row.in_use = row.in_use and verdict != "repeat"
            self._log_take(session, row, by, "take judged", {"verdict": verdict}, remark)
            session.flush()
            return take_from_row(session, row)

    def use_take(self, take_id: int, by: str) -> Take:
        """Mark a take as the one in use for its foot and load; another one so marked loses the mark.

        Raises:
            InputError: No such take, no measured foot in it, or it is to be repeated.
        """
        with self._database.writing() as session:
            row = find_row(session, TakeRow, take_id)
            _refuse_useless(take_from_row(session, row))
            for other in in_use(session, row.foot_id, row.load):
                other.in_use = False
            session.flush()
            row.in_use = True
            session.flush()
            self._log_take(session, row, by, "take in use", {})
            return take_from_row(session, row)

    def recording_folder(self, take_id: int) -> Path:
        """Where the recording of a take lies; never to be written to."""
        return self._vault.path(self.take(take_id).recording_sha256)

    def _scan_of(self, recording: Path) -> Path | None:
        """The scan folder a recording lies in, when it is one of the data folder's own."""
        scan = recording.resolve().parent
        return scan if scan.parent == (self.data / SCANS).resolve() and recording.name == "recording" else None

    def _give_up(self, scan: Path, take_id: int) -> None:
        """Remove from a scan folder what is kept by now; the recording goes last, because by it the scan is known."""
        for result in self.results(take_id):
            if _is_kept(scan / "results", result.files_sha256):
                self._vault.discard(scan / "results")
        kept = self.take(take_id).calibration_files
        if kept is not None and _same_file(scan / CALIBRATION, self._vault.path(kept) / CALIBRATION):
            self._vault.discard(scan / CALIBRATION)
        self._vault.discard(scan / "recording")
        with contextlib.suppress(OSError):  # something else lies in it: that is not ours to remove
            scan.rmdir()

    def _finish_moves(self) -> None:
        """Give up scan folders that were filed by a program killed before it could; needs the writer's lock."""
        with self._database.reading() as session:
            query = select(TakeRow.id, TakeRow.source, TakeRow.recording_sha256).where(TakeRow.source.is_not(None))
            filed = [(take_id, self.data / SCANS / str(source), sha) for take_id, source, sha in session.execute(query)]
        for take_id, scan, sha256 in filed:
            if not scan.is_dir():
                continue
            if _is_kept(scan / "recording", sha256) and self._vault.path(sha256).is_dir():
                self._give_up(scan, take_id)
            elif not (scan / "recording").exists():
                with contextlib.suppress(OSError):
                    scan.rmdir()


def _is_kept(folder: Path, sha256: str) -> bool:
    return folder.is_dir() and hash_of_folder(folder) == sha256


def _same_file(path: Path, kept: Path) -> bool:
    return path.is_file() and path.read_bytes() == kept.read_bytes()


def _check_recording(recording: Path, unfinished: bool) -> bool:
    """Whether a recording was finished.

    Raises:
        InputError: It is no recording; it is unfinished and that was not allowed; it is still being written.
    """
    if not (recording / "recording.toml").is_file():
        raise InputError(f"{recording} has no recording.toml, so it is no recording; give the recording's own folder.")
    if (recording / MANIFEST).is_file():
        return True
    if not unfinished:
        raise InputError(
            f"{recording} was broken off (it has no {MANIFEST}); scan again, or file what there is with --unfinished."
        )
    newest = max(path.stat().st_mtime for path in (recording, *recording.rglob("*")))
    if time.time() - newest < QUIET_S:
        raise InputError(f"{recording} is still being written; wait until the scan has ended, then repeat.")
    return False


def _refuse_second(session: Session, staged: Staged) -> None:
    other = session.scalar(select(TakeRow).where(TakeRow.recording_sha256 == staged.sha256))
    if other is not None:
        raise InputError(
            f"this recording is already filed as take {other.id} of patient {patient_of_take(session, other)}; "
            "if that was the wrong patient or side, correct that take."
        )


def _refuse_useless(take: Take) -> None:
    if take.verdict == "repeat":
        raise InputError(f"take {take.id} is marked to be repeated; accept it first, or use another take.")
    if take.result is None or take.result.refused:
        raise InputError(f"take {take.id} has no measured foot; process it again, or use another take.")


def next_number(session: Session, foot_id: int) -> int:
    """The number of the next take of a foot."""
    return 1 + (session.scalar(select(func.max(TakeRow.number)).where(TakeRow.foot_id == foot_id)) or 0)


def in_use(session: Session, foot_id: int, load: str) -> list[TakeRow]:
    """The take in use for a foot and load, if any."""
    query = select(TakeRow).where(TakeRow.foot_id == foot_id, TakeRow.load == load, TakeRow.in_use)
    return list(session.scalars(query))
