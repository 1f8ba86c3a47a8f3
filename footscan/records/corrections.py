"""Wrong patient, side, load or surface: put right afterwards, with a reason that stays in the log."""

from typing import Any

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from footscan.errors import InputError
from footscan.records.opened import find_row, patient_of_take
from footscan.records.results import take_from_row
from footscan.records.spelling import check_word, needed
from footscan.records.tables import FootRow, PatientRow, TakeRow, VisitRow
from footscan.records.takes import LOADS, SURFACES, TakeRecords, in_use, next_number
from footscan.records.values import Correction, Take
from footscan.records.visits import SIDES, find_foot, foot_row, side_of


class CorrectionRecords(TakeRecords):
    """Corrections."""

    def correct_take(self, take_id: int, right: Correction, reason: str, by: str) -> Take:
        """Put a take where it belongs. The recording stays as it is; a result that no longer fits is `stale`.

        A foot of which this is the only take moves with what was declared of it, unless the other place has such a
        foot already. Where another take is in use there, this one loses that mark.

        Raises:
            InputError: No such take or patient, nothing to correct, or no reason.
        """
        reason = needed(reason, "the reason")
        _check_words(right)
        with self._database.writing() as session:
            take = find_row(session, TakeRow, take_id)
            before = _place(session, take)
            load = right.load or take.load
            take.surface = right.surface or take.surface
            self._move(session, take, right, load, by)
            after = _place(session, take)
            if after == before:
                raise InputError(f"take {take_id} is already so: {_in_words(before)}; nothing was changed.")
            detail = {"before": before, "after": after}
            self._log_take(session, take, by, "take corrected", detail, reason)
            if before["patient"] != after["patient"]:
                subject = f"take {take_id}"
                self._log(
                    session,
                    by,
                    "take moved away",
                    patient_id=before["patient"],
                    subject=subject,
                    reason=reason,
                    detail=detail,
                )
            session.flush()
            return take_from_row(session, take)

    def _move(self, session: Session, take: TakeRow, right: Correction, load: str, by: str) -> None:
        foot = find_row(session, FootRow, take.foot_id)
        visit = find_row(session, VisitRow, foot.visit_id)
        side = right.side or side_of(foot)
        target_visit = visit
        if right.patient_id is not None and right.patient_id != visit.patient_id:
            find_row(session, PatientRow, right.patient_id)
            target_visit = self._visit_on(session, right.patient_id, visit.day, by)
        target = find_foot(session, target_visit.id, side)
        if target is None and _count_takes(session, foot.id) == 1:
            foot.visit_id, foot.side, target = target_visit.id, side, foot
            session.flush()
        target = target or foot_row(session, target_visit.id, side)
        if (target.id, load) != (take.foot_id, take.load) and in_use(session, target.id, load):
            take.in_use = False
            session.flush()
        if target.id != take.foot_id:
            take.number = next_number(session, target.id)
        take.foot_id, take.load = target.id, load
        session.flush()
        _remove_if_empty(session, visit)


def _check_words(right: Correction) -> None:
    given = (("the side", right.side, SIDES), ("the load", right.load, LOADS), ("the surface", right.surface, SURFACES))
    for what, value, allowed in given:
        if value is not None:
            check_word(value, allowed, what)


def _place(session: Session, take: TakeRow) -> dict[str, Any]:
    side = find_row(session, FootRow, take.foot_id).side
    patient_id = patient_of_take(session, take)
    return {"patient": patient_id, "side": side, "load": take.load, "surface": take.surface, "in_use": take.in_use}


def _in_words(place: dict[str, Any]) -> str:
    return f"patient {place['patient']}, {place['side']}, load {place['load']}, surface {place['surface']}"


def _count_takes(session: Session, foot_id: int) -> int:
    return session.scalar(select(func.count()).select_from(TakeRow).where(TakeRow.foot_id == foot_id)) or 0


def _remove_if_empty(session: Session, visit: VisitRow) -> None:
    """A visit that only the wrongly filed take had made is no visit."""
    feet = session.scalar(select(func.count()).select_from(FootRow).where(FootRow.visit_id == visit.id))
    if not feet and not visit.notes:
        session.delete(visit)
        session.flush()
