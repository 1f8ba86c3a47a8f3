"""A digital I/O module: outputs with a watchdog of its own that drops them, whatever becomes of the computer."""

from footscan.devices.values import ALL_OFF, Outputs


class IoModule:
    """The module's own state over time; a pure state machine that can live in another process than the driver.

    Attributes:
        tripped: The watchdog has dropped the outputs; cleared by `arm`.
        restarted: Power came back since `take_restart` was last asked.
    """

    def __init__(self) -> None:
        self.tripped = False
        self.restarted = True
        self._outputs = ALL_OFF
        self._timeout_s: float | None = None
        self._fed_s = 0.0

    @property
    def trips_at_s(self) -> float | None:
        """When the watchdog will drop the outputs unless it is fed."""
        return None if self._timeout_s is None or self.tripped else self._fed_s + self._timeout_s

    def outputs_at(self, time_s: float) -> Outputs:
        """What is switched at a moment, not before the last one asked about."""
        trips = self.trips_at_s
        if trips is not None and time_s >= trips:
            self.tripped = True
            self._outputs = ALL_OFF
        return self._outputs

    def set(self, outputs: Outputs, time_s: float) -> None:
        """Switch; a tripped module ignores it."""
        self.outputs_at(time_s)
        if not self.tripped:
            self._outputs = outputs
            self._fed_s = time_s

    def arm(self, timeout_s: float, time_s: float) -> None:
        """Set the watchdog; clears a trip."""
        self.outputs_at(time_s)
        self._timeout_s, self._fed_s, self.tripped = timeout_s, time_s, False

    def feed(self, time_s: float) -> None:
        """The computer is alive."""
        self.outputs_at(time_s)
        self._fed_s = time_s

    def lose_power(self) -> None:
        """Supply fails for a moment: outputs off, watchdog forgotten."""
        self._outputs, self._timeout_s, self.tripped, self.restarted = ALL_OFF, None, False, True

    def take_restart(self) -> bool:
        """Whether power was lost since this was last asked."""
        restarted, self.restarted = self.restarted, False
        return restarted
