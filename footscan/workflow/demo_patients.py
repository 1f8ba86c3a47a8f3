"""Two patients of nobody's, to try everything with."""

from datetime import date

from footscan.records import NewPatient, RecordStore

_DEMO = (
    NewPatient("Anna Example", date(1962, 3, 31), "DEMO-1"),
    NewPatient("Jürgen Muster", date(1987, 11, 2), "DEMO-2"),
)
_BY = "footscan"


def add_demo_patients(store: RecordStore) -> None:
    """Enter them, once; records that hold patients already are left alone."""
    if not store.find_patients("", 1):
        for patient in _DEMO:
            store.add_patient(patient, _BY)
