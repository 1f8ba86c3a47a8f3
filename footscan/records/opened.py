"""What the parts of the record store share: database, kept folders, the log, looking up rows."""

from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

from sqlalchemy.orm import Session

from footscan.errors import InputError
from footscan.records.data_folder import make_private
from footscan.records.database import Database
from footscan.records.spelling import clean_line, needed
from footscan.records.tables import AuditRow, FootRow, PatientRow, ResultRow, StoredRow, TakeRow, VisitRow
from footscan.records.vault import Staged, Vault

Numbered = TypeVar("Numbered", PatientRow, VisitRow, FootRow, TakeRow, ResultRow)
_WORDS = {PatientRow: "patient", VisitRow: "visit", FootRow: "foot", TakeRow: "take", ResultRow: "result"}
WAIT_S = 10.0


def utc_now() -> datetime:
    """This moment."""
    return datetime.now(UTC)


@dataclass(frozen=True)
class Storing:
    """One writing session that also gives folders their names; `new` are those that were not kept before."""

    session: Session
    vault: Vault
    now: datetime
    new: list[str] = field(default_factory=list)

    def keep(self, kind: str, staged: Staged) -> str:
        """Give a staged folder its name, and a row; the file is there before the row is.

        Returns:
            Its hash.

        Raises:
            StorageError: The disk cannot be written.
        """
        if self.vault.put(staged):
            self.new.append(staged.sha256)
        row = self.session.get(StoredRow, staged.sha256)
        if row is None:
            row = StoredRow(sha256=staged.sha256, kind=kind, size_bytes=staged.size_bytes, stored=self.now)
            self.session.add(row)
        row.discarded = False
        self.session.flush()
        return staged.sha256


class OpenRecords:
    """An open data folder; use as a context manager or call `close`.

    Args:
        data: The data folder; made if it does not exist, for its owner only.
        wait_s: How long to wait for another writer.
        now: The clock, with a time zone.

    Raises:
        RecordsError: The database is of another program, of a newer footscan, damaged, or kept busy.
        StorageError: The folder cannot be made or written.
    """

    def __init__(self, data: Path, wait_s: float = WAIT_S, now: Callable[[], datetime] = utc_now) -> None:
        make_private(data)
        self.data = data
        self._now = now
        self._vault = Vault(data)
        self._database = Database(data, wait_s)

    def close(self) -> None:
        """Give the database back; safe to call twice."""
        self._database.close()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @contextmanager
    def _storing(self) -> Generator[Storing]:
        """A writing session that keeps folders; what it kept is taken back when something fails before the commit."""
        with self._database.writing() as session:
            storing = Storing(session, self._vault, self._now())
            try:
                yield storing
            except BaseException:
                session.rollback()
                for sha256 in storing.new:
                    self._vault.remove(sha256)
                raise

    def _log(
        self,
        session: Session,
        by: str,
        action: str,
        *,
        patient_id: int | None = None,
        subject: str = "",
        reason: str = "",
        detail: Mapping[str, Any] | None = None,
    ) -> None:
        """Add a line to the log, in the transaction of what it speaks of."""
        line = AuditRow(
            at=self._now(),
            by=needed(by, "the name of who does this"),
            action=action,
            patient_id=patient_id,
            subject=subject,
            reason=clean_line(reason, "the reason"),
            detail=dict(detail or {}),
        )
        session.add(line)


def find_row(session: Session, table: type[Numbered], number: int) -> Numbered:
    """A row by its number.

    Raises:
        InputError: There is none.
    """
    row = session.get(table, number) if 0 < number < 2**63 else None
    if row is None:
        raise InputError(
            f"there is no {_WORDS[table]} {number}; take a number from `footscan patients list` or `show`."
        )
    return row


def patient_of_take(session: Session, take: TakeRow) -> int:
    """The number of the patient a take belongs to."""
    foot = find_row(session, FootRow, take.foot_id)
    return find_row(session, VisitRow, foot.visit_id).patient_id
