"""Icons from viser's archive of five thousand, whose list viser reads anew for each of them (0.07 s, fifteen times)."""

import zipfile
from collections.abc import Generator
from contextlib import contextmanager, nullcontext
from types import SimpleNamespace

from viser import _icons


@contextmanager
def icons_at_hand() -> Generator[None]:
    """While a page is built, the archive stays open."""
    whole = _icons.zipfile
    with zipfile.ZipFile(_icons.ICONS_DIR / "tabler-icons.zip") as archive:
        _icons.zipfile = SimpleNamespace(ZipFile=lambda _: nullcontext(archive))  # pyright: ignore
        try:
            yield
        finally:
            _icons.zipfile = whole
