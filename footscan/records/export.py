"""Everything kept of one patient as plain values, on a person's word only."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from datetime import date, datetime
from typing import Any

from footscan.records.audit import AuditRecords
from footscan.records.patients import PatientRecords
from footscan.records.takes import TakeRecords
from footscan.records.values import Take

FORMAT = "footscan-patient/1"


class ExportRecords(PatientRecords, TakeRecords, AuditRecords):
    """Exports."""

    def export_patient(self, patient_id: int, by: str, purpose: str = "") -> dict[str, Any]:
        """Everything kept of one patient, ready for JSON; the log says who took it and what for.

        Files (recordings, surfaces) are named by hash and not included.

        Raises:
            InputError: No such patient.
        """
        patient = self.patient(patient_id)
        with self._database.writing() as session:
            subject = f"patient {patient_id}"
            self._log(session, by, "patient exported", patient_id=patient_id, subject=subject, reason=purpose)
        return {
            "format": FORMAT,
            "patient": _plain(patient),
            "visits": [self._visit_of_export(visit.id) for visit in self.visits(patient_id)],
            "log": [_plain(entry) for entry in reversed(self.audit(patient_id))],
        }

    def _visit_of_export(self, visit_id: int) -> dict[str, Any]:
        return {
            **_plain(self.visit(visit_id)),
            "feet": [_plain(foot) for foot in self.feet(visit_id)],
            "takes": [self._take_of_export(take) for take in self.takes(visit_id)],
        }

    def _take_of_export(self, take: Take) -> dict[str, Any]:
        plain = _plain(take)
        del plain["result"]
        return {**plain, "stale": take.stale, "results": [_plain(result) for result in self.results(take.id)]}


def _plain(value: Any) -> Any:
    """Dataclasses, moments and tuples as what JSON knows."""
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, datetime | date):
        return value.isoformat()
    if isinstance(value, Mapping):
        return {str(key): _plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return value
