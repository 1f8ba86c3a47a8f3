"""The file of the records: what is recognised, what is refused, and how old ones come up to date."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import create_engine

from footscan.errors import RecordsError, StorageError
from footscan.records import NewPatient, RecordStore, database, migrate
from footscan.records.tables import SCHEMA, Row

FIRST_VERSION = Path(__file__).with_name("first_version.sql")
ADDED = """
from alembic import op
import sqlalchemy as sa
revision, down_revision = "0002", "0001"
def upgrade():
    op.add_column("patients", sa.Column("added", sa.String(), nullable=False, server_default="new"))
    {more}
"""


def run(path, *statements):
    with closing(sqlite3.connect(path)) as raw, raw:
        return [raw.execute(statement).fetchall() for statement in statements]


@pytest.fixture
def path(data):
    data.mkdir()
    return data / "records.sqlite3"


def test_the_newest_migration_is_the_version_of_the_tables():
    assert migrate.shipped_versions() == migrate.KNOWN
    assert migrate.KNOWN[-1] == SCHEMA


def test_the_migrations_make_exactly_the_tables_of_the_program(store, data):
    engine = create_engine(f"sqlite:///{data / 'records.sqlite3'}")
    with engine.connect() as connection:
        differences = compare_metadata(MigrationContext.configure(connection), Row.metadata)
    engine.dispose()

    assert differences == []


def test_records_of_the_first_version_open_with_all_they_hold(path, data):
    with closing(sqlite3.connect(path)) as raw:
        raw.executescript(FIRST_VERSION.read_text(encoding="utf-8"))
    with RecordStore(data) as store:
        (patient,) = store.find_patients("łódź")
        (visit,) = store.visits(patient.id)
        (take,) = store.takes(visit.id)

        assert (patient.name, str(patient.born), patient.number) == ("Ana Łódź", "1962-03-31", "A-7")
        assert store.feet(visit.id)[0].facts.missing == ("toe_5",)
        assert (take.in_use, take.verdict, take.said.load) == (True, "with_remark", "seated")
        assert take.result.measurements[1].interval == (231.0, 250.0)
        assert take.landmarks[0].xyz_world == (1.0, 2.0, 3.0)
        assert len(store.audit(patient.id)) == 8
        assert store.add_patient(NewPatient("Bo"), "op").id > patient.id


@pytest.fixture
def next_version(tmp_path, monkeypatch):
    """The program after one more migration; `more` is what else that one does."""

    def ship(more="pass"):
        folder = Path(shutil.copytree(migrate.MIGRATIONS, tmp_path / "migrations"))
        (folder / "versions/v0002_added.py").write_text(ADDED.format(more=more))
        monkeypatch.setattr(migrate.bring_up_to_date, "__defaults__", (folder,))
        monkeypatch.setattr(database, "KNOWN", ("0001", "0002"))
        monkeypatch.setattr(database, "SCHEMA", "0002")

    return ship


def test_an_older_file_is_backed_up_and_migrated_with_its_rows(data, next_version):
    with RecordStore(data) as store:
        store.add_patient(NewPatient("Ana"), "op")
    next_version()
    RecordStore(data).close()

    assert run(data / "records.sqlite3", "SELECT name, added FROM patients") == [[("Ana", "new")]]
    assert run(data / "backups/records-0001.sqlite3", "SELECT name FROM patients", "PRAGMA integrity_check") == [
        [("Ana",)],
        [("ok",)],
    ]


def test_a_migration_that_fails_changes_nothing(data, next_version):
    with RecordStore(data) as store:
        store.add_patient(NewPatient("Ana"), "op")
    next_version('op.execute("INSERT INTO nowhere VALUES (1)")')
    with pytest.raises(Exception, match="nowhere"):
        RecordStore(data)
    path = data / "records.sqlite3"

    assert run(path, "SELECT version_num FROM alembic_version") == [[("0001",)]]
    assert "added" not in [row[1] for row in run(path, "PRAGMA table_info(patients)")[0]]


def test_a_newer_file_is_left_alone(data):
    RecordStore(data).close()
    path = data / "records.sqlite3"
    run(path, "UPDATE alembic_version SET version_num = '0007'")
    before = path.read_bytes()
    with pytest.raises(RecordsError, match=r"newer footscan \(records of version 0007, this one knows 0001\)"):
        RecordStore(data)

    assert path.read_bytes() == before


@pytest.mark.parametrize("journal", ["delete", "wal"])
def test_a_database_of_another_program_is_left_alone(path, data, journal):
    run(
        path,
        f"PRAGMA journal_mode = {journal}",
        "CREATE TABLE patients (id INTEGER)",
        "INSERT INTO patients VALUES (1)",
    )
    before = path.read_bytes()
    with pytest.raises(RecordsError, match="is a database of another program; move it away"):
        RecordStore(data)

    assert path.read_bytes() == before


def test_a_file_that_is_no_database_is_left_alone(path, data):
    path.write_bytes(b"my shopping list" * 500)
    with pytest.raises(RecordsError, match="is no SQLite file"):
        RecordStore(data)

    assert path.read_bytes() == b"my shopping list" * 500


def test_a_damaged_file_is_said(data):
    with RecordStore(data) as store:
        for k in range(50):
            store.add_patient(NewPatient(f"Ana {k}"), "op")
    path = data / "records.sqlite3"
    content = bytearray(path.read_bytes())
    content[4096:40960] = b"\xff" * 36864
    path.write_bytes(content)
    with pytest.raises(RecordsError, match="is damaged; put back a backup"):
        RecordStore(data).find_patients()


@pytest.mark.parametrize("state", ["empty", "only a journal mode"])
def test_a_file_whose_making_was_cut_off_is_made_again(path, data, state):
    path.touch()
    if state != "empty":
        run(path, "PRAGMA journal_mode = wal")
    with RecordStore(data) as store:
        assert store.add_patient(NewPatient("Ana"), "op").id == 1


def test_a_folder_that_cannot_be_made_is_said(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(StorageError, match="choose another with --data"):
        RecordStore(tmp_path / "file" / "data")


def test_only_the_owner_can_read_the_records(store, data, ana, file_scan):
    take = file_scan(ana)
    places = [data, data / "records.sqlite3", data / "files", *store.recording_folder(take.id).rglob("*.png")]

    assert [oct(place.stat().st_mode & 0o077) for place in places] == ["0o0"] * len(places)


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE audit SET \"by\" = 'nobody'",
        "DELETE FROM audit",
        "DELETE FROM audit WHERE id = 1",
        "INSERT OR REPLACE INTO audit SELECT * FROM audit WHERE id = 1",
    ],
)
def test_the_log_can_only_be_added_to(store, data, ana, statement):
    before = store.audit()
    with pytest.raises(sqlite3.IntegrityError, match="only be added to"):
        run(data / "records.sqlite3", statement)

    assert store.audit() == before


def test_sqlite_keeps_what_it_acknowledged_and_refers_to_nothing_missing(store):
    with store._database.writing() as session:
        ask = session.connection().exec_driver_sql
        asked = [
            ask(f"PRAGMA {name}").scalar() for name in ("journal_mode", "foreign_keys", "synchronous", "secure_delete")
        ]

    assert asked == ["wal", 1, 2, 1]


def test_damage_to_files_is_named(store, ana, file_scan):
    take = file_scan(ana)
    folder = store.recording_folder(take.id)
    (folder / "frames/000001.png").chmod(0o600)
    (folder / "frames/000001.png").write_bytes(b"changed")
    shutil.rmtree(store.results_folder(take.result.id))

    assert {" ".join(line.split()[1:3]) for line in store.check_records()} == {"was changed;", "is missing;"}
