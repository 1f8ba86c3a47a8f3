from dataclasses import replace
from datetime import date

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from footscan.errors import DuplicatePatientError, InputError
from footscan.records import NewPatient
from footscan.records.spelling import clean_name, search_key

ANA = NewPatient("Ana", date(1962, 3, 31))


def ids(patients):
    return [patient.id for patient in patients]


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(min_size=1, max_size=60))
def test_a_name_in_any_script_comes_back_as_entered_and_is_found_by_its_letters(store, name):
    try:
        clean = clean_name(name)
    except InputError:
        with pytest.raises(InputError):
            store.add_patient(NewPatient(name), "op")
        return
    patient = store.add_patient(NewPatient(name), "op", force=True)

    assert store.patient(patient.id).name == clean
    assert patient.id in ids(store.find_patients(clean, limit=1000)) or not search_key(clean)


def test_a_namesake_born_the_same_day_is_asked_about(store, ana):
    with pytest.raises(DuplicatePatientError, match=f"patient {ana.id}.*--force"):
        store.add_patient(NewPatient("  ANA ", ANA.born), "op")

    assert store.add_patient(NewPatient("ANA", ANA.born), "op", force=True).id != ana.id
    assert store.add_patient(NewPatient("Ana", date(1962, 4, 1)), "op").born == date(1962, 4, 1)


def test_own_numbers_tell_namesakes_apart_but_only_when_both_have_one(store):
    first = store.add_patient(replace(ANA, number="A1"), "op")
    second = store.add_patient(replace(ANA, number="A2"), "op")

    assert first.id != second.id
    with pytest.raises(DuplicatePatientError):
        store.add_patient(ANA, "op")


def test_a_number_is_given_once(store, ana, bo):
    store.edit_patient(ana.id, replace(ANA, number="7"), "op")
    with pytest.raises(InputError, match=f"the number 7 is that of patient {ana.id}"):
        store.edit_patient(bo.id, NewPatient("Bo", number="7"), "op")


def test_two_unknown_birth_dates_are_the_same(store):
    store.add_patient(NewPatient("Eva"), "op")
    with pytest.raises(DuplicatePatientError, match="no birth date"):
        store.add_patient(NewPatient("eva"), "op")


@pytest.mark.parametrize(
    ("typed", "found"),
    [
        ("ana", 1),
        ("AN", 1),
        ("1962-03", 1),
        ("n-7", 1),
        ("ana 1962", 1),
        ("ana bo", 0),
        ("%", 0),
        ("_", 0),
        ("", 2),
        ("\ud800", 0),
    ],
)
def test_patients_are_found_by_what_is_typed(store, ana, bo, typed, found):
    store.edit_patient(ana.id, replace(ANA, number="N-7"), "op")

    assert len(store.find_patients(typed)) == found


def test_an_impossible_birth_date_is_refused_and_nothing_is_stored(store):
    with pytest.raises(InputError, match="1900-01-01"):
        store.add_patient(NewPatient("Ana", date(2026, 11, 25)), "op")

    assert store.find_patients() == []
    assert store.audit() == []


def test_the_log_names_changed_fields_but_no_personal_data(store, ana):
    store.edit_patient(ana.id, NewPatient("Anabel Secret", date(1962, 3, 30), "S-9", "private"), "op")
    store.delete_patient(ana.id, "asked for", "chief")
    log = store.audit(ana.id)

    assert [entry.action for entry in log] == ["patient deleted", "patient edited", "patient added"]
    assert log[1].detail == {"changed": ["name", "born", "number", "notes"]}
    assert (log[0].by, log[0].reason) == ("chief", "asked for")
    assert not any(word in str(log) for word in ("Ana", "Secret", "S-9", "private", "1962"))


def test_deleting_removes_rows_and_files_and_leaves_those_of_others(store, data, ana, bo, file_scan):
    gone, stays = file_scan(ana, 1), file_scan(bo, 2)
    folders = [store.recording_folder(gone.id), store.results_folder(gone.result.id)]
    store.delete_patient(ana.id, "asked for", "op")

    assert not any(folder.exists() for folder in folders)
    assert store.recording_folder(stays.id).is_dir()
    assert store.check_records() == []
    assert store.find_leftovers() == []
    for number, ask in ((ana.id, store.patient), (gone.id, store.take)):
        with pytest.raises(InputError, match=f"{number}"):
            ask(number)
    raw = b"".join(path.read_bytes() for path in data.glob("records.sqlite3*"))
    assert b"1962-03-31" not in raw


def test_a_deleted_number_is_never_given_again(store, bo):
    store.delete_patient(bo.id, "test", "op")

    assert store.add_patient(NewPatient("Cy"), "op").id > bo.id


@pytest.mark.parametrize("reason", ["", "   "])
def test_deleting_needs_a_reason(store, ana, reason):
    with pytest.raises(InputError, match="the reason is empty"):
        store.delete_patient(ana.id, reason, "op")

    assert store.patient(ana.id) == ana


@pytest.mark.parametrize("number", [0, -1, 99, 2**63, 2**200])
def test_an_unknown_number_is_said(store, number):
    with pytest.raises(InputError, match="there is no patient"):
        store.patient(number)


def test_everything_needs_somebody_who_does_it(store, ana):
    with pytest.raises(InputError, match="who does this"):
        store.edit_patient(ana.id, replace(ANA, notes="x"), " ")

    assert store.patient(ana.id) == ana
