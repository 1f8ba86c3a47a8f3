"""Emulated ADAM-4055/4150 and I-7050/7060 modules: the bytes of their manuals, their silences and their watchdogs."""

import math
import re
import threading
from collections.abc import Callable
from typing import Protocol

from footscan.config.io_models import TERMINALS, Dialect
from footscan.devices.adam_line import checksum, reply_text
from footscan.sim.emulators.pty_line import Spoken

BAUD_CODES = {1200: 3, 2400: 4, 4800: 5, 9600: 6, 19200: 7, 38400: 8, 57600: 9, 115200: 10}
_TURNAROUND_S = 0.001


class Panel(Protocol):
    """What is wired to the module's terminals."""

    def switch(self, bits: int, time_s: float) -> None:
        """The outputs have become this word."""
        ...

    def input_bits(self, time_s: float) -> int:
        """The input word."""
        ...


class AdamEmulator:
    """A state machine; a `PtyLine` gives it a port.

    Attributes:
        baud: As set in the module.
        mute: Neither hears nor speaks; its own watchdog runs on.
        garbles: Hears well and answers nonsense.
        powered: It has a supply.
        outputs: The output word.
    """

    def __init__(
        self,
        dialect: Dialect,
        panel: Panel,
        baud: int = 115200,
        address: int = 1,
        with_checksum: bool = False,
        obeys_tripped: bool = True,
    ) -> None:
        """Power it on.

        Args:
            dialect: Which module.
            panel: What it switches and reads.
            baud: As set in the module.
            address: As set in the module.
            with_checksum: As set in the module.
            obeys_tripped: An ADAM that has tripped takes output commands at once (the manual does not say).
        """
        self.baud, self.powered, self.outputs = baud, True, 0
        self.mute = self.garbles = False
        self._dialect, self._panel = TERMINALS[dialect], panel
        self._address, self._with_checksum = f"{address:02X}", with_checksum
        self._obeys_tripped, self._typed, self._lock = obeys_tripped, bytearray(), threading.RLock()
        self._restarted = True
        self._latched = 0
        self._sampled: tuple[int, int] | None = None
        self._power_on_bits = self._safe_bits = 0
        self._silence_s, self._heard_s, self._tripped = math.inf, 0.0, False
        self._commands = {**self._shared(), **(self._adam() if dialect.startswith("adam") else self._dcon())}
        self._fed_by_any = dialect.startswith("adam")

    def hear(self, data: bytes, time_s: float) -> Spoken:
        """Bytes have arrived; what is not understood, or addressed to another, gets no answer."""
        with self._lock:
            self._trip_if_due(time_s)
            spoken: list[tuple[float, bytes]] = []
            for byte in data if self.powered and not self.mute else b"":
                if byte == 13:
                    reply = self._answer(bytes(self._typed), time_s)
                    spoken += [] if reply is None else [(time_s + _TURNAROUND_S, self._framed(reply))]
                    self._typed.clear()
                elif len(self._typed) < 64:
                    self._typed.append(byte)
            return spoken

    def due_s(self) -> float:
        """When the watchdog will trip."""
        return math.inf if self._tripped or not self.powered else self._heard_s + self._silence_s

    def act(self, time_s: float) -> Spoken:
        """Trip, if it is time."""
        with self._lock:
            self._trip_if_due(time_s)
            return []

    def lose_power(self, time_s: float) -> None:
        """The supply fails: outputs off."""
        with self._lock:
            self._trip_if_due(time_s)
            self.powered = False
            self._switch(0, time_s)

    def restore_power(self, time_s: float) -> None:
        """The supply is back: settings that are not kept are forgotten, a latched trip is not."""
        with self._lock:
            self.powered, self._restarted, self._silence_s = True, True, math.inf
            self._typed.clear()
            if self._fed_by_any:
                self._tripped = False
            self._switch(self._power_on_bits, time_s)

    def reset(self, time_s: float) -> None:
        """A brown-out."""
        self.lose_power(time_s)
        self.restore_power(time_s)

    def trip(self, time_s: float) -> None:
        """Its watchdog trips now, as if it had not been fed."""
        with self._lock:
            self._switch(self._safe_bits, time_s)
            self._tripped = True

    def _answer(self, line: bytes, time_s: float) -> str | None:
        text = reply_text(line, self._with_checksum)
        if text is None:
            return None
        for pattern, action in self._commands.items():
            if match := re.fullmatch(pattern.replace("AA", self._address), text):
                if self._fed_by_any:
                    self._heard_s = time_s
                return action(match, time_s)
        addressed = text[1:3] == self._address and text[:1] in "#$@~%"
        return f"?{self._address}" if addressed and text[:1] != "~" else None

    def _framed(self, reply: str) -> bytes:
        text = bytes(byte ^ 0x2A for byte in reply.encode()) if self.garbles else reply.encode()
        return text + (checksum(text) if self._with_checksum else b"") + b"\r"

    def _shared(self) -> dict[str, "Action"]:
        address = self._address
        code = BAUD_CODES[self.baud]
        return {
            "#AA(?:00|0A)([0-9A-F]{2})": lambda m, t: self._switch_asked(int(m[1], 16), t),
            "#AA[1A]([0-7])(00|01)": lambda m, t: self._switch_asked(self._with_bit(int(m[1]), m[2] == "01"), t),
            r"#\*\*": lambda m, t: self._sample(t),
            r"\$AA4": lambda m, t: self._sampled_words(),
            r"\$AA6": lambda m, t: f"!{self.outputs:02X}{self._input_bits(t):02X}00",
            r"\$AA5": lambda m, t: f"!{address}{self._take_restart():d}",
            r"\$AAM": lambda m, t: f"!{address}{self._dialect.name}",
            r"\$AAF": lambda m, t: f"!{address}A2.00",
            r"\$AA2": lambda m, t: f"!{address}40{code:02X}{0x40 * self._with_checksum:02X}",
        }

    def _adam(self) -> dict[str, "Action"]:
        return {
            r"\$AAX0([0-9A-F]{4})([0-9A-F]{2})": lambda m, t: self._set_safety(int(m[1], 16), int(m[2], 16), t),
            r"\$AAX1": lambda m, t: f"!{self._tenths:04X}{self._safe_bits:02X}",
            r"\$AAX2": lambda m, t: f"!{self._tripped:02d}",
        }

    def _dcon(self) -> dict[str, "Action"]:
        address = self._address
        return {
            r"~\*\*": lambda m, t: self._feed(t),
            "~AA0": lambda m, t: f"!{address}{4 * self._tripped:02X}",
            "~AA1": lambda m, t: self._clear(t),
            "~AA2": lambda m, t: f"!{address}{self._tenths:02X}",
            "~AA3([01])([0-9A-F]{2})": lambda m, t: self._set_host_watchdog(m[1] == "1", int(m[2], 16), t),
            "~AA4([SP])": lambda m, t: f"!{address}{self._safe_bits if m[1] == 'S' else self._power_on_bits:02X}00",
            "~AA5([SP])": lambda m, t: self._keep(m[1]),
            "@AA([0-9A-F]{2})": lambda m, t: self._switch_asked(int(m[1], 16), t),
        }

    @property
    def _tenths(self) -> int:
        return 0 if self._silence_s == math.inf else round(self._silence_s * 10)

    def _switch_asked(self, bits: int, time_s: float) -> str:
        if self._tripped and not (self._fed_by_any and self._obeys_tripped):
            return "?" + self._address if self._fed_by_any else "!"
        self._switch(bits & (1 << self._dialect.outputs) - 1, time_s)
        return ">"

    def _switch(self, bits: int, time_s: float) -> None:
        if bits != self.outputs:
            self.outputs = bits
            self._panel.switch(bits, time_s)

    def _with_bit(self, place: int, on: bool) -> int:
        return self.outputs & ~(1 << place) | int(on) << place

    def _input_bits(self, time_s: float) -> int:
        return self._panel.input_bits(time_s) & (1 << self._dialect.inputs) - 1

    def _sample(self, time_s: float) -> None:
        self._sampled = (self.outputs, self._input_bits(time_s))

    def _sampled_words(self) -> str:
        outputs, inputs = self._sampled or (0, 0)
        return f"!{self._sampled is not None:d}{outputs:02X}{inputs:02X}00"

    def _take_restart(self) -> bool:
        restarted, self._restarted = self._restarted, False
        return restarted

    def _set_safety(self, tenths: int, bits: int, time_s: float) -> str:
        self._silence_s, self._safe_bits = tenths / 10 or math.inf, bits
        self._heard_s, self._tripped = time_s, False
        return ">"

    def _set_host_watchdog(self, enabled: bool, tenths: int, time_s: float) -> str:
        self._silence_s, self._heard_s = tenths / 10 if enabled else math.inf, time_s
        return f"!{self._address}"

    def _clear(self, time_s: float) -> str:
        self._tripped, self._heard_s = False, time_s
        return f"!{self._address}"

    def _feed(self, time_s: float) -> None:
        self._heard_s = time_s

    def _keep(self, kind: str) -> str:
        if kind == "S":
            self._safe_bits = self.outputs
        else:
            self._power_on_bits = self.outputs
        return f"!{self._address}"

    def _trip_if_due(self, time_s: float) -> None:
        if self.due_s() <= time_s:
            self._switch(self._safe_bits, self.due_s())
            self._tripped = True


Action = Callable[[re.Match[str], float], "str | None"]
