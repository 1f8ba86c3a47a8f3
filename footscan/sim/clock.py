"""A clock that jumps to the next moment anybody waits for: simulated time, as fast as this computer can."""

import threading
import time
from collections.abc import Callable


class VirtualClock:
    """Simulated seconds. They stand still while any thread that has joined works, and jump when all of them wait.

    With a `pace` they pass at most so many times as fast as the wall clock: a person can follow, and a computer that is
    too busy makes the simulated machine slower instead of spoiling what it does.
    """

    def __init__(self, start_s: float = 1000.0, pace: float | None = None) -> None:
        self._now_s = start_s
        self._pace = pace
        self._free_s = time.monotonic()
        self._changed = threading.Condition()
        self._joined = 0
        self._until: dict[int, float] = {}

    def now_s(self) -> float:
        """Simulated seconds."""
        return self._now_s

    def wait(self, until_s: float, ready: Callable[[], bool] = lambda: False) -> bool:
        """Wait until `ready()` or the moment `until_s`; says whether `ready()` held. Only threads that have joined."""
        me = threading.get_ident()
        with self._changed:
            while not ready():
                if self._now_s >= until_s:
                    return False
                self._until[me] = until_s
                if len(self._until) >= self._joined:
                    self._jump()
                else:
                    self._changed.wait()
            self._until.pop(me, None)
            return True

    def notify(self) -> None:
        """Let all who wait look again before time goes on."""
        with self._changed:
            self._until.clear()
            self._changed.notify_all()

    def join(self) -> None:
        """One more thread must wait before time goes on; called before it starts."""
        with self._changed:
            self._joined += 1

    def leave(self) -> None:
        """One less."""
        with self._changed:
            self._joined -= 1
            if self._until and len(self._until) >= self._joined:
                self._jump()

    def _jump(self) -> None:
        now_s = max(self._now_s, min(self._until.values()))
        if self._pace is not None:
            self._keep_pace((now_s - self._now_s) / self._pace)
        self._now_s = now_s
        self._until.clear()
        self._changed.notify_all()

    def _keep_pace(self, step_s: float) -> None:
        """Sleep until the wall clock has made the step too; time lost by work is not made up for."""
        self._free_s = max(self._free_s + step_s, time.monotonic())
        time.sleep(max(self._free_s - time.monotonic(), 0.0))
