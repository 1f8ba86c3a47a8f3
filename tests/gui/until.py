"""Waiting for what another thread does."""

import time
from collections.abc import Callable


def until(holds: Callable[[], bool], at_most_s: float = 90.0) -> None:
    gives_up_s = time.monotonic() + at_most_s
    while not holds():
        assert time.monotonic() < gives_up_s, "it did not happen in time"
        time.sleep(0.05)
