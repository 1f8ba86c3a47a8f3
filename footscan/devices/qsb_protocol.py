"""Lines of the US Digital QSB (QSB command list v1.28): commands, replies, registers."""

import re
from dataclasses import dataclass
from typing import Final, Literal

TICKS_PER_S: Final = 512
FACTORY_BAUD: Final = 230400

MODE: Final = 0x00
DIO_SETUP: Final = 0x02
COUNTER_MODE: Final = 0x03
COUNTER_SIGN: Final = 0x04
CAPTURE: Final = 0x05
CLEAR: Final = 0x09
THRESHOLD: Final = 0x0B
INTERVAL: Final = 0x0C
TIME_STAMP: Final = 0x0D
COUNT: Final = 0x0E
VERSION: Final = 0x14
LINE_FORMAT: Final = 0x15
COMMAND: Final = 0x16

CLEAR_COUNTER: Final = 0x2
STOP_STREAMS: Final = 0x1
SHORT_STAMPED_LINES: Final = 0x5
"""Line feed, time stamp, no spaces: 21 bytes a sample instead of 26."""
LATCH_ON_FALLING_DIO_0: Final = 0x011
FREE_RUNNING: Final = {"x1": 0x41, "x2": 0x42, "x4": 0x43}
"""Register 03: index off, free-running. The factory's 4F wraps the count at 500."""
_FREE_RUNNING_BITS: Final = 0b1100

_REPLY = re.compile(
    rb"([rwsex]) ?([0-9A-Fa-f]{2}) ?([0-9A-Fa-f]{8})(?: ?([0-9A-Fa-f]{8}))? ?!",
)
_BANNER = re.compile(rb"QSB-[DMS]\s.*!")
_TYPES = {0: "QSB-D", 1: "QSB-M", 2: "QSB-S"}

Verb = Literal["R", "W", "S"]


@dataclass(frozen=True)
class QsbReply:
    """One line: `kind` r, w, s (read, written, streamed), e (bad value) or x (unknown command)."""

    kind: str
    register: int
    value: int
    tick: int | None

    @property
    def refused(self) -> bool:
        """The device did not accept the command."""
        return self.kind in "ex"


@dataclass(frozen=True)
class QsbIdentity:
    """Register 14: what answers."""

    type: str
    firmware: int
    serial_number: int


def command(verb: Verb, register: int, value: int | None = None) -> bytes:
    """A line to send; negative values need all eight digits."""
    digits = "" if value is None else f"{value & 0xFFFFFFFF:X}"
    return f"{verb}{register:02X}{digits}\r".encode()


def reply_from_line(line: bytes) -> QsbReply | None:
    """What a line says, in any of the device's formats; None if it is no reply."""
    match = _REPLY.fullmatch(line.strip())
    if match is None:
        return None
    kind, register, value, tick = match.groups()
    return QsbReply(kind.decode(), int(register, 16), int(value, 16), None if tick is None else int(tick, 16))


def is_banner(line: bytes) -> bool:
    """The device has just restarted."""
    return _BANNER.search(line) is not None


def identity_from_version(value: int) -> QsbIdentity:
    """Register 14 is SSSSSTVV: serial number, type, firmware."""
    return QsbIdentity(_TYPES.get(value >> 8 & 0xF, "unknown QSB"), value & 0xFF, value >> 12)


def runs_freely(counter_mode: int) -> bool:
    """The counter neither wraps at a preset nor stops (register 03)."""
    return counter_mode & _FREE_RUNNING_BITS == 0


def unwrapped(word: int, near: int) -> int:
    """The integer whose low 32 bits are `word` and that lies nearest to `near`."""
    return near + ((word - near + 0x80000000) & 0xFFFFFFFF) - 0x80000000
