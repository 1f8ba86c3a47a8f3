"""What every tab gets and what it does; a new tab is one file `tab_*.py` and one line in `page.TABS`."""

from dataclasses import dataclass
from typing import Protocol

import viser

from footscan.gui.desk import Desk
from footscan.gui.logbook import Logbook
from footscan.gui.state import PageState
from footscan.gui.station import Station
from footscan.gui.view_foot import FootView
from footscan.gui.visit import PatientWork
from footscan.gui.visit_calibrate import CalibrationWork
from footscan.gui.visit_result import ResultWork
from footscan.gui.visit_scan import ScanWork
from footscan.scanning.session.states import Snapshot


@dataclass(frozen=True)
class Tools:
    """What a tab works with.

    Attributes:
        server: viser's; `server.gui` is where the tab puts its elements.
        desk: The state and the thread that changes it.
        station: Machine and records.
        view: The 3-D view.
        log: What happened.
        patients: Find, enter, choose.
        scan: Check and scan.
        result: What becomes of a scan.
        calibration: The guided calibration.
    """

    server: viser.ViserServer
    desk: Desk
    station: Station
    view: FootView
    log: Logbook
    patients: PatientWork
    scan: ScanWork
    result: ResultWork
    calibration: CalibrationWork


class Tab(Protocol):
    """A tab of the page; it is made with `Tools`, inside its place in the page."""

    def show(self, state: PageState) -> None:
        """A new state; on the desk's thread."""

    def tick(self, snapshot: Snapshot) -> None:
        """A dozen times a second; on the page's thread."""
