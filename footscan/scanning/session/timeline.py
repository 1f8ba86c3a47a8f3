"""What was the case when: values noted with their moments by one thread and asked about by others."""

import threading
from typing import Generic, TypeVar

Value = TypeVar("Value")
_KEPT = 20000


class Timeline(Generic[Value]):
    """A value over time; notes come in order of time."""

    def __init__(self, first: Value) -> None:
        self._lock = threading.Lock()
        self._notes: list[tuple[float, Value]] = [(float("-inf"), first)]

    def note(self, time_s: float, value: Value) -> None:
        """From this moment on it is `value`."""
        with self._lock:
            self._notes.append((time_s, value))
            if len(self._notes) > _KEPT:
                del self._notes[: _KEPT // 2]

    def at(self, time_s: float) -> Value:
        """The value at a moment."""
        return self.during(time_s, time_s)[0]

    def during(self, begin_s: float, end_s: float) -> list[Value]:
        """Every value it had within a span, in order."""
        with self._lock:
            values: list[Value] = []
            for time_s, value in reversed(self._notes):
                if time_s <= end_s:
                    values.append(value)
                if time_s <= begin_s:
                    break
            return values[::-1] or [self._notes[0][1]]
