"""Patients: entered, found by typing, edited, deleted on a person's word."""

from dataclasses import replace

from sqlalchemy import String, cast, select
from sqlalchemy.orm import Session

from footscan.errors import DuplicatePatientError, InputError
from footscan.records.opened import OpenRecords, find_row
from footscan.records.spelling import (
    check_born,
    clean_name,
    clean_notes,
    clean_number,
    key_of_name,
    needed,
    search_key,
)
from footscan.records.tables import FootRow, PatientRow, ResultRow, StoredRow, TakeRow, VisitRow
from footscan.records.values import NewPatient, Patient
from footscan.records.vault import DISCARD

MOST_FOUND = 50


class PatientRecords(OpenRecords):
    """Patients."""

    def add_patient(self, new: NewPatient, by: str, *, force: bool = False) -> Patient:
        """Enter a patient.

        Args:
            new: Name in any script; the rest may be missing.
            by: Who enters it.
            force: Another person of the same name and birth date is meant.

        Raises:
            InputError: An impossible name or date, or a number that another patient has.
            DuplicatePatientError: Same name and birth date as a patient who is there; a person must decide.
        """
        clean = self._checked(new)
        with self._database.writing() as session:
            _refuse_taken_number(session, clean, own_id=0)
            if not force:
                _ask_about_namesakes(session, clean, own_id=0)
            row = PatientRow(created=self._now())
            _fill(row, clean)
            session.add(row)
            session.flush()
            self._log(session, by, "patient added", patient_id=row.id, subject=f"patient {row.id}")
            return _patient(row)

    def edit_patient(self, patient_id: int, new: NewPatient, by: str, *, force: bool = False) -> Patient:
        """Replace what is kept of a person; the log names the changed fields, not their content.

        Raises:
            InputError: As `add_patient`, or no such patient.
            DuplicatePatientError: As `add_patient`.
        """
        clean = self._checked(new)
        with self._database.writing() as session:
            row = find_row(session, PatientRow, patient_id)
            before = _new(row)
            _refuse_taken_number(session, clean, own_id=row.id)
            if not force and (clean.name, clean.born) != (before.name, before.born):
                _ask_about_namesakes(session, clean, own_id=row.id)
            fields = ("name", "born", "number", "notes")
            changed = [name for name in fields if getattr(before, name) != getattr(clean, name)]
            _fill(row, clean)
            if changed:
                detail = {"changed": changed}
                self._log(session, by, "patient edited", patient_id=row.id, subject=f"patient {row.id}", detail=detail)
            return _patient(row)

    def patient(self, patient_id: int) -> Patient:
        """One patient.

        Raises:
            InputError: There is none of that number.
        """
        with self._database.reading() as session:
            return _patient(find_row(session, PatientRow, patient_id))

    def find_patients(self, typed: str = "", limit: int = MOST_FOUND) -> list[Patient]:
        """Patients whose name holds every typed word, or whose own number or birth date begins with what was typed.

        Case and accents do not matter; nothing typed gives everybody, in the order of names, at most `limit`.
        """
        key = search_key(typed.encode("utf-8", "replace").decode())  # a terminal may hand over broken text
        query = select(PatientRow).order_by(PatientRow.search_key, PatientRow.born, PatientRow.id).limit(limit)
        for word in key.split():
            query = query.where(
                PatientRow.search_key.contains(word, autoescape=True)
                | PatientRow.number.istartswith(word, autoescape=True)
                | cast(PatientRow.born, String).startswith(word, autoescape=True)
            )
        with self._database.reading() as session:
            return [_patient(row) for row in session.scalars(query)]

    def delete_patient(self, patient_id: int, reason: str, by: str) -> None:
        """Remove a patient with all visits, takes, results and files; the log keeps its lines, which hold no name.

        Raises:
            InputError: No such patient, or no reason.
        """
        reason = needed(reason, "the reason")
        with self._database.writing() as session:
            row = find_row(session, PatientRow, patient_id)
            doomed = _only_of(session, patient_id)
            session.delete(row)
            session.flush()
            for sha256 in doomed:
                session.get_one(StoredRow, sha256).discarded = True
            detail = {"folders_removed": len(doomed)}
            self._log(
                session,
                by,
                "patient deleted",
                patient_id=patient_id,
                subject=f"patient {patient_id}",
                reason=reason,
                detail=detail,
            )
        self._finish_discards()

    def _discards_waiting(self) -> bool:
        with self._database.reading() as session:
            ordered = session.scalar(select(StoredRow.sha256).where(StoredRow.discarded).limit(1))
        return ordered is not None or any(path.name.startswith(DISCARD) for path in self._vault.dead_stages())

    def _finish_discards(self) -> None:
        """Remove the folders of deleted patients; repeated after a kill."""
        with self._database.writing() as session:
            for row in session.scalars(select(StoredRow).where(StoredRow.discarded)):
                self._vault.remove(row.sha256)
                session.delete(row)
            self._vault.finish_discards()
        self._database.forget_journal()

    def _checked(self, new: NewPatient) -> NewPatient:
        today = self._now().astimezone().date()
        return replace(
            new,
            name=clean_name(new.name),
            born=check_born(new.born, today),
            number=clean_number(new.number),
            notes=clean_notes(new.notes),
        )


def _fill(row: PatientRow, clean: NewPatient) -> None:
    row.name, row.born, row.number, row.notes = clean.name, clean.born, clean.number, clean.notes
    row.name_key, row.search_key = key_of_name(clean.name), search_key(clean.name)


def _refuse_taken_number(session: Session, clean: NewPatient, own_id: int) -> None:
    if clean.number is None:
        return
    other = session.scalar(select(PatientRow).where(PatientRow.number == clean.number, PatientRow.id != own_id))
    if other is not None:
        raise InputError(f"the number {clean.number} is that of patient {other.id}; every number is given once.")


def _ask_about_namesakes(session: Session, clean: NewPatient, own_id: int) -> None:
    """Two people of one name and birth date are told apart by own numbers; else a person must decide."""
    same = (PatientRow.name_key == key_of_name(clean.name), PatientRow.born == clean.born, PatientRow.id != own_id)
    others = session.scalars(select(PatientRow).where(*same)).all()
    unclear = [row for row in others if clean.number is None or row.number is None]
    if unclear:
        born = "no birth date" if clean.born is None else f"born {clean.born.isoformat()}"
        raise DuplicatePatientError(
            f"{clean.name}, {born}, is already there as patient {unclear[0].id}; use that one, or if this is another "
            "person say so (--force, or own numbers for both)."
        )


def _only_of(session: Session, patient_id: int) -> list[str]:
    """Hashes of the folders that belong to this patient and to nobody else."""
    takes = select(TakeRow.id).join(FootRow).join(VisitRow).where(VisitRow.patient_id == patient_id)
    recordings = set(session.scalars(select(TakeRow.recording_sha256).where(TakeRow.id.in_(takes))))
    own, others = ResultRow.take_id.in_(takes), ResultRow.take_id.not_in(takes)
    mine = set(session.scalars(select(ResultRow.files_sha256).where(own)))
    theirs = set(session.scalars(select(ResultRow.files_sha256).where(others)))
    return sorted(recordings | (mine - theirs))


def _new(row: PatientRow) -> NewPatient:
    return NewPatient(row.name, row.born, row.number, row.notes)


def _patient(row: PatientRow) -> Patient:
    return Patient(row.name, row.born, row.number, row.notes, row.id, row.created)
