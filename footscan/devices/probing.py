"""Who answers on a serial port, when it is not who the rig file says: other speeds, addresses, the other protocol."""

import contextlib
from collections.abc import Generator, Iterator
from dataclasses import dataclass

from footscan.devices.adam_line import AdamLine
from footscan.devices.qsb_protocol import QsbIdentity
from footscan.devices.qsb_startup import identify
from footscan.devices.serial_port import SerialPort
from footscan.errors import DeviceError

BAUDS = (115200, 9600, 230400, 38400, 19200, 57600)
_ADDRESSES = tuple(range(16))
_REPLY_S = 0.04


@dataclass(frozen=True)
class FoundModule:
    """A digital I/O module that answered, and how it had to be asked."""

    name: str
    baud: int
    address: int
    checksum: bool


@dataclass(frozen=True)
class FoundQsb:
    """A QSB that answered, and at which speed."""

    identity: QsbIdentity
    baud: int


def find_qsb(port: str, first_baud: int) -> FoundQsb | None:
    """A QSB at the given or any other speed; its streams are stopped."""
    for baud in _beginning_with(first_baud, BAUDS):
        with contextlib.suppress(DeviceError), _opened(port, baud) as line:
            return FoundQsb(identify(line), baud)
    return None


def find_module(port: str, first: FoundModule) -> FoundModule | None:
    """An ADAM/DCON module: as the rig file says, at other speeds, with or without checksum, at other addresses."""
    return next(_modules(port, first), None)


def _modules(port: str, first: FoundModule) -> Iterator[FoundModule]:
    for baud in _beginning_with(first.baud, BAUDS):
        with contextlib.suppress(DeviceError), _opened(port, baud) as line:
            yield from _answers(line, baud, (first.address,))
    with contextlib.suppress(DeviceError), _opened(port, first.baud) as line:
        yield from _answers(line, first.baud, _ADDRESSES)


def _answers(line: SerialPort, baud: int, addresses: tuple[int, ...]) -> Iterator[FoundModule]:
    line.write(b"\r")  # ends whatever half a command another speed has left in the module
    for address in addresses:
        for checksum in (False, True):
            with contextlib.suppress(DeviceError):
                module = AdamLine(line, address, checksum, _REPLY_S, tries=1)
                name = module.ask("$", "M", r"!AA([ -~]+)")[1]
                yield FoundModule(name, baud, address, checksum)


def _beginning_with(first: int, others: tuple[int, ...]) -> Iterator[int]:
    yield first
    yield from (baud for baud in others if baud != first)


@contextlib.contextmanager
def _opened(port: str, baud: int) -> Generator[SerialPort]:
    line = SerialPort(port, baud, DeviceError)
    try:
        yield line
    finally:
        line.close()
