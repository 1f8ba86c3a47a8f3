"""The only door to Numba: a typed decorator for hot loops, compiled at first use and cached on disk.

Nothing is compiled at import. `announce_compilation` tells a person why the first run takes longer.
"""

import hashlib
import os
import re
import shutil
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba.core import event
from platformdirs import user_cache_path

Real = float | np.floating[Any]
"""A number inside a compiled loop, of whatever width."""
Whole = int | np.integer[Any]
"""A whole number inside a compiled loop, of whatever width."""
Truth = bool | np.bool_

AnyFunction = TypeVar("AnyFunction", bound=Callable[..., object])


_FASTMATH = {"contract"}  # fused multiply-add only: NaN must keep its meaning


def _sources_digest() -> str:
    """Of the sources with compiled loops and of what these import: Numba alone would miss a change in a callee."""
    root = Path(__file__).parent
    digest = hashlib.sha256(str(root).encode())
    for path in _compiled_sources(root):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _compiled_sources(root: Path) -> list[Path]:
    sources = {path: path.read_text(encoding="utf-8") for path in root.rglob("*.py")}
    loops = {path for path, text in sources.items() if "from footscan.compiled import" in text}
    imported = {name for path in loops for name in re.findall(r"^from footscan\.([\w.]+) import", sources[path], re.M)}
    return sorted(loops | {root / f"{name.replace('.', '/')}.py" for name in imported} & sources.keys())


def _use_own_cache() -> None:
    """Keep machine code in a folder of this very version of the sources, and forget those unused for a month."""
    if os.environ.get("NUMBA_CACHE_DIR"):
        return
    caches = user_cache_path("footscan") / "compiled"
    own = caches / _sources_digest()
    try:
        own.mkdir(parents=True, exist_ok=True)
        os.utime(own)
        for other in caches.iterdir():
            if time.time() - other.stat().st_mtime > _FORGET_AFTER_S:
                shutil.rmtree(other, ignore_errors=True)
    except OSError:
        return  # no cache folder of our own: Numba then keeps its cache beside the sources, as by default
    settings: Any = numba.config
    settings.CACHE_DIR = str(own)


_FORGET_AFTER_S = 30 * 86400.0
_use_own_cache()


def compiled(function: AnyFunction) -> AnyFunction:
    """Compile a loop over numpy arrays to machine code (no Python objects, no interpreter lock)."""
    return cast("AnyFunction", numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=_FASTMATH)(function))


def compiled_inline(function: AnyFunction) -> AnyFunction:
    """Like `compiled`, for small functions called from inside other loops: not cached on their own."""
    return cast(
        "AnyFunction", numba.njit(nogil=True, error_model="numpy", fastmath=_FASTMATH, inline="always")(function)
    )


class _FirstCompilation(event.Listener):
    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._said = False

    def on_start(self, event: object) -> None:
        if not self._said:
            self._said = True
            self._say("Compiling the fast loops for this computer (once, up to a minute) ...")

    def on_end(self, event: object) -> None:
        pass


@contextmanager
def announce_compilation(say: Callable[[str], None]) -> Generator[None]:
    """While active, call `say` once when a loop has to be compiled because the disk cache does not hold it."""
    listener = _FirstCompilation(say)
    with event.install_listener("numba:compile", listener):
        yield
