"""The page's log: who controlled, what was refused, what the machine did; one line each, kept in the data folder."""

import threading
from collections import deque
from datetime import UTC, datetime
from pathlib import Path

from footscan.scanning.session.states import Snapshot, State

_SHOWN = 200
_LARGEST_BYTES = 2_000_000


class Logbook:
    """Lines are appended from any thread; the file starts anew beside an `.old` one when it has grown large."""

    def __init__(self, path: Path) -> None:
        self._path, self._lock = path, threading.Lock()
        self._lines: deque[str] = deque(maxlen=_SHOWN)
        self._state: tuple[State, str] | None = None
        self.count = 0

    def write(self, words: str) -> None:
        """One line, with the time. What cannot be written to the disk is still shown."""
        now, words = datetime.now(UTC).astimezone(), " ".join(words.split())
        with self._lock:
            self._lines.append(f"{now:%Y-%m-%d %H:%M:%S}  {words}")
            self.count += 1
            try:
                self._append(f"{now.isoformat(timespec='seconds')}  {words}")
            except OSError as err:
                self._lines.append(f"this log cannot be written to {self._path} ({err.strerror})")

    def note_state(self, snapshot: Snapshot) -> None:
        """A line when the machine's state has changed."""
        state = (snapshot.state, snapshot.message)
        if state != self._state:
            self._state = state
            self.write(f"machine: {snapshot.message or snapshot.state.value}")

    def latest(self, count: int) -> list[str]:
        """The last lines, the newest first."""
        with self._lock:
            return list(self._lines)[-count:][::-1]

    def _append(self, line: str) -> None:
        if self._path.is_file() and self._path.stat().st_size > _LARGEST_BYTES:
            self._path.replace(self._path.with_suffix(".old.log"))
        with self._path.open("a", encoding="utf-8") as stream:
            stream.write(line + "\n")
