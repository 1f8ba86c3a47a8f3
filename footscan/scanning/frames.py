"""Pictures of a recording, one by one, each either a frame of the right size or a named reject."""

import zlib
from pathlib import Path
from typing import cast

import cv2
import numpy as np

from footscan.coordinates import Frame
from footscan.optics.camera import Camera

_PNG_MAGIC = b"\x89PNG\r\n\x1a\n"


class UnusableFrameError(Exception):
    """A picture that cannot be used; `reason` is its short name in the accounting."""

    def __init__(self, reason: str, detail: str) -> None:
        super().__init__(detail)
        self.reason = reason


def read_frame(path: Path, camera: Camera) -> Frame:
    """Read one upright frame `(height, width)` uint8.

    Raises:
        UnusableFrameError: The file is missing, empty, no PNG, cut, of another size, or not 8-bit grey.
    """
    try:
        content = path.read_bytes()
    except OSError as err:
        raise UnusableFrameError("missing", f"{path.name} cannot be read: {err.strerror}") from err
    if not content:
        raise UnusableFrameError("empty file", f"{path.name} has no content")
    if not content.startswith(_PNG_MAGIC) or len(content) < 33:
        raise UnusableFrameError("not a picture", f"{path.name} is no PNG file")
    width, height = int.from_bytes(content[16:20], "big"), int.from_bytes(content[20:24], "big")
    if (height, width) != (camera.height_px, camera.width_px):
        expected = f"{camera.width_px} x {camera.height_px}"
        raise UnusableFrameError("wrong size", f"{path.name} is {width} x {height}, the scanner says {expected}")
    if content[24:26] != b"\x08\x00":
        raise UnusableFrameError("not 8-bit grey", f"{path.name} is no 8-bit grey picture")
    _check_chunks(content, path.name)
    frame = cast("Frame | None", cv2.imdecode(np.frombuffer(content, dtype=np.uint8), cv2.IMREAD_UNCHANGED))
    if frame is None:
        raise UnusableFrameError("damaged picture", f"{path.name} cannot be decoded")
    return frame


def _check_chunks(content: bytes, name: str) -> None:
    """Every PNG chunk carries a checksum; OpenCV would decode a damaged one into a half grey picture."""
    at = len(_PNG_MAGIC)
    while at + 12 <= len(content):
        length = int.from_bytes(content[at : at + 4], "big")
        end = at + 8 + length
        if end + 4 > len(content):
            break
        if zlib.crc32(content[at + 4 : end]) != int.from_bytes(content[end : end + 4], "big"):
            raise UnusableFrameError("damaged picture", f"{name} was changed after it was written (checksum)")
        if content[at + 4 : at + 8] == b"IEND":
            return
        at = end + 4
    raise UnusableFrameError("cut file", f"{name} ends in the middle")
