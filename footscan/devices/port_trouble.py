"""Why a port or camera cannot be opened, in words, and who else holds it."""

import contextlib
import errno
import grp
import os
from collections.abc import Iterator
from pathlib import Path

_BUSY = (errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK)
_DENIED = (errno.EACCES, errno.EPERM)
_NO_PORT = os.strerror(errno.ENOTTY)
_MISSING = (errno.ENOENT, errno.ENXIO, errno.ENODEV)


def opening_sentence(path: Path, err: Exception) -> str:
    """Why `path` did not open and what to do."""
    number = getattr(err, "errno", None)
    if number in _MISSING or not path.exists():
        return f"{path} does not exist; plug the device in, or give the path that `ls {_neighbours(path)}` shows."
    if number in _DENIED:
        return f"{path} may not be opened by this user; {permission_advice(path)}."
    if number in _BUSY:
        return f"{path} is used by {holders_words(path)}; end that program, then start again."
    why = "" if _NO_PORT in str(err) else f" ({err})"
    return f"{path} is no serial port{why}; give the path that `ls {_neighbours(path)}` shows."


def gone_sentence(path: str) -> str:
    """The port was open and is gone."""
    return f"{path} is gone (unplugged, or without power); check the device's cable and supply, then start again."


def permission_advice(path: Path) -> str:
    """What lets this user open a device."""
    try:
        group = grp.getgrgid(path.stat().st_gid).gr_name
    except (OSError, KeyError):
        group = "dialout"
    return f"add the user to the group {group} (`sudo usermod -aG {group} $USER`) and log in again"


def holders_words(path: Path, proc: Path = Path("/proc")) -> str:
    """Other programs that have a device open, as far as this user may see them."""
    found = sorted(set(_holders(path, proc)))
    return ", ".join(found) if found else "another program"


def _holders(path: Path, proc: Path) -> Iterator[str]:
    target = path.resolve()
    for process in proc.iterdir():
        if process.name.isdigit() and int(process.name) != os.getpid() and _has_open(process, target):
            with contextlib.suppress(OSError):
                yield f"{(process / 'comm').read_text().strip()} (process {process.name})"


def _has_open(process: Path, target: Path) -> bool:
    with contextlib.suppress(OSError):
        return any(link.resolve() == target for link in (process / "fd").iterdir())
    return False


def _neighbours(path: Path) -> str:
    return "/dev/v4l/by-id/" if "video" in path.name or "v4l" in str(path) else "/dev/serial/by-id/"
