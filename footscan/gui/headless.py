"""A Chromium without a window, as the page's own check, its screenshots and its tests use it."""

import shutil
from collections.abc import Generator
from contextlib import contextmanager

from playwright.sync_api import Browser, BrowserContext, sync_playwright

from footscan.errors import InputError

_NAMES = ("chromium", "chromium-browser", "google-chrome")
_ARGUMENTS = (
    "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing", "--disable-gpu-rasterization",
)  # fmt: skip
"""3-D is drawn by SwiftShader; putting the page together through it as well, without a graphics card, takes a core."""
_CALM_MS = 150
_CALM = """(() => {
  const draw = window.requestAnimationFrame.bind(window), waiting = new Map();
  let last = 0;
  window.requestAnimationFrame = act => {
    const mine = ++last;
    waiting.set(mine, act);
    setTimeout(() => draw(now => { const act = waiting.get(mine); waiting.delete(mine); if (act) act(now); }), %d);
    return mine;
  };
  window.cancelAnimationFrame = mine => waiting.delete(mine);
})()"""


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


def keep_calm(context: BrowserContext) -> None:
    """Let the pages of a context draw seven times a second at most: clicking needs no more."""
    context.add_init_script(_CALM % _CALM_MS)
