"""The record store: one object for all that is kept of patients."""

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Self

from footscan.records.corrections import CorrectionRecords
from footscan.records.export import ExportRecords
from footscan.records.kept import KeptFiles
from footscan.records.opened import WAIT_S, utc_now


class RecordStore(CorrectionRecords, ExportRecords, KeptFiles):
    """The records of one data folder, in small methods grouped by file.

    | file | what |
    |---|---|
    | `patients` | add, edit, find, delete |
    | `visits` | visits, and what is declared of each foot |
    | `takes` | file a scan, judge it, mark it in use |
    | `results` | processings of a take, measurements, landmarks by hand |
    | `corrections` | wrong patient, side, load or surface |
    | `kept` | leftovers of killed programs, checking everything kept |
    | `export`, `audit` | everything of one patient; the log |

    Any thread may call any method; writers wait for one another, also across processes. Use it as a context manager.

    Raises:
        RecordsError: The database is of another program, of a newer footscan, damaged, or kept busy.
        StorageError: The data folder cannot be made or written.
    """

    def __init__(self, data: Path, wait_s: float = WAIT_S, now: Callable[[], datetime] = utc_now) -> None:
        super().__init__(data, wait_s, now)
        try:
            self._finish_interrupted()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        """The store; closed at the end of the block."""
        return self

    def _finish_interrupted(self) -> None:
        """Bring removals that a person ordered, and moves that were acknowledged, to the end a kill prevented."""
        with self._database.lock.held_if_free() as free:
            if free:
                self._finish_moves()
        if self._discards_waiting():
            self._finish_discards()
