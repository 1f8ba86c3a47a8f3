"""The watchdog inside the module: what drops the outputs when this computer says nothing any more."""

import math
import time
from typing import Protocol

from footscan.devices.adam_line import AdamLine
from footscan.errors import OutputsLostError

_FEED_SHARE = 4.0
"""Fed when a quarter of the time-out has passed since the last word."""
_KINDS = {"S": "silence", "P": "power-on"}


_ARMINGS = 3


def arm_surely(watchdog: "ModuleWatchdog", timeout_s: float, safe_bits: int) -> None:
    """Arm, and again if it has tripped meanwhile: a busy computer may be silent for longer than `timeout_s`.

    Raises:
        OutputsLostError: The module does not confirm it, or its trip cannot be cleared.
    """
    for _ in range(_ARMINGS):
        watchdog.clear()
        watchdog.arm(timeout_s, safe_bits)
        if not watchdog.tripped():
            return
    raise _not_armed("still says that its watchdog has tripped")


class ModuleWatchdog(Protocol):
    """Of one dialect."""

    def clear(self) -> None:
        """Forget an earlier trip, as far as outputs could not be switched otherwise."""
        ...

    def arm(self, timeout_s: float, safe_bits: int) -> None:
        """Let the outputs become `safe_bits` after `timeout_s` of silence; clears a trip. They are safe now.

        Raises:
            OutputsLostError: The module does not confirm it.
        """
        ...

    def feed(self) -> None:
        """This computer is alive."""
        ...

    def tripped(self) -> bool:
        """It has switched the outputs off."""
        ...

    def disarm(self) -> None:
        """No longer needed: everything is off and the program ends."""
        ...


class AdamWatchdog:
    """ADAM's safety value: any command to the module counts as a sign of life."""

    def __init__(self, line: AdamLine) -> None:
        self._line, self._timeout_s = line, math.inf

    def clear(self) -> None:
        """Writing the safety value does it."""

    def arm(self, timeout_s: float, safe_bits: int) -> None:
        """`$AAX0TTTTDD`, in tenths of a second, read back by `$AAX1`."""
        tenths = _tenths(timeout_s, 0xFFFF)
        self._line.ask("$", f"X0{tenths:04X}{safe_bits:02X}", ">")
        shown = self._line.ask("$", "X1", r"!([0-9A-F]{4})([0-9A-F]{2})")
        if (int(shown[1], 16), int(shown[2], 16)) != (tenths, safe_bits):
            raise _not_armed(f"shows {shown[0]!r} as its safety value")
        self._timeout_s = tenths / 10

    def feed(self) -> None:
        """Say something, unless something has just been said."""
        if time.monotonic() - self._line.last_exchange_s > self._timeout_s / _FEED_SHARE:
            self._line.ask("$", "6", r"!([0-9A-F]{2})([0-9A-F]{2})00")

    def tripped(self) -> bool:
        """`$AAX2`."""
        return self._line.ask("$", "X2", r"!(00|01)")[1] == "01"

    def disarm(self) -> None:
        """Left as it is: it drops outputs that are off already, and the manual names no way to switch it off."""


class DconWatchdog:
    """The host watchdog of ICP DAS: fed by `~**` alone; a trip is latched through power-off until it is cleared."""

    def __init__(self, line: AdamLine) -> None:
        self._line, self._timeout_s, self._fed_s = line, math.inf, -math.inf

    def clear(self) -> None:
        """Switch it off and clear the trip, `~AA3000` and `~AA1`: until then output commands are ignored."""
        self._line.ask("~", "3000", "!AA")
        self._line.ask("~", "1", "!AA")

    def arm(self, timeout_s: float, safe_bits: int) -> None:
        """`~AA5S`, `~AA5P` keep what is switched now for silence and power-on, `~AA3EVV` enables."""
        tenths = _tenths(timeout_s, 0xFF)
        for kind in _KINDS:
            self._keep_safe_value(kind, safe_bits)
        self._line.ask("~", f"31{tenths:02X}", "!AA")
        shown = self._line.ask("~", "2", r"!AA[01]?([0-9A-F]{2})")
        if int(shown[1], 16) != tenths:
            raise _not_armed(f"shows {shown[0]!r} as its time-out")
        self._timeout_s = tenths / 10
        self.feed()

    def feed(self) -> None:
        """`~**`, which nobody answers."""
        now_s = time.monotonic()
        if now_s - self._fed_s > self._timeout_s / _FEED_SHARE:
            self._line.tell("~**")
            self._fed_s = now_s

    def tripped(self) -> bool:
        """`~AA0`, status bit 2."""
        return bool(int(self._line.ask("~", "0", r"!AA([0-9A-F]{2})")[1], 16) & 0x04)

    def disarm(self) -> None:
        """Switched off, so that it does not trip, and wear its memory, when the program has ended."""
        self._line.ask("~", "3000", "!AA")

    def _keep_safe_value(self, kind: str, safe_bits: int) -> None:
        """Write it only where it differs: it lies in a memory that wears."""
        if self._value(kind) != safe_bits:
            self._line.ask("~", f"5{kind}", "!AA")
            if self._value(kind) != safe_bits:
                raise _not_armed(
                    f"does not take {safe_bits:02X} as its value for {'silence' if kind == 'S' else 'power-on'}"
                )

    def _value(self, kind: str) -> int:
        return int(self._line.ask("~", f"4{kind}", r"!AA([0-9A-F]{2})00")[1], 16)


def _tenths(timeout_s: float, most: int) -> int:
    return min(max(math.ceil(round(timeout_s * 10, 6)), 1), most)


def _not_armed(what: str) -> OutputsLostError:
    return OutputsLostError(
        f"the output module {what}, so its watchdog cannot be relied on and nothing will be switched on; switch the "
        "module off and on, then arm again."
    )
