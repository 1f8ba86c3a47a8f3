"""An emulated US Digital QSB (QSB command list v1.28), its factory settings and traps included."""

import math
import re
import threading
from collections.abc import Callable, Iterator

from footscan.devices import qsb_protocol as qsb
from footscan.sim.emulators.pty_line import Spoken

CountAt = Callable[[float], int]
"""The count of the quadrature signal (four edges a line) at a moment of the host's monotonic clock."""

_FACTORY = {0x00: 0, 0x01: 0xF, 0x02: 0, 0x03: 0x4F, 0x04: 0, 0x05: 0, 0x06: 0x0A, 0x08: 0x1F3, 0x0B: 0, 0x0C: 0xFFFF}
_WRITABLE = {0x00, 0x01, 0x02, 0x03, 0x04, 0x08, 0x09, 0x0A, 0x0B, 0x0C, 0x0D, 0x15, 0x16}
_READABLE = {*_FACTORY, 0x07, 0x0D, 0x0E, 0x14, 0x15}
_STREAMABLE = {0x01, 0x05, 0x06, 0x0E}
_COMMAND = re.compile(rb"([RWS])([0-9A-F]{2})([0-9A-F]{0,8})")
_NO_OUTPUT = 0xFFFF
_FLAT_OUT_TICKS = 0.05
BANNER = b"QSB-D  0E!\r\n"


