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
from footscan.gui.readiness import hurried
from footscan.gui.station import Station
from footscan.records import RecordStore

Say = Callable[[str], None]
Fill = Callable[[RecordStore], object]


@contextmanager
def open_page(rig: Rig, data: Path, address: Address, patience_s: float = PATIENCE_S) -> Generator[Page]:
    """Serve the page as long as the block runs; lasers and motor are off at its end, however it ends.

    Raises:
        InputError: The address cannot be used.
        FootscanError: As `page_behind`.
    """
    with opened_door(address) as server, page_behind(server, rig, data, patience_s) as page:
        yield page


@contextmanager
def page_behind(
    server: viser.ViserServer, rig: Rig, data: Path, patience_s: float = PATIENCE_S, fill: Fill = lambda store: None
) -> Generator[Page]:
    """Show the page behind a door that is open already; the machine is opened while the browser draws it.

    Args:
        server: Its door.
        rig: The machine.
        data: The data folder.
        patience_s: How long the controlling browser may be silent.
        fill: Called with the records before anybody sees them.

    Raises:
        RecordsError: The records are foreign, newer, damaged, or kept busy.
        DeviceError: A device is missing or in trouble.
        ConfigError: The calibration in force is damaged.
    """
    with RecordStore(data) as store:
        station = Station(rig, data, store)
        with hurried(), icons_at_hand():
            fill(store)
            server.gui.reset()
            page = Page(server, station, patience_s)
            station.open()
        try:
            page.start()
            yield page
        finally:
            page.close()
            station.close()


def serve_behind(server: viser.ViserServer, rig: Rig, data: Path, fill: Fill) -> None:
    """Serve until Ctrl-C or SIGTERM.

    Raises:
        FootscanError: As `page_behind`.
    """
    ended = threading.Event()
    with page_behind(server, rig, data, fill=fill):
        before = {number: signal.signal(number, lambda *_: ended.set()) for number in (signal.SIGTERM, signal.SIGINT)}
        try:
            ended.wait()
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)


def check_behind(server: viser.ViserServer, rig: Rig, data: Path, fill: Fill, address: Address, say: Say) -> None:
    """Serve, look at the page as a browser and as a stranger would, say what was found, and end.

    Raises:
        QualityError: The page does not stand.
        FootscanError: As `page_behind`.
    """
    from footscan.gui.self_check import check_page

    with page_behind(server, rig, data, fill=fill):
        for sentence in check_page(replace(address, port=server.get_port())):
            say(sentence)
