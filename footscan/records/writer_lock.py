"""One writer at a time in a data folder, whatever the process; a killed one lets go by itself."""

import contextlib
import fcntl
import os
import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from footscan.errors import RecordsError, StorageError

_POLL_S = 0.02


class WriterLock:
    """The lock file of a data folder; the system drops the lock when its process ends, even by a kill."""

    def __init__(self, path: Path, wait_s: float) -> None:
        self._path = path
        self._wait_s = wait_s

    @contextmanager
    def held(self) -> Generator[None]:
        """Be the one writer.

        Raises:
            RecordsError: Another process kept writing for longer than the waiting time.
            StorageError: The lock file cannot be made.
        """
        file = self._open()
        try:
            self._wait_for(file)
            os.ftruncate(file, 0)
            os.pwrite(file, str(os.getpid()).encode(), 0)
            yield
        finally:
            os.close(file)

    @contextmanager
    def held_if_free(self) -> Generator[bool]:
        """Be the one writer if nobody else is; says which."""
        file = self._open()
        try:
            yield try_lock(file)
        finally:
            os.close(file)

    def _open(self) -> int:
        try:
            return os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        except OSError as err:
            raise StorageError(
                f"{self._path} cannot be written ({err.strerror}); choose a data folder that you may write to."
            ) from err

    def _wait_for(self, file: int) -> None:
        end = time.monotonic() + self._wait_s
        while not try_lock(file):
            if time.monotonic() > end:
                raise RecordsError(
                    f"another footscan (process {self._writer(file)}) has been writing to {self._path.parent} for more "
                    f"than {self._wait_s:g} s; let it finish or close it, then repeat."
                )
            time.sleep(_POLL_S)

    @staticmethod
    def _writer(file: int) -> str:
        return os.pread(file, 32, 0).decode("ascii", "replace") or "unknown"


def try_lock(file: int) -> bool:
    """Lock an open file or folder; False when somebody else holds it."""
    with contextlib.suppress(BlockingIOError):
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    return False
