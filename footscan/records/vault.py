"""Folders kept by content hash: staged beside, synced, renamed. What has a name here is whole.

```
files/ab/abcdef.../    a kept folder; its files are read-only
stage/<kind>-<random>/ being written by a living process (locked), or left by a killed one
```
"""

import os
import shutil
import uuid
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from footscan.errors import InputError, StorageError
from footscan.records.tree_hash import files_of, hash_of_folder, size_of_folder, sync, sync_folder
from footscan.records.writer_lock import try_lock

DISCARD = "discard"


@dataclass(frozen=True)
class Staged:
    """A folder whose content is on the disk and hashed, not yet under its name."""

    folder: Path
    sha256: str
    size_bytes: int


class Vault:
    """The kept folders of one data folder."""

    def __init__(self, data: Path) -> None:
        self._files = data / "files"
        self._stage = data / "stage"

    @contextmanager
    def workspace(self, kind: str = "work") -> Generator[Path]:
        """An empty folder on the same disk, locked while in use and gone afterwards.

        Raises:
            StorageError: The disk is full or cannot be written.
        """
        place = self._stage / f"{kind}-{uuid.uuid4().hex}"
        lock = -1
        try:
            _private(self._stage, place)
            lock = os.open(place, os.O_RDONLY | os.O_CLOEXEC)
            try_lock(lock)
            yield place
        except OSError as err:
            raise StorageError(
                f"{place} could not be written ({err.strerror}); nothing was stored. Free space."
            ) from err
        finally:
            shutil.rmtree(place, ignore_errors=True)
            if lock >= 0:
                os.close(lock)

    @contextmanager
    def staged(self, source: Path, *, link: bool) -> Generator[Staged]:
        """A copy of a folder, synced and hashed, ready to be put under its name.

        Args:
            source: Left as it is.
            link: Share the files' content with the source (hard links) where the disk allows it: for sources that
                will be given up. A copy otherwise.

        Raises:
            InputError: The source is no folder of plain files.
            StorageError: The disk is full or cannot be written.
        """
        names = {path: path.relative_to(source) for path in files_of(source)}
        with self._staged(names, link=link) as staged:
            yield staged

    @contextmanager
    def staged_file(self, source: Path, name: str) -> Generator[Staged]:
        """A copy of one file as a folder of its own, as `staged`.

        Raises:
            InputError: There is no such file.
            StorageError: The disk is full or cannot be written.
        """
        if not source.is_file():
            raise InputError(f"{source} is no file; give the path of an existing {name}.")
        with self._staged({source: Path(name)}, link=False) as staged:
            yield staged

    @contextmanager
    def _staged(self, names: dict[Path, Path], *, link: bool) -> Generator[Staged]:
        with self.workspace("stage") as place:
            inside = place / "content"
            for path, name in names.items():
                _bring(path, inside / name, link=link)
            sync_folder(inside)
            yield Staged(inside, hash_of_folder(inside), size_of_folder(inside))

    def put(self, staged: Staged) -> bool:
        """Give a staged folder its name; False when the same content is already kept.

        Raises:
            StorageError: The disk cannot be written.
        """
        place = self.path(staged.sha256)
        if place.is_dir():
            return False
        try:
            _private(self._files, place.parent)
            staged.folder.rename(place)
            for folder in (place.parent, self._files, self._files.parent):
                sync(folder)
        except OSError as err:
            raise StorageError(f"{place} could not be written ({err.strerror}); nothing was stored.") from err
        return True

    def path(self, sha256: str) -> Path:
        """Where the content of a hash lies."""
        return self._files / sha256[:2] / sha256

    def remove(self, sha256: str) -> None:
        """Remove a kept folder; safe to repeat after a kill.

        Raises:
            StorageError: It cannot be removed.
        """
        self.discard(self.path(sha256))

    def discard(self, place: Path) -> None:
        """Remove a folder or file of this disk so that a kill never leaves half of it under its name.

        Raises:
            StorageError: It cannot be removed.
        """
        if place.exists():
            with self.workspace(DISCARD) as doomed:
                place.rename(doomed / "content")
                sync(place.parent)

    def names(self) -> list[str]:
        """The hashes of everything kept, in order."""
        return sorted(path.name for path in self._files.glob("??/*") if path.is_dir())

    def dead_stages(self) -> list[Path]:
        """Folders in `stage` that no living process works in, in name order."""
        return [path for path in sorted(self._stage.glob("*-*")) if path.is_dir() and not _in_use(path)]

    def finish_discards(self) -> None:
        """Remove what a killed program was removing on a person's word."""
        for path in self.dead_stages():
            if path.name.startswith(DISCARD):
                shutil.rmtree(path, ignore_errors=True)


def _private(*folders: Path) -> None:
    for folder in folders:
        folder.mkdir(exist_ok=True, mode=0o700)


def _bring(source: Path, target: Path, *, link: bool) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    if link:
        try:
            os.link(source, target)
        except OSError:  # another disk, or one without hard links: a copy is as good
            shutil.copyfile(source, target)
    else:
        shutil.copyfile(source, target)
    target.chmod(0o400)


def _in_use(folder: Path) -> bool:
    try:
        file = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    except FileNotFoundError:
        return False
    try:
        return not try_lock(file)
    finally:
        os.close(file)
