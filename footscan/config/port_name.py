"""How a rig file names a serial port: a path that stays the same, a USB serial number, or an emulator."""

from typing import Annotated

from pydantic import AfterValidator

EMULATED = "emulated"
USB_PREFIX = "usb:"


def refuse_relative(name: str) -> str:
    """A device's absolute path, or "emulated".

    Raises:
        ValueError: Anything else.
    """
    if name != EMULATED and not (name.startswith("/") and len(name) > 1):
        raise ValueError(f'a path from the root such as /dev/v4l/by-id/... or "{EMULATED}" is allowed')
    return name


def _refuse_vague(name: str) -> str:
    by_serial = name.startswith(USB_PREFIX) and len(name) > len(USB_PREFIX)
    if not by_serial and name != EMULATED and not (name.startswith("/") and len(name) > 1):
        raise ValueError(
            f'a path such as /dev/serial/by-id/..., the USB serial number as "{USB_PREFIX}A10ABC", or "{EMULATED}" is '
            "allowed"
        )
    return name


PortName = Annotated[str, AfterValidator(_refuse_vague)]
