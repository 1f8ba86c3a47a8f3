"""Time of the machine: every stamp and every wait goes through one clock, so that a simulated one can run ahead."""

import threading
import time
from collections.abc import Callable
from typing import Protocol


class Clock(Protocol):
    """Seconds that never go back, and waiting for something or for a moment.

    Threads that wait on the clock say so before they start (`join`) and when they end (`leave`): a simulated clock
    moves on only while all of them wait.
    """

    def now_s(self) -> float:
        """Seconds on the monotonic clock."""
        ...

    def wait(self, until_s: float, ready: Callable[[], bool] = lambda: False) -> bool:
        """Wait until `ready()` or the moment `until_s`; says whether `ready()` held.

        `ready` is called with the clock's lock held: it only looks.
        """
        ...

    def notify(self) -> None:
        """Something a thread waits for may have happened: look again."""
        ...

    def join(self) -> None:
        """One more thread waits on this clock."""
        ...

    def leave(self) -> None:
        """One less."""
        ...


class MonotonicClock:
    """The computer's own monotonic clock (CLOCK_MONOTONIC on Linux: the same for all processes)."""

    def __init__(self) -> None:
        self._changed = threading.Condition()

    def now_s(self) -> float:
        """Seconds since some moment before the computer started."""
        return time.monotonic()

    def wait(self, until_s: float, ready: Callable[[], bool] = lambda: False) -> bool:
        """Wait until `ready()` or the moment `until_s`; says whether `ready()` held."""
        with self._changed:
            return self._changed.wait_for(ready, max(until_s - time.monotonic(), 0.0))

    def notify(self) -> None:
        """Let all who wait look again."""
        with self._changed:
            self._changed.notify_all()

    def join(self) -> None:
        """Real time needs no count of threads."""

    def leave(self) -> None:
        """Real time needs no count of threads."""
