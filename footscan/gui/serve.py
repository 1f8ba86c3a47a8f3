"""From start to end: station, door and page, until somebody stops the program."""

import signal
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager, redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path

from footscan.compiled import announce_compilation
from footscan.config.rig_file import Rig
from footscan.gui import texts
from footscan.gui.door import Address, check_address, open_door
from footscan.gui.heartbeat import PATIENCE_S
from footscan.gui.page import Page
from footscan.gui.self_check import check_page
from footscan.gui.station import open_station

Say = Callable[[str], None]


@contextmanager
def open_page(rig: Rig, data: Path, address: Address, patience_s: float = PATIENCE_S) -> Generator[Page]:
    """Serve the page as long as the block runs; lasers and motor are off at its end, however it ends.

    Raises:
        InputError: The address cannot be used.
        FootscanError: As `open_station`.
    """
    check_address(address)
    with open_station(rig, data) as station:
        with redirect_stdout(StringIO()):  # viser prints a banner that names the wrong things to do
            server = open_door(address, texts.TITLE)
        try:
            page = Page(server, station, patience_s)
            page.start()
            try:
                yield page
            finally:
                page.close()
        finally:
            server.stop()


def serve(rig: Rig, data: Path, address: Address, say: Say) -> None:
    """Serve until Ctrl-C or SIGTERM.

    Raises:
        FootscanError: As `open_page`.
    """
    ended = threading.Event()
    with announce_compilation(say), open_page(rig, data, address) as page:
        before = {number: signal.signal(number, lambda *_: ended.set()) for number in (signal.SIGTERM, signal.SIGINT)}
        try:
            say(f"footscan is at {url_of(page, address)}")
            ended.wait()
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)


def serve_and_check(rig: Rig, data: Path, address: Address, say: Say) -> None:
    """Serve, look at the page as a browser and as a stranger would, say what was found, and end.

    Raises:
        QualityError: The page does not stand.
        FootscanError: As `open_page`.
    """
    with announce_compilation(say), open_page(rig, data, address) as page:
        say(f"footscan is at {url_of(page, address)}")
        for sentence in check_page(replace(address, port=page.server.get_port())):
            say(sentence)


def url_of(page: Page, address: Address) -> str:
    """What a browser on this computer opens."""
    host = f"[{address.host}]" if ":" in address.host else address.host
    return f"http://{host}:{page.server.get_port()}"
