"""What became of something that was asked of the control thread."""

import threading

from footscan.errors import FootscanError


class Ticket:
    """What became of a posted command."""

    def __init__(self) -> None:
        self._done = threading.Event()
        self.error: FootscanError | None = None

    def settle(self, error: FootscanError | None = None) -> None:
        """It is over."""
        if not self._done.is_set():
            self.error = error
            self._done.set()

    @property
    def done(self) -> bool:
        """It is over, well or not."""
        return self._done.is_set()

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait until it is over; False if it took too long.

        Raises:
            FootscanError: It went wrong.
        """
        done = self._done.wait(timeout_s)
        if self.error is not None:
            raise self.error
        return done
