"""A thread that works through a bounded queue: whoever fills it never waits, and it is always drained at the end."""

import logging
import threading
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

from footscan.devices.clock import Clock
from footscan.errors import FootscanError, ThreadFailedError

Item = TypeVar("Item")
_LOOK_S = 1.0
_LOG = logging.getLogger(__name__)


def failure_of_thread(what: str, err: Exception) -> FootscanError:
    """What a person is told when a thread has ended; what a programmer needs goes to the log."""
    if isinstance(err, FootscanError):
        return err
    _LOG.error("the thread that %s ended", what, exc_info=err)
    return ThreadFailedError(
        f"the thread that {what} ended unexpectedly ({type(err).__name__}); everything was switched off. "
        "Start the program again and report this."
    )


class QueueThread(threading.Thread, Generic[Item]):
    """Does `work` on every item, in order, until `finish`, then on what is left.

    Attributes:
        failure: What went wrong, None while well; the items not worked on stay in the queue.
    """

    def __init__(self, what: str, clock: Clock, work: Callable[[Item], None], capacity: int) -> None:
        super().__init__(name=what, daemon=True)
        self.failure: FootscanError | None = None
        self._what, self._clock, self._work, self._capacity = what, clock, work, capacity
        self._queue: deque[Item] = deque()
        self._finished = False
        self._working = False
        clock.join()

    @property
    def idle(self) -> bool:
        """Nothing waits and nothing is worked on."""
        return not self._queue and not self._working

    @property
    def waiting(self) -> int:
        """Items in the queue."""
        return len(self._queue)

    def offer(self, item: Item, however_full: bool = False) -> bool:
        """Queue an item; False if the queue is full."""
        if len(self._queue) >= self._capacity and not however_full:
            return False
        self._queue.append(item)
        self._clock.notify()
        return True

    def finish(self) -> None:
        """End once the queue is empty."""
        self._finished = True
        self._clock.notify()

    def run(self) -> None:
        """Work until finished and drained."""
        try:
            while self._queue or not self._finished:
                if self._clock.wait(self._clock.now_s() + _LOOK_S, lambda: bool(self._queue) or self._finished):
                    self._work_off()
        except Exception as err:  # noqa: BLE001 - whatever ended the thread must stop the machine
            self.failure = failure_of_thread(self._what, err)
        finally:
            self._working = False
            self._clock.notify()
            self._clock.leave()

    def _work_off(self) -> None:
        while self._queue:
            self._working = True
            self._work(self._queue.popleft())
        self._working = False
        self._clock.notify()
