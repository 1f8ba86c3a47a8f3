"""Surfaces that take long to make are kept as files, by what they were made from; a file is only ever a copy."""

import hashlib
import io
import os
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from platformdirs import user_cache_path

from footscan.config.toml_file import write_whole
from footscan.errors import FootscanError
from footscan.sim.surface import Surface

_FORGET_AFTER_S = 30 * 86400.0
_DAMAGED = (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile)
_SOURCES = ("foot.py", "level_set.py")
"""Of what makes surfaces: another version of them makes other ones."""


def kept_surface(name: str, made_from: object, make: Callable[[], Surface]) -> Surface:
    """A surface from the user's cache folder, or made and put there.

    Without a folder that can be written, or with a damaged file in it, it is simply made.

    Args:
        name: Begins the file's name.
        made_from: Everything it depends on beside the sources; its `repr` must say it all.
        make: Makes it.
    """
    path = kept_path(name, made_from)
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            surface = Surface(file["xyz_world"], file["faces"])
        os.utime(path)
    except _DAMAGED:
        surface = make()
        _keep(path, surface)
    return surface


def kept_path(name: str, made_from: object) -> Path:
    """Where such a surface lies."""
    digest = hashlib.sha256(repr((np.__version__, made_from)).encode())
    for source in _SOURCES:
        digest.update(Path(__file__).with_name(source).read_bytes())
    return user_cache_path("footscan") / "surfaces" / f"{name}-{digest.hexdigest()[:24]}.npz"


def _keep(path: Path, surface: Surface) -> None:
    stream = io.BytesIO()
    np.savez(stream, xyz_world=surface.xyz_world, faces=surface.faces)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, stream.getvalue())
        for other in path.parent.iterdir():
            if time.time() - other.stat().st_mtime > _FORGET_AFTER_S:
                other.unlink(missing_ok=True)
    except (OSError, FootscanError):
        return  # no cache: the next program makes it again
