"""Patients, visits, feet, takes and what was measured, kept in one data folder.

`RecordStore` is the only way in; what comes out are frozen values, never rows of the database.
"""

from footscan.records.data_folder import data_folder
from footscan.records.kept import Leftover
from footscan.records.store import RecordStore
from footscan.records.values import (
    AuditEntry,
    Correction,
    Foot,
    FootFacts,
    Landmark,
    Measured,
    NewPatient,
    NewResult,
    NewTake,
    Patient,
    Result,
    Take,
    Verdict,
    Visit,
)

__all__ = [
    "AuditEntry",
    "Correction",
    "Foot",
    "FootFacts",
    "Landmark",
    "Leftover",
    "Measured",
    "NewPatient",
    "NewResult",
    "NewTake",
    "Patient",
    "RecordStore",
    "Result",
    "Take",
    "Verdict",
    "Visit",
    "data_folder",
]
