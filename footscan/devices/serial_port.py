"""One serial port: opened by a stable name for this program alone, and every trouble said once, in words."""

import contextlib
import select
import termios
from pathlib import Path

import serial
from serial.tools import list_ports

from footscan.config.port_name import USB_PREFIX
from footscan.devices.port_trouble import gone_sentence, opening_sentence
from footscan.errors import DeviceError

_WRITE_TIMEOUT_S = 0.3
_CHUNK_BYTES = 4096


def path_of_port(name: str, lost: type[DeviceError]) -> str:
    """The path of a port named by path or as usb:SERIAL.

    Raises:
        lost: No such USB serial number is plugged in.
    """
    if not name.startswith(USB_PREFIX):
        return name
    wanted = name.removeprefix(USB_PREFIX)
    present = {str(port.serial_number): str(port.device) for port in list_ports.comports() if port.serial_number}
    if wanted not in present:
        shown = ", ".join(sorted(present)) or "none"
        raise lost(f"no USB device with serial number {wanted} is plugged in (found: {shown}); plug it in.")
    return present[wanted]


class SerialPort:
    """An open port. Errors are of the class its owner gives (`EncoderLostError`, `OutputsLostError`)."""

    def __init__(self, name: str, baud: int, lost: type[DeviceError]) -> None:
        """Open it; DTR high, RTS low, exclusive, with the least latency the driver offers.

        Raises:
            lost: It is missing, not permitted, or used by another program.
        """
        self.path, self.baud, self._lost = path_of_port(name, lost), baud, lost
        self._port = serial.Serial(timeout=0, write_timeout=_WRITE_TIMEOUT_S, exclusive=True)
        self._port.port, self._port.baudrate, self._port.dtr, self._port.rts = self.path, baud, True, False
        try:
            self._port.open()
        except (OSError, ValueError, termios.error) as err:
            raise lost(opening_sentence(Path(self.path), err)) from err
        with contextlib.suppress(OSError, ValueError, NotImplementedError):
            self._port.set_low_latency_mode(True)  # a pty and some bridges know no such mode

    def write(self, data: bytes) -> None:
        """Send.

        Raises:
            lost: The port is gone, or takes nothing for 0.3 s.
        """
        try:
            self._port.write(data)
        except (OSError, TypeError) as err:  # TypeError: closed by another thread in between
            raise self._lost(gone_sentence(self.path)) from err

    def read(self, timeout_s: float) -> bytes:
        """Whatever has arrived, or arrives first within `timeout_s`; empty if nothing does.

        Raises:
            lost: The port is gone.
        """
        try:
            ready, _, _ = select.select([self._port.fileno()], [], [], max(timeout_s, 0.0))
            return self._port.read(_CHUNK_BYTES) if ready else b""
        except (OSError, TypeError, ValueError) as err:
            raise self._lost(gone_sentence(self.path)) from err

    def wire_s(self, count: int) -> float:
        """Seconds that some bytes take on the wire: start bit, eight bits, stop bit."""
        return count * 10 / self.baud

    def close(self) -> None:
        """Give it back."""
        with contextlib.suppress(OSError):
            self._port.close()


class LineSplitter:
    """Bytes in, lines out: any mix of CR and LF ends a line; endless garbage does not pile up."""

    def __init__(self, longest: int = 256) -> None:
        self._rest, self._longest = b"", longest

    def feed(self, data: bytes) -> list[bytes]:
        """The lines that are now complete, without their ends; empty ones are left out."""
        *whole, rest = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        self._rest = rest[-self._longest :]
        return [line[-self._longest :] for line in whole if line]

    def clear(self) -> None:
        """Forget the beginning of a line."""
        self._rest = b""
