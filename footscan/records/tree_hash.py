"""The content hash of a folder, and syncing it to the disk."""

import hashlib
import os
from pathlib import Path

from footscan.errors import InputError

_FORMAT = "footscan-folder/1\n"


def files_of(folder: Path) -> list[Path]:
    """Every file below a folder, in the order of their names relative to it.

    Raises:
        InputError: The folder is missing or empty, or holds links or devices, which cannot be kept.
    """
    if not folder.is_dir() or folder.is_symlink():
        raise InputError(f"{folder} is no folder; give the folder of a scan.")
    found: list[Path] = []
    for path in folder.rglob("*"):
        if path.is_symlink() or not (path.is_file() or path.is_dir()):
            raise InputError(f"{path} is no plain file; only files and folders can be kept, remove it.")
        if path.is_file():
            found.append(path)
    if not found:
        raise InputError(f"{folder} holds no files; give the folder of a scan.")
    return sorted(found, key=lambda path: path.relative_to(folder).as_posix())


def hash_of_folder(folder: Path) -> str:
    """sha256 over the sha256 and the name of every file, in name order.

    Raises:
        InputError: As `files_of`.
    """
    whole = hashlib.sha256(_FORMAT.encode())
    for path in files_of(folder):
        name = os.fsencode(path.relative_to(folder).as_posix())
        whole.update(_digest(path).encode() + b"  " + name + b"\0")
    return whole.hexdigest()


def size_of_folder(folder: Path) -> int:
    """Bytes in all files below a folder."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file() and not path.is_symlink())


def _digest(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def sync_folder(folder: Path) -> None:
    """Bring every file and every folder below to the disk, files first."""
    folders = [folder]
    for path in folder.rglob("*"):
        if path.is_dir():
            folders.append(path)
        else:
            sync(path)
    for path in reversed(folders):
        sync(path)


def sync(path: Path) -> None:
    """Bring one file, or the names in one folder, to the disk."""
    file = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(file)
    finally:
        os.close(file)
