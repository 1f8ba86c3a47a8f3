"""From start to end: station, door and page, until somebody stops the program."""

import signal
import sys
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path

from footscan.config.rig_file import Rig
from footscan.gui import texts
from footscan.gui.door import Address, check_address, open_door
from footscan.gui.heartbeat import PATIENCE_S
from footscan.gui.page import Page
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
    with open_page(rig, data, address) as page:
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, lambda *_: ended.set())
        say(f"http://{address.host}:{page.server.get_port()}")
        ended.wait()
    sys.stdout.flush()
