"""A Chromium without a window, as the page's own check, its screenshots and its tests use it."""

import shutil
from collections.abc import Generator
from contextlib import contextmanager

from playwright.sync_api import Browser, sync_playwright

from footscan.errors import InputError

_NAMES = ("chromium", "chromium-browser", "google-chrome")
_ARGUMENTS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def find_chromium() -> str | None:
    """The path of an installed Chromium."""
    return next((path for name in _NAMES if (path := shutil.which(name))), None)


@contextmanager
def open_chromium() -> Generator[Browser]:
    """A browser that draws 3-D without a graphics card.

    Raises:
        InputError: There is none.
    """
    path = find_chromium()
    if path is None:
        raise InputError(f"none of {', '.join(_NAMES)} is installed; install one (apt-get install chromium).")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, headless=True, args=list(_ARGUMENTS))
        try:
            yield browser
        finally:
            browser.close()
