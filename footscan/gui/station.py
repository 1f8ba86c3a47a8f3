"""The station: machine, records and data folder that one page works with."""

from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from footscan import app
from footscan.config.rig_file import Rig
from footscan.coordinates import Side
from footscan.optics.calibration import Calibration
from footscan.records import RecordStore
from footscan.records.data_folder import SCANS
from footscan.scanning.session.control import Session
from footscan.scanning.session.plan import ScanPlan, plan_scan

CALIBRATION_RECORDINGS = "calibration-recordings"


@dataclass(frozen=True)
class Station:
    """An open machine with its records.

    Attributes:
        rig: Its file.
        session: The control thread.
        store: Patients and takes.
        data: The data folder.
        calibration: In force; None when there is none.
        calibration_words: Where it comes from.
        put_on_board: Lets another foot step on to a simulated board; None on a real machine.
    """

    rig: Rig
    session: Session
    store: RecordStore
    data: Path
    calibration: Calibration | None
    calibration_words: str
    put_on_board: Callable[[Side], None] | None

    @property
    def scans(self) -> Path:
        """Where scans lie until they are filed."""
        return self.data / SCANS

    @property
    def profiles(self) -> tuple[str, ...]:
        """Names of the rig's profiles, the usual one first."""
        return tuple(profile.name for profile in self.rig.motion.profile)

    def plan(self, profile: str) -> ScanPlan:
        """What a scan with a profile will be.

        Raises:
            ValueError: No such profile.
        """
        return plan_scan(self.rig.motion, self.rig.profile(profile or None), self.session.facts, self.rig.scanner)

    def calibration_days(self) -> int | None:
        """Age of the calibration; None when it has no date."""
        if self.calibration is None:
            return None
        try:
            made = datetime.fromisoformat(self.calibration.created)
        except ValueError:
            return None
        return (datetime.now(UTC) - made.astimezone(UTC)).days


@contextmanager
def open_station(rig: Rig, data: Path) -> Generator[Station]:
    """Open machine and records; everything is off at the end, however it ends.

    Raises:
        RecordsError: The records are foreign, newer, damaged, or kept busy.
        DeviceError: A device is missing or in trouble.
        ConfigError: The calibration in force is damaged.
    """
    with ExitStack() as stack:
        store = stack.enter_context(RecordStore(data))
        calibration, words = app.calibration_in_force(rig, data)
        opened = app.open_rig(rig)
        stack.callback(opened.give_back)
        session = app.start_session(opened, calibration)
        stack.callback(session.close)
        yield Station(rig, session, store, data, calibration, words, opened.put_on_board)
