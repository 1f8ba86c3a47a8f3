"""Visits, and what a person declares of each foot."""

from dataclasses import asdict, replace
from datetime import date
from typing import get_args

from sqlalchemy import select
from sqlalchemy.orm import Session

from footscan.coordinates import Side
from footscan.records.opened import OpenRecords, find_row
from footscan.records.spelling import check_word, clean_line, clean_notes, needed
from footscan.records.tables import FootRow, PatientRow, VisitRow
from footscan.records.values import Foot, FootFacts, Visit

SIDES: tuple[str, ...] = get_args(Side)


class VisitRecords(OpenRecords):
    """Visits and feet."""

    def open_visit(self, patient_id: int, by: str, notes: str = "") -> Visit:
        """Today's visit of a patient: the one already open, or a new one; notes given are added to it.

        Raises:
            InputError: No such patient.
        """
        today, notes = self._now().astimezone().date(), clean_notes(notes)
        with self._database.writing() as session:
            row = self._visit_on(session, patient_id, today, by)
            row.notes = "\n".join(part for part in (row.notes, notes) if part)
            return visit_from_row(row)

    def visits(self, patient_id: int) -> list[Visit]:
        """All visits of a patient, the latest first.

        Raises:
            InputError: No such patient.
        """
        with self._database.reading() as session:
            find_row(session, PatientRow, patient_id)
            query = select(VisitRow).where(VisitRow.patient_id == patient_id)
            return [
                visit_from_row(row) for row in session.scalars(query.order_by(VisitRow.day.desc(), VisitRow.id.desc()))
            ]

    def visit(self, visit_id: int) -> Visit:
        """One visit.

        Raises:
            InputError: There is none of that number.
        """
        with self._database.reading() as session:
            return visit_from_row(find_row(session, VisitRow, visit_id))

    def feet(self, visit_id: int) -> list[Foot]:
        """The feet that were scanned or spoken of on a visit, left before right."""
        with self._database.reading() as session:
            query = select(FootRow).where(FootRow.visit_id == visit_id).order_by(FootRow.side)
            return [foot_from_row(row) for row in session.scalars(query)]

    def declare_foot(self, visit_id: int, side: Side, facts: FootFacts, by: str) -> Foot:
        """Say what is missing, dressed or deformed on a foot, or why it is not scanned; replaces what was said before.

        Missing parts are taken as they are; `footscan.workflow.visit.declare_foot` checks their names.

        Raises:
            InputError: No such visit, or text with control characters.
        """
        facts = _checked(facts)
        with self._database.writing() as session:
            visit = find_row(session, VisitRow, visit_id)
            row = foot_row(session, visit_id, side)
            before = foot_from_row(row).facts
            row.missing, row.dressings = list(facts.missing), facts.dressings
            row.deformity, row.not_scanned = facts.deformity, facts.not_scanned
            changed = [name for name, value in asdict(before).items() if value != getattr(facts, name)]
            if changed:
                subject, detail = f"visit {visit_id}, {side} foot", {"changed": changed}
                self._log(session, by, "foot declared", patient_id=visit.patient_id, subject=subject, detail=detail)
            return foot_from_row(row)

    def _visit_on(self, session: Session, patient_id: int, day: date, by: str) -> VisitRow:
        """The latest visit of a patient on a day, made when there is none."""
        patient = find_row(session, PatientRow, patient_id)
        query = select(VisitRow).where(VisitRow.patient_id == patient.id, VisitRow.day == day)
        row = session.scalar(query.order_by(VisitRow.id.desc()).limit(1))
        if row is None:
            operator = needed(by, "the name of the operator")
            row = VisitRow(patient_id=patient.id, day=day, opened=self._now(), operator=operator, notes="")
            session.add(row)
            session.flush()
            self._log(session, by, "visit opened", patient_id=patient.id, subject=f"visit {row.id}")
        return row


def foot_row(session: Session, visit_id: int, side: Side) -> FootRow:
    """The foot of a visit, made when it is not there yet.

    Raises:
        InputError: The side is neither left nor right.
    """
    check_word(side, SIDES, "the side")
    row = find_foot(session, visit_id, side)
    if row is None:
        row = FootRow(visit_id=visit_id, side=side, missing=[], dressings="", deformity="", not_scanned="")
        session.add(row)
        session.flush()
    return row


def find_foot(session: Session, visit_id: int, side: Side) -> FootRow | None:
    """The foot of a visit if it was ever spoken of."""
    return session.scalar(select(FootRow).where(FootRow.visit_id == visit_id, FootRow.side == side))


def _checked(facts: FootFacts) -> FootFacts:
    return replace(
        facts,
        missing=tuple(dict.fromkeys(needed(part, "a missing part") for part in facts.missing)),
        dressings=clean_line(facts.dressings, "dressings"),
        deformity=clean_line(facts.deformity, "deformity"),
        not_scanned=clean_line(facts.not_scanned, "why the foot is not scanned"),
    )


def visit_from_row(row: VisitRow) -> Visit:
    """A visit as a value."""
    return Visit(row.id, row.patient_id, row.day, row.opened, row.operator, row.notes)


def side_of(row: FootRow) -> Side:
    """The side of a foot; the table allows no other."""
    return "left" if row.side == "left" else "right"


def foot_from_row(row: FootRow) -> Foot:
    """A foot as a value."""
    facts = FootFacts(tuple(row.missing), row.dressings, row.deformity, row.not_scanned)
    return Foot(row.id, row.visit_id, side_of(row), facts)
