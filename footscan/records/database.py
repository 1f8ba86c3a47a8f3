"""The SQLite file of the records: opened, recognised, migrated; its troubles said in words."""

import os
import sqlite3
from collections.abc import Generator
from contextlib import closing, contextmanager
from pathlib import Path

from sqlalchemy import URL, Connection, Engine, create_engine, event
from sqlalchemy.exc import DatabaseError, OperationalError
from sqlalchemy.orm import Session

from footscan.errors import RecordsError, StorageError
from footscan.records.migrate import KNOWN, bring_up_to_date
from footscan.records.tables import APPLICATION_ID, SCHEMA
from footscan.records.tree_hash import sync
from footscan.records.writer_lock import WriterLock

FILE_NAME = "records.sqlite3"
_WRITES = "footscan_writes"
_TROUBLES = {
    "locked": "is kept busy by another program; close what has it open, then repeat",
    "disk is full": "cannot grow, the disk is full; free space, then repeat. Nothing was stored",
    "readonly": "cannot be written; give your user the right to write to the data folder",
    "unable to open": "cannot be opened; look at the permissions of the data folder",
    "disk I/O error": "cannot be read or written, the disk fails; check the disk, then repeat",
    "malformed": "is damaged; put back a backup of the data folder, or the newest file of its folder backups",
    "not a database": "is damaged; put back a backup of the data folder, or the newest file of its folder backups",
}
_OF_THE_DISK = ("disk is full", "readonly", "unable to open", "disk I/O error")


class Database:
    """The open records of one data folder; sessions read at any time and write one at a time.

    Raises:
        RecordsError: The file is of another program, of a newer footscan, damaged, or kept busy.
        StorageError: The data folder cannot be written.
    """

    def __init__(self, data: Path, wait_s: float) -> None:
        self.path = data / FILE_NAME
        self.lock = WriterLock(data / "writer.lock", wait_s)
        with self.lock.held(), _in_words(self.path):
            version = recognise(self.path)
            self._engine = _build_engine(self.path, wait_s)
            if version != SCHEMA:
                self._migrate(version)
        self._writer = self._engine.execution_options(**{_WRITES: True})

    def _migrate(self, version: str | None) -> None:
        try:
            if version is None:
                self._start()
            else:
                back_up(self.path, version)
            with self._engine.execution_options(**{_WRITES: True}).begin() as connection:
                bring_up_to_date(connection)
        except BaseException:
            self.close()
            raise

    def _start(self) -> None:
        """Make the file, its owner's alone, and switch it to write-ahead logging (kept in its header)."""
        os.close(os.open(self.path, os.O_RDWR | os.O_CREAT, 0o600))
        with closing(sqlite3.connect(self.path)) as raw:
            mode = raw.execute("PRAGMA journal_mode = WAL").fetchone()[0]
        sync(self.path.parent)
        if mode != "wal":
            raise RecordsError(f"{self.path} lies on a disk that cannot keep records; choose a folder on a local disk.")

    @contextmanager
    def reading(self) -> Generator[Session]:
        """A session that sees one unchanging state."""
        with _in_words(self.path), Session(self._engine) as session, session.begin():
            yield session

    @contextmanager
    def writing(self) -> Generator[Session]:
        """The one writing session; what was done in it is on the disk when this returns without an error."""
        with self.lock.held(), _in_words(self.path), Session(self._writer) as session, session.begin():
            yield session

    def check(self) -> list[str]:
        """What SQLite finds wrong with the file and with references between rows; empty when nothing is."""
        with self.reading() as session:
            found = [str(line) for (line,) in session.connection().exec_driver_sql("PRAGMA integrity_check")]
            torn = session.connection().exec_driver_sql("PRAGMA foreign_key_check").all()
        damage = [] if found == ["ok"] else [f"{self.path}: {line}" for line in found]
        return damage + [f"{self.path}: row {row[1]} of {row[0]} refers to nothing in {row[2]}" for row in torn]

    def forget_journal(self) -> None:
        """Empty the write-ahead log, so that deleted content is nowhere in the folder of the records."""
        with _in_words(self.path), closing(self._engine.raw_connection()) as raw, closing(raw.cursor()) as cursor:
            cursor.execute("PRAGMA wal_checkpoint(TRUNCATE)")

    def close(self) -> None:
        """Give the file back; safe to call twice."""
        self._engine.dispose()


def _build_engine(path: Path, wait_s: float) -> Engine:
    url = URL.create("sqlite", database=str(path))
    engine = create_engine(url, hide_parameters=True, connect_args={"timeout": wait_s})
    event.listen(engine, "connect", _prepare)
    event.listen(engine, "begin", _begin)
    return engine


def _prepare(raw: sqlite3.Connection, _record: object) -> None:
    raw.isolation_level = None  # transactions begin where `_begin` says, also around changes of tables
    for pragma in ("foreign_keys = ON", "synchronous = FULL", "secure_delete = ON", "trusted_schema = OFF"):
        raw.execute(f"PRAGMA {pragma}")


def _begin(connection: Connection) -> None:
    writes = connection.get_execution_options().get(_WRITES, False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def recognise(path: Path) -> str | None:
    """The version of the records in a file; None when there are none yet.

    Raises:
        RecordsError: The file is no SQLite file, of another program, or of a version this program does not know.
    """
    if not path.exists() or path.stat().st_size == 0:
        return None
    with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as raw:
        try:
            mark = raw.execute("PRAGMA application_id").fetchone()[0]
            tables = {name for (name,) in raw.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
        except sqlite3.DatabaseError as err:
            if "not a database" not in str(err):
                raise
            raise RecordsError(_foreign(path, "is no SQLite file")) from err
        if mark == 0 and not tables:
            return None  # a program was killed while it made the file
        if mark != APPLICATION_ID or "alembic_version" not in tables:
            raise RecordsError(_foreign(path, "is a database of another program"))
        versions = [str(version) for (version,) in raw.execute("SELECT version_num FROM alembic_version")]
    if len(versions) != 1 or versions[0] not in KNOWN:
        raise RecordsError(
            f"{path} was written by a newer footscan (records of version {', '.join(versions) or 'unknown'}, this one "
            f"knows {SCHEMA}); update footscan. Nothing was changed."
        )
    return versions[0]


def _foreign(path: Path, what: str) -> str:
    return f"{path} {what}; move it away or choose another data folder. Nothing was changed."


def back_up(path: Path, version: str) -> Path:
    """A copy of the records before they are migrated, as `backups/records-<version>.sqlite3`."""
    target = path.parent / "backups" / f"records-{version}.sqlite3"
    target.parent.mkdir(mode=0o700, exist_ok=True)
    beside = target.with_suffix(".part")
    beside.unlink(missing_ok=True)
    with closing(sqlite3.connect(path)) as source, closing(sqlite3.connect(beside)) as copy:
        source.backup(copy)
    sync(beside)
    beside.chmod(0o600)
    beside.replace(target)
    sync(target.parent)
    return target


@contextmanager
def _in_words(path: Path) -> Generator[None]:
    """Say the troubles of SQLite in words; constraint violations are faults of the program and stay as they are."""
    try:
        yield
    except (OperationalError, DatabaseError, sqlite3.DatabaseError) as err:
        said = str(getattr(err, "orig", err))
        trouble = next((key for key in _TROUBLES if key in said), None)
        if trouble is None:
            raise
        kind = StorageError if trouble in _OF_THE_DISK else RecordsError
        raise kind(f"{path} {_TROUBLES[trouble]}.") from err
    except OSError as err:
        raise StorageError(
            f"{path} could not be written ({err.strerror}); free space or choose another data folder."
        ) from err
