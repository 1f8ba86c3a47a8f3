"""Reading the log. Lines are only ever added, by what they speak of, in the same transaction."""

from sqlalchemy import select

from footscan.records.opened import OpenRecords
from footscan.records.tables import AuditRow
from footscan.records.values import AuditEntry


class AuditRecords(OpenRecords):
    """The log."""

    def audit(self, patient_id: int | None = None, limit: int | None = None) -> list[AuditEntry]:
        """The log, the latest line first; of one patient (also a deleted one), or of everything."""
        query = select(AuditRow).order_by(AuditRow.id.desc()).limit(limit)
        if patient_id is not None:
            query = query.where(AuditRow.patient_id == patient_id)
        with self._database.reading() as session:
            return [_entry(row) for row in session.scalars(query)]


def _entry(row: AuditRow) -> AuditEntry:
    return AuditEntry(row.id, row.at, row.by, row.action, row.patient_id, row.subject, row.reason, row.detail)