class QsbEmulator:
    """A state machine; a `PtyLine` gives it a port.

    Attributes:
        baud: As set in the device.
        mute: Says nothing any more, as with a broken cable inside.
    """

    def __init__(
        self, count_at: CountAt, now_s: float, baud: int = qsb.FACTORY_BAUD, serial: int = 1234, ppm: float = 0.0
    ) -> None:
        """Power it on.

        Args:
            count_at: What it counts.
            now_s: When.
            baud: As set in the device.
            serial: Its serial number.
            ppm: How much too fast its crystal is.
        """
        self.baud, self.mute = baud, False
        self._count_at, self._serial, self._rate = count_at, serial, qsb.TICKS_PER_S * (1.0 + 1e-6 * ppm)
        self._lock = threading.RLock()
        self._spontaneous: list[tuple[float, bytes]] = []
        self._power_on(now_s)

    def hear(self, data: bytes, time_s: float) -> Spoken:
        """Bytes have arrived; commands end with CR, LF or both, a backspace erases."""
        with self._lock:
            spoken: list[tuple[float, bytes]] = []
            for byte in data:
                if byte in b"\r\n":
                    spoken += [(time_s, self._answer(bytes(self._typed), time_s))] if self._typed else []
                    self._typed.clear()
                elif byte == 8:
                    del self._typed[-1:]
                elif len(self._typed) < 40:
                    self._typed.append(byte)
            return self._audible(spoken)

    def due_s(self) -> float:
        """When the next streamed sample is taken."""
        with self._lock:
            if self._spontaneous:
                return self._spontaneous[0][0]
            return self._next_s if self._streams(qsb.COUNT) else math.inf

    def act(self, time_s: float) -> Spoken:
        """Stream all samples that are due; each is taken at its own tick, however late this is called."""
        with self._lock:
            spoken, self._spontaneous = self._spontaneous, []
            while self._streams(qsb.COUNT) and self._next_s <= time_s:
                moment_s, tick = self._next_s, self._next_tick
                self._schedule(tick + self._interval)
                count = self._count(moment_s)
                if abs(count - self._sent) >= self._registers[qsb.THRESHOLD]:
                    self._sent = count
                    spoken.append((moment_s, self._line("s", qsb.COUNT, count, moment_s)))
            return self._audible(spoken)

    def trigger(self, time_s: float) -> None:
        """A falling edge on DIO 0, as from a camera's strobe: the count is latched and streamed if asked for."""
        with self._lock:
            if self._registers[qsb.DIO_SETUP] & 0x11 == 0x11:
                self._registers[qsb.CAPTURE] = self._count(time_s)
                if self._streams(qsb.CAPTURE):
                    line = self._line("s", qsb.CAPTURE, self._registers[qsb.CAPTURE], time_s)
                    self._spontaneous.append((time_s, line))

    def reset(self, time_s: float) -> None:
        """Power fails for a moment: factory settings, count and ticks from zero, and a banner nobody documented."""
        with self._lock:
            self._power_on(time_s)
            self._spontaneous = [(time_s, BANNER)]

    def _power_on(self, time_s: float) -> None:
        self._registers = dict(_FACTORY)
        self._format, self._streaming = 0x0B, set[int]()
        self._typed = bytearray()
        self._zero_s, self._zero_count, self._sent = time_s, self._signal(time_s), 0
        self._next_s, self._next_tick = math.inf, 0.0

    def _answer(self, line: bytes, time_s: float) -> bytes:
        match = _COMMAND.fullmatch(line)
        if match is None:
            return self._line("x", 0, 0, time_s)
        verb, register, value = match[1].decode(), int(match[2], 16), int(match[3] or b"0", 16)
        if verb == "W":
            return self._write(register, value, time_s)
        return self._stream(register, time_s) if verb == "S" else self._read(register, time_s)

    def _read(self, register: int, time_s: float) -> bytes:
        self._streaming.discard(register)
        if register not in _READABLE:
            return self._line("x", register, 0, time_s)
        return self._line("r", register, self._value(register, time_s), time_s)

    def _stream(self, register: int, time_s: float) -> bytes:
        if register not in _STREAMABLE:
            return self._line("x", register, 0, time_s)
        self._streaming.add(register)
        self._schedule(math.floor(self._ticks(time_s)) + self._interval)
        return self._line("s", register, self._value(register, time_s), time_s)

    def _write(self, register: int, value: int, time_s: float) -> bytes:
        if register not in _WRITABLE:
            return self._line("x", register, value, time_s)
        if (register, value) == (qsb.COMMAND, qsb.STOP_STREAMS):
            self._streaming.clear()
        elif (register, value) == (qsb.CLEAR, qsb.CLEAR_COUNTER):
            self._zero_count, self._sent = self._signal(time_s), 0
        elif register == qsb.TIME_STAMP:
            self._zero_s = time_s
        elif register == qsb.LINE_FORMAT:
            self._format = value
        elif register in self._registers:
            self._registers[register] = value
        return self._line("w", register, value, time_s)

    def _value(self, register: int, time_s: float) -> int:
        special: dict[int, Callable[[], int]] = {
            0x07: lambda: self._count(time_s),
            qsb.COUNT: lambda: self._count(time_s),
            qsb.TIME_STAMP: lambda: math.floor(self._ticks(time_s)),
            qsb.VERSION: lambda: self._serial << 12 | 0x013,
            qsb.LINE_FORMAT: lambda: self._format,
        }
        return special[register]() if register in special else self._registers[register]

    def _signal(self, time_s: float) -> int:
        """The counter's input after its quadrature multiplication."""
        divide = {1: 4, 2: 2, 3: 1}.get(self._registers[qsb.COUNTER_MODE] & 0b11, 1)
        return self._count_at(time_s) // divide

    def _count(self, time_s: float) -> int:
        count = self._signal(time_s) - self._zero_count
        if self._registers[qsb.COUNTER_MODE] & 0b1100 == 0b1100:
            return count % (self._registers[0x08] + 1)
        return count

    def _ticks(self, time_s: float) -> float:
        return (time_s - self._zero_s) * self._rate

    @property
    def _interval(self) -> float:
        return float(self._registers[qsb.INTERVAL]) or _FLAT_OUT_TICKS

    def _schedule(self, tick: float) -> None:
        self._next_tick, self._next_s = tick, self._zero_s + tick / self._rate

    def _streams(self, register: int) -> bool:
        return register in self._streaming and self._registers[qsb.INTERVAL] != _NO_OUTPUT

    def _line(self, kind: str, register: int, value: int, time_s: float) -> bytes:
        space = " " if self._format & 8 else ""
        tick = math.floor(self._ticks(time_s) + 1e-3)
        stamp = [f"{tick & 0xFFFFFFFF:08X}"] if self._format & 4 else []
        end = "\r" * bool(self._format & 2) + "\n" * bool(self._format & 1)
        return (space.join([kind, f"{register:02X}", f"{value & 0xFFFFFFFF:08X}", *stamp, "!"]) + end).encode()

    def _audible(self, spoken: list[tuple[float, bytes]]) -> Iterator[tuple[float, bytes]]:
        return iter([] if self.mute else spoken)
