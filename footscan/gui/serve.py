"""From an open door to the page, until somebody stops the program."""

import signal
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import viser

from footscan.config.rig_file import Rig
from footscan.gui.door import Address, opened_door
from footscan.gui.heartbeat import PATIENCE_S
from footscan.gui.icons import icons_at_hand
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
    with opened_door(address) as server, page_behind(server, rig, data, patience_s) as page:
        yield page


@contextmanager
def page_behind(server: viser.ViserServer, rig: Rig, data: Path, patience_s: float = PATIENCE_S) -> Generator[Page]:
    """Open machine and records, and show the page behind a door that is open already.

    Raises:
        FootscanError: As `open_station`.
    """
    with open_station(rig, data) as station:
        server.gui.reset()
        with icons_at_hand():
            page = Page(server, station, patience_s)
        page.start()
        try:
            yield page
        finally:
            page.close()


def serve_behind(server: viser.ViserServer, rig: Rig, data: Path) -> None:
    """Serve until Ctrl-C or SIGTERM.

    Raises:
        FootscanError: As `open_station`.
    """
    ended = threading.Event()
    with page_behind(server, rig, data):
        before = {number: signal.signal(number, lambda *_: ended.set()) for number in (signal.SIGTERM, signal.SIGINT)}
        try:
            ended.wait()
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)


def check_behind(server: viser.ViserServer, rig: Rig, data: Path, address: Address, say: Say) -> None:
    """Serve, look at the page as a browser and as a stranger would, say what was found, and end.

    Raises:
        QualityError: The page does not stand.
        FootscanError: As `open_station`.
    """
    with page_behind(server, rig, data):
        for sentence in check_page(replace(address, port=server.get_port())):
            say(sentence)
