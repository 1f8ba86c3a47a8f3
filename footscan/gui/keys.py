"""Who controls: one browser at a time, the others watch; a take-over is asked for, answered or waited out, logged."""

import threading
from collections.abc import Callable
from dataclasses import dataclass

ANSWER_S = 20.0
Log = Callable[[str], None]


@dataclass(frozen=True)
class Asking:
    """A take-over that waits for its answer."""

    client: int
    asked_s: float


class Keys:
    """The right to control. Any thread may call; `now_s` is any monotonic clock."""

    def __init__(self, log: Log, now_s: Callable[[], float]) -> None:
        self._log, self._now_s = log, now_s
        self._lock = threading.Lock()
        self._holder: int | None = None
        self._clients: list[int] = []
        self._asking: Asking | None = None

    @property
    def holder(self) -> int | None:
        """The client in control."""
        return self._holder

    @property
    def asking(self) -> Asking | None:
        """Who asks for control."""
        return self._asking

    def come(self, client: int) -> None:
        """A browser has connected; the first one controls."""
        with self._lock:
            self._clients.append(client)
            if self._holder is None:
                self._give(client, "came first")

    def go(self, client: int) -> None:
        """A browser has gone; who asked gets control, nobody else does without asking."""
        with self._lock:
            if client in self._clients:
                self._clients.remove(client)
            if self._asking is not None and self._asking.client == client:
                self._asking = None
            if self._holder == client:
                self._holder = None
                self._log(f"browser {client} that controlled has gone")
                if self._asking is not None:
                    self._give(self._asking.client, "had asked, the other one has gone")

    def ask(self, client: int) -> bool:
        """A watching browser asks; True when it controls at once because nobody did."""
        with self._lock:
            if self._holder is None:
                self._give(client, "asked, nobody controlled")
                return True
            if client != self._holder and client in self._clients:
                self._asking = Asking(client, self._now_s())
                self._log(f"browser {client} asks browser {self._holder} for control")
            return False

    def answer(self, client: int, give: bool) -> None:
        """The controlling browser answers."""
        with self._lock:
            if client != self._holder or self._asking is None:
                return
            if give:
                self._give(self._asking.client, "was given control")
            else:
                self._log(f"browser {client} keeps control")
                self._asking = None

    def wait_out(self, busy: bool) -> bool:
        """Give control to who has waited long enough, unless the machine is busy; True when it went over."""
        with self._lock:
            if self._asking is None or busy or self._now_s() - self._asking.asked_s < ANSWER_S:
                return False
            self._give(self._asking.client, "asked and got no answer")
            return True

    def _give(self, client: int, why: str) -> None:
        self._holder, self._asking = client, None
        self._log(f"browser {client} controls: {why}")
