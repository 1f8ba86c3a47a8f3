"""Question and answer with one module of the ADAM/DCON family (ASCII protocol, ADAM-4000 and I-7000 manuals).

A module that does not understand, or whose address or checksum is another, says nothing: silence is the only error.
"""

import re
import time

from footscan.devices.serial_port import LineSplitter, SerialPort
from footscan.errors import OutputsLostError

_LONGEST_REPLY_BYTES = 16


def checksum(text: bytes) -> bytes:
    """Sum of all characters modulo 256 as two upper-case hexadecimal digits."""
    return f"{sum(text) & 0xFF:02X}".encode()


def framed(command: str, with_checksum: bool) -> bytes:
    """A command as it goes over the wire."""
    text = command.encode()
    return text + (checksum(text) if with_checksum else b"") + b"\r"


def reply_text(line: bytes, with_checksum: bool) -> str | None:
    """A reply without its checksum; None if it is garbled."""
    text = line
    if with_checksum:
        text, found = line[:-2], line[-2:]
        if len(line) < 3 or found != checksum(text):
            return None
    return text.decode() if text.isascii() else None


class AdamLine:
    """One module on a port; every command is repeated once if nothing sensible comes back, for all may be repeated.

    Attributes:
        address: Two hexadecimal digits.
        last_exchange_s: When the last answer came.
        sampled_s: When the module read its inputs for it: after the command's last byte, before the answer's first.
    """

    def __init__(
        self, port: SerialPort, address: int, with_checksum: bool, reply_timeout_s: float, tries: int = 2
    ) -> None:
        self._port, self._with_checksum, self._timeout_s, self._tries = port, with_checksum, reply_timeout_s, tries
        self._lines = LineSplitter()
        self.address = f"{address:02X}"
        self.last_exchange_s = self.sampled_s = time.monotonic()

    def ask(self, lead: str, rest: str, allowed: str) -> re.Match[str]:
        """Send lead + address + rest; returns the match of the reply with `allowed` (a pattern, AA = the address).

        Raises:
            OutputsLostError: No answer, only nonsense, or the module calls the command invalid.
        """
        command = f"{lead}{self.address}{rest}"
        pattern = re.compile(allowed.replace("AA", self.address))
        heard: list[bytes] = []
        for _ in range(self._tries):
            reply = self._exchange(command, pattern, heard)
            if reply is not None:
                self.last_exchange_s = time.monotonic()
                return reply
        raise self._no_answer(command, heard)

    def tell(self, command: str) -> None:
        """Send what nobody answers."""
        self._port.write(framed(command, self._with_checksum))

    def _exchange(self, command: str, pattern: "re.Pattern[str]", heard: list[bytes]) -> re.Match[str] | None:
        self._forget_late_answers()
        line = framed(command, self._with_checksum)
        asked_s = time.monotonic()
        self._port.write(line)
        end_s = asked_s + self._timeout_s + self._port.wire_s(len(line) + _LONGEST_REPLY_BYTES)
        while data := self._port.read(end_s - time.monotonic()):  # what came while this program slept still counts
            for answer in self._lines.feed(data):
                text = reply_text(answer, self._with_checksum)
                if text is not None and (match := pattern.fullmatch(text)):
                    heard_s = asked_s + self._port.wire_s(len(line))
                    answers_s = time.monotonic() - self._port.wire_s(len(answer) + 1)
                    self.sampled_s = 0.5 * (heard_s + max(answers_s, heard_s))
                    return match
                heard[:] = [*heard[-2:], answer]
                if text == self._invalid:
                    return None
            if time.monotonic() > end_s + self._timeout_s:
                break
        return None

    def _forget_late_answers(self) -> None:
        for _ in range(8):
            if not self._port.read(0.0):
                break
        self._lines.clear()

    @property
    def _invalid(self) -> str:
        """The answer to a command that the module does not know, or that noise has spoiled."""
        return f"?{self.address}"

    def _no_answer(self, command: str, heard: list[bytes]) -> OutputsLostError:
        if heard and reply_text(heard[-1], self._with_checksum) == self._invalid:
            return OutputsLostError(
                f"the output module at address {self.address} on {self._port.path} does not know {command!r}; give "
                "the dialect of the module in the rig file."
            )
        if not heard:
            return OutputsLostError(
                f"the output module at address {self.address} on {self._port.path} does not answer {command!r} at "
                f"{self._port.baud} baud; check its supply, the wires A and B, address, baud rate and checksum."
            )
        shown = ", ".join(repr(line[:24]) for line in heard)
        return OutputsLostError(
            f"the output module at address {self.address} on {self._port.path} answers {command!r} with nonsense "
            f"({shown}); check its cable, its baud rate, its checksum setting, and that it is the named module."
        )
