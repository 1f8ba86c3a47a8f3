"""Several programs and threads at once: one writes, the others wait or are told."""

import sqlite3
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing

import pytest

from footscan.errors import DuplicatePatientError, RecordsError
from footscan.records import NewPatient, RecordStore
from footscan.records.writer_lock import WriterLock

ADD = "import sys; from pathlib import Path; from footscan.records import *; store = RecordStore(Path(sys.argv[1])); "
MANY = "[store.add_patient(NewPatient(f'{sys.argv[2]} {k}'), 'op') for k in range(15)]"


def test_a_second_writer_waits_for_the_first(data):
    RecordStore(data).close()
    programs = [subprocess.Popen([sys.executable, "-c", ADD + MANY, str(data), name]) for name in ("Ana", "Bo")]

    assert [program.wait(timeout=120) for program in programs] == [0, 0]
    with RecordStore(data) as store:
        assert len(store.find_patients()) == 30
        assert [entry.id for entry in store.audit()] == list(range(30, 0, -1))


def test_a_second_writer_that_waits_too_long_is_told_by_whom(data):
    RecordStore(data).close()
    hold = ADD + "lock = store._database.lock.held(); lock.__enter__(); print('held', flush=True); sys.stdin.read()"
    command = [sys.executable, "-c", hold, str(data)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout.readline() == "held\n"
        with pytest.raises(RecordsError, match=rf"process {other.pid}\).*more than 0.1 s; let it finish or close it"):
            RecordStore(data, wait_s=0.1)
        other.kill()
        other.wait()
        RecordStore(data, wait_s=0.1).close()


def test_reading_goes_on_while_another_writes(store, ana, data):
    with WriterLock(data / "writer.lock", 0.1).held():
        assert store.patient(ana.id) == ana
        assert store.find_patients("ana") == [ana]


def test_threads_share_a_store(store):
    with ThreadPoolExecutor(4) as pool:
        added = list(pool.map(lambda k: store.add_patient(NewPatient(f"Ana {k}"), "op").id, range(24)))

    assert sorted(added) == list(range(1, 25))
    assert len(store.find_patients()) == 24


def test_two_namesakes_entered_at_once_are_still_asked_about(store):
    def add(_):
        try:
            return store.add_patient(NewPatient("Ana"), "op").id
        except DuplicatePatientError:
            return "asked"

    with ThreadPoolExecutor(4) as pool:
        added = list(pool.map(add, range(8)))

    assert sorted(map(str, added)) == ["1", *["asked"] * 7]


def test_a_database_that_another_program_keeps_locked_is_said(store, ana, data):
    store.close()
    with closing(sqlite3.connect(data / "records.sqlite3", isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        with RecordStore(data, wait_s=0.1) as again, pytest.raises(RecordsError, match="kept busy by another program"):
            again.add_patient(NewPatient("Bo"), "op")
