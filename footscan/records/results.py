"""What processing gave: filed with its files, its definitions and its measurements; earlier results stay."""

from collections.abc import Generator, Iterable, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from footscan.config.recording_file import Load, Surface
from footscan.errors import InputError
from footscan.records.opened import OpenRecords, Storing, find_row, patient_of_take
from footscan.records.spelling import needed
from footscan.records.tables import DefinitionRow, FootRow, LandmarkRow, MeasurementRow, ResultRow, TakeRow, VisitRow
from footscan.records.values import Landmark, Measured, NewResult, NewTake, Result, Take, Verdict
from footscan.records.vault import Staged
from footscan.records.visits import side_of

CALIBRATION = "calibration.toml"


@dataclass(frozen=True)
class StagedResult:
    """A result whose files are on the disk, not yet under their names."""

    new: NewResult
    files: Staged
    calibration: Staged | None


class ResultRecords(OpenRecords):
    """Results, measurements and landmarks by hand."""

    def file_result(
        self, take_id: int, result: NewResult, results: Path, calibration: Path | None, by: str, reason: str = ""
    ) -> Take:
        """Add a new processing of a take; it counts from now on, earlier ones stay.

        Args:
            take_id: The take.
            result: What processing gave.
            results: Folder of its files; copied.
            calibration: The calibration file used; None when it is not at hand.
            by: Who had it processed.
            reason: Why again.

        Raises:
            InputError: No such take.
            StorageError: The disk is full or cannot be written; nothing was filed.
        """
        with ExitStack() as stack:
            kept = stack.enter_context(self._staged_calibration(calibration))
            made = stack.enter_context(self._staged_result(result, results, kept, link=False))
            storing = stack.enter_context(self._storing())
            row = find_row(storing.session, TakeRow, take_id)
            self._add_result(storing, row, made, by, reason)
        return self.take(take_id)

    def take(self, take_id: int) -> Take:
        """One take with its latest result.

        Raises:
            InputError: There is none of that number.
        """
        with self._database.reading() as session:
            return take_from_row(session, find_row(session, TakeRow, take_id))

    def results(self, take_id: int) -> list[Result]:
        """Every processing of a take, the latest first.

        Raises:
            InputError: There is no such take.
        """
        with self._database.reading() as session:
            find_row(session, TakeRow, take_id)
            query = select(ResultRow).where(ResultRow.take_id == take_id).order_by(ResultRow.id.desc())
            return [_result(session, row) for row in session.scalars(query)]

    def results_folder(self, result_id: int) -> Path:
        """Where the files of a result lie; never to be written to.

        Raises:
            InputError: There is no such result.
        """
        with self._database.reading() as session:
            return self._vault.path(find_row(session, ResultRow, result_id).files_sha256)

    def calibration_file(self, take_id: int) -> Path | None:
        """The calibration of the latest result of a take, else the one it was filed with; None when none was kept.

        Raises:
            InputError: There is no such take.
        """
        take = self.take(take_id)
        latest = None if take.result is None else take.result.calibration_files
        sha256 = latest or take.calibration_files
        return None if sha256 is None else self._vault.path(sha256) / CALIBRATION

    def place_landmark(self, take_id: int, name: str, xyz_world: tuple[float, float, float], by: str) -> Take:
        """Place a landmark by hand, in mm in the coordinates of the recording; one of the same name moves.

        Raises:
            InputError: No such take, or the place is not three finite numbers.
        """
        name, placed_by = needed(name, "the name of the landmark"), needed(by, "the name of who places it")
        if len(xyz_world) != 3 or not all(abs(x) < 1e4 for x in xyz_world):
            raise InputError(f"landmark {name} is at {xyz_world}; three numbers in mm are needed.")
        with self._database.writing() as session:
            take = find_row(session, TakeRow, take_id)
            same = (LandmarkRow.take_id == take_id, LandmarkRow.name == name)
            row = session.scalar(select(LandmarkRow).where(*same)) or LandmarkRow(take_id=take_id, name=name)
            row.x_world_mm, row.y_world_mm, row.z_world_mm = map(float, xyz_world)
            row.placed_by, row.placed = placed_by, self._now()
            session.add(row)
            self._log_take(session, take, by, "landmark placed", {"landmark": name, "xyz_world": list(xyz_world)})
            session.flush()
            return take_from_row(session, take)

    def remove_landmark(self, take_id: int, name: str, by: str) -> Take:
        """Take a landmark by hand away.

        Raises:
            InputError: No such take or landmark.
        """
        with self._database.writing() as session:
            take = find_row(session, TakeRow, take_id)
            same = (LandmarkRow.take_id == take_id, LandmarkRow.name == name)
            if session.scalar(select(LandmarkRow.id).where(*same)) is None:
                raise InputError(f"take {take_id} has no landmark {name} placed by hand.")
            session.execute(delete(LandmarkRow).where(*same))
            self._log_take(session, take, by, "landmark removed", {"landmark": name})
            return take_from_row(session, take)

    @contextmanager
    def _staged_result(
        self, result: NewResult | None, results: Path | None, calibration: Staged | None, *, link: bool
    ) -> Generator[StagedResult | None]:
        """The files of a result on the disk; None when there is no result."""
        if result is None or results is None:
            yield None
            return
        with self._vault.staged(results, link=link) as files:
            yield StagedResult(result, files, calibration)

    @contextmanager
    def _staged_calibration(self, calibration: Path | None) -> Generator[Staged | None]:
        if calibration is None:
            yield None
            return
        with self._vault.staged_file(calibration, CALIBRATION) as kept:
            yield kept

    def _add_result(
        self, storing: Storing, take: TakeRow, made: StagedResult | None, by: str, reason: str = ""
    ) -> None:
        if made is None:
            return
        session, new = storing.session, made.new
        row = ResultRow(
            take_id=take.id,
            computed=self._now(),
            side=new.side,
            load=new.load,
            missing=list(new.missing),
            calibration_sha256=new.calibration_sha256,
            settings=dict(new.settings),
            versions=dict(new.versions),
            refused=new.refused,
            files_sha256=storing.keep("results", made.files),
            calibration_files=keep_calibration(storing, made.calibration),
        )
        session.add(row)
        session.flush()
        session.add_all(_measurement_rows(session, row.id, new.measurements))
        self._log_take(session, take, by, "result filed", {"result": row.id, "refused": bool(new.refused)}, reason)

    def _log_take(
        self, session: Session, take: TakeRow, by: str, action: str, detail: Mapping[str, Any], reason: str = ""
    ) -> None:
        patient_id, subject = patient_of_take(session, take), f"take {take.id}"
        self._log(session, by, action, patient_id=patient_id, subject=subject, reason=reason, detail=detail)


