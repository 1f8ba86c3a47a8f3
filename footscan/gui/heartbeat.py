"""Whether somebody still looks: the controlling browser answers a question every half second, or the machine stops.

A closed page is noticed at once, but a frozen one keeps its connection for 45 s. So the browser is asked for a value of
its local storage, which only a page that still runs can answer; an answer keeps the machine's dead-man quiet for
`patience_s`.
"""

import threading
from collections.abc import Callable

import viser

from footscan.gui.station import Station

ASK_EVERY_S = 0.5
PATIENCE_S = 3.0
_KEY = "footscan-alive"


class Heartbeat(threading.Thread):
    """Asks until `finish`."""

    def __init__(
        self, station: Station, holder: Callable[[], viser.ClientHandle | None], patience_s: float = PATIENCE_S
    ) -> None:
        super().__init__(name="heartbeat", daemon=True)
        self._station, self._holder, self._patience_s = station, holder, patience_s
        self._finished = threading.Event()

    def run(self) -> None:
        """Ask, and tell the machine."""
        self._station.session.watch(self._patience_s)
        while not self._finished.wait(ASK_EVERY_S):
            client = self._holder()
            if client is None or not _answers(client, self._patience_s):
                continue
            self._station.session.watch(self._patience_s)

    def finish(self) -> None:
        """End after the current question."""
        self._finished.set()


def _answers(client: viser.ClientHandle, timeout_s: float) -> bool:
    try:
        client.local_storage.get_item(_KEY, timeout=timeout_s)
    except TimeoutError:
        return False
    except RuntimeError as err:
        return "disconnected" not in str(err)  # a browser that forbids storage has answered all the same
    return True
