"""What lies in the data folder: leftovers of killed programs, and whether everything kept is whole."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from sqlalchemy import select

from footscan.errors import InputError
from footscan.records.opened import OpenRecords
from footscan.records.spelling import needed
from footscan.records.tables import StoredRow
from footscan.records.tree_hash import hash_of_folder, size_of_folder


@dataclass(frozen=True)
class Leftover:
    """What a killed program left behind: `staged` was being copied, `unnamed` is whole but belongs to no take.

    The source of either was not given up, so nothing is lost with it.
    """

    name: str
    kind: Literal["staged", "unnamed"]
    folder: Path
    size_bytes: int


class KeptFiles(OpenRecords):
    """Files of the data folder."""

    @contextmanager
    def workspace(self) -> Generator[Path]:
        """A folder on the disk of the records for results in the making; gone afterwards.

        Raises:
            StorageError: The disk is full or cannot be written.
        """
        with self._vault.workspace() as place:
            yield place

    def find_leftovers(self) -> list[Leftover]:
        """What killed programs left; waits for a writer, because what is being stored is no leftover."""
        with self._database.lock.held(), self._database.reading() as session:
            known = set(session.scalars(select(StoredRow.sha256)))
            found = [Leftover(path.name, "staged", path, size_of_folder(path)) for path in self._vault.dead_stages()]
            orphans = [self._vault.path(sha256) for sha256 in self._vault.names() if sha256 not in known]
            return found + [Leftover(path.name, "unnamed", path, size_of_folder(path)) for path in orphans]

    def remove_leftover(self, name: str, reason: str, by: str) -> None:
        """Remove a leftover for good.

        Raises:
            InputError: There is no such leftover, or no reason.
        """
        reason = needed(reason, "the reason")
        found = next((leftover for leftover in self.find_leftovers() if leftover.name == name), None)
        if found is None:
            raise InputError(f"there is no leftover {name}; `footscan patients leftovers` lists them.")
        with self._database.writing() as session:
            if session.get(StoredRow, name) is None:  # it may have been filed while the person decided
                self._vault.discard(found.folder)
                self._log(session, by, "leftover removed", subject=name, reason=reason)

    def is_kept(self, sha256: str) -> bool:
        """Whether a folder of that content is kept."""
        with self._database.reading() as session:
            row = session.get(StoredRow, sha256)
            return row is not None and not row.discarded

    def check_records(self) -> list[str]:
        """Check the database and read every kept file again; one sentence per damage, empty when all is whole."""
        with self._database.reading() as session:
            hashes = list(session.scalars(select(StoredRow.sha256).where(StoredRow.discarded.is_(False))))
        return self._database.check() + [trouble for sha256 in hashes if (trouble := self._trouble(sha256))]

    def _trouble(self, sha256: str) -> str:
        place = self._vault.path(sha256)
        if not place.is_dir():
            return f"{place} is missing; put it back from a backup."
        try:
            return "" if hash_of_folder(place) == sha256 else f"{place} was changed; put it back from a backup."
        except InputError as err:
            return str(err)