def keep_calibration(storing: Storing, kept: Staged | None) -> str | None:
    """Keep a calibration, when there is one; its hash."""
    return None if kept is None else storing.keep("calibration", kept)


def _measurement_rows(session: Session, result_id: int, measured: Iterable[Measured]) -> list[MeasurementRow]:
    return [
        MeasurementRow(
            result_id=result_id,
            definition_id=_definition_id(session, value),
            value=value.value,
            unit=value.unit,
            reliable=value.reliable,
            reason=value.reason,
            low=None if value.interval is None else value.interval[0],
            high=None if value.interval is None else value.interval[1],
            unusual=value.unusual,
        )
        for value in measured
    ]


def _definition_id(session: Session, value: Measured) -> int:
    same = (DefinitionRow.name == value.name, DefinitionRow.version == value.version)
    row = session.scalar(select(DefinitionRow).where(*same))
    if row is None:
        row = DefinitionRow(name=value.name, version=value.version, definition=value.definition)
        session.add(row)
        session.flush()
    return row.id


def take_from_row(session: Session, row: TakeRow) -> Take:
    """A take as a value, with its latest result and its landmarks."""
    foot = find_row(session, FootRow, row.foot_id)
    visit = find_row(session, VisitRow, foot.visit_id)
    latest = select(ResultRow).where(ResultRow.take_id == row.id).order_by(ResultRow.id.desc()).limit(1)
    result = session.scalar(latest)
    marks = select(LandmarkRow).where(LandmarkRow.take_id == row.id).order_by(LandmarkRow.name)
    said = NewTake(
        side=side_of(foot),
        operator=row.operator,
        recorded=row.recorded,
        load=cast("Load", row.load),
        surface=cast("Surface", row.surface),
        load_kg=row.load_kg,
        surface_mm=row.surface_mm,
        wedge_mm=row.wedge_mm,
        machine=row.machine,
    )
    return Take(
        id=row.id,
        patient_id=visit.patient_id,
        visit_id=visit.id,
        foot_id=foot.id,
        number=row.number,
        said=said,
        missing=tuple(foot.missing),
        filed=row.filed,
        finished=row.finished,
        verdict=cast("Verdict", row.verdict),
        verdict_by=row.verdict_by,
        verdict_remark=row.verdict_remark,
        in_use=row.in_use,
        recording_sha256=row.recording_sha256,
        calibration_files=row.calibration_files,
        result=None if result is None else _result(session, result),
        landmarks=tuple(
            Landmark(mark.name, (mark.x_world_mm, mark.y_world_mm, mark.z_world_mm), mark.placed_by, mark.placed)
            for mark in session.scalars(marks)
        ),
    )


def _result(session: Session, row: ResultRow) -> Result:
    query = select(MeasurementRow, DefinitionRow).join(DefinitionRow).where(MeasurementRow.result_id == row.id)
    pairs = session.execute(query.order_by(MeasurementRow.id))
    return Result(
        side="left" if row.side == "left" else "right",
        load=cast("Load", row.load),
        missing=tuple(row.missing),
        calibration_sha256=row.calibration_sha256,
        settings=row.settings,
        versions=row.versions,
        refused=row.refused,
        measurements=tuple(_measured(value, definition) for value, definition in pairs),
        id=row.id,
        computed=row.computed,
        files_sha256=row.files_sha256,
        calibration_files=row.calibration_files,
    )


def _measured(value: MeasurementRow, definition: DefinitionRow) -> Measured:
    interval = None if value.low is None or value.high is None else (value.low, value.high)
    return Measured(
        name=definition.name,
        value=value.value,
        unit=value.unit,
        reliable=value.reliable,
        reason=value.reason,
        interval=interval,
        unusual=value.unusual,
        definition=definition.definition,
        version=definition.version,
    )
