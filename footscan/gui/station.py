"""The station: machine, records and data folder that one page works with."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from footscan.config.rig_file import Rig
from footscan.errors import DeviceError
from footscan.gui import texts
from footscan.optics.calibration import Calibration
from footscan.records import RecordStore
from footscan.records.data_folder import SCANS
from footscan.scanning.session.plan import ScanPlan, plan_scan
from footscan.workflow.calibration_log import Doubt, doubts, machine_name, read_log

if TYPE_CHECKING:
    from footscan.devices.diagnosis import Finding
    from footscan.scanning.session.control import Session
    from footscan.workflow.opened_rig import OpenedRig

CALIBRATION_RECORDINGS = "calibration-recordings"


class Station:
    """A machine with its records; `open` it before anything moves, and `close` it.

    Attributes:
        rig: Its file.
        store: Patients and takes.
        data: The data folder.
        opened: The devices; others after `reopen`.
        session: The control thread; another one after `reopen`.
        calibration: In force; None when there is none.
        calibration_words: Where it comes from.
        doubts: What spoke against relying on the calibration when that was last looked at.
    """

    def __init__(self, rig: Rig, data: Path, store: RecordStore) -> None:
        self.rig, self.data, self.store = rig, data, store
        self.calibration: Calibration | None
        self.calibration_words: str
        self.doubts: tuple[Doubt, ...]
        self.opened: OpenedRig
        self.session: Session

    def open(self) -> None:
        """Open the machine.

        Raises:
            DeviceError: A device is missing or in trouble.
            ConfigError: The calibration in force is damaged.
        """
        self._open()

    @property
    def scans(self) -> Path:
        """Where scans lie until they are filed."""
        return self.data / SCANS

    @property
    def calibration_recordings(self) -> Path:
        """Where recordings of the calibration board lie."""
        return self.data / CALIBRATION_RECORDINGS

    @property
    def simulated(self) -> bool:
        """No laser and no motor is real."""
        return self.opened.world is not None

    @property
    def profiles(self) -> tuple[str, ...]:
        """Names of the rig's profiles, the usual one first."""
        return tuple(profile.name for profile in self.rig.motion.profile)

    def plan(self, profile: str) -> ScanPlan:
        """What a scan with a profile will be.

        Raises:
            InputError: No such profile.
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

    def look_at_calibration(self) -> None:
        """Read again what speaks against the calibration: somebody may have noted an intervention meanwhile."""
        self.doubts = _doubts(self.data, self.calibration)

    @property
    def invalid(self) -> str:
        """Why the calibration in force makes scans wrong; empty when it does not."""
        return "; ".join(doubt.sentence for doubt in self.doubts if doubt.blocking)

    def reopen(self) -> None:
        """Close the machine and open it again, with the calibration that is in force now; nothing may be running.

        Raises:
            DeviceError: A device is missing or in trouble.
            ConfigError: The calibration in force is damaged.
        """
        self.session.close()
        self.opened.give_back()
        self._open()

    def examine(self) -> list[Finding]:
        """Close the machine, look at every device and at the disk as `footscan doctor` does, and open it again.

        What is wrong is a finding, also a machine that cannot be opened again: it stays closed then, nothing is on, and
        the next look tries it again.
        """
        from footscan import app
        from footscan.devices.diagnosis import Finding
        from footscan.workflow.doctor import examine_computer

        self.session.close()
        self.opened.give_back()
        found = list(examine_computer(self.data, self.scans, self.calibration, self.calibration_words))
        try:
            found += app.examine_devices(self.rig)
            self._open()
        except DeviceError as err:
            found.append(Finding("machine", "trouble", texts.NOT_OPENED_AGAIN.format(why=err)))
        return found

    def close(self) -> None:
        """Lasers and motor off, devices given back; safe to call twice."""
        self.session.close()
        self.opened.give_back()

    def _open(self) -> None:
        from footscan import app

        self.calibration, self.calibration_words = app.calibration_in_force(self.rig, self.data)
        self.look_at_calibration()
        opened = app.open_rig(self.rig)
        try:
            self.session = app.start_session(opened, self.calibration)
        except BaseException:
            opened.give_back()
            raise
        self.opened = opened


def _doubts(data: Path, calibration: Calibration | None) -> tuple[Doubt, ...]:
    """None of a machine without a history: the truth of a simulated machine has no date and needs none."""
    events = [] if calibration is None else read_log(data, machine_name(calibration))
    return tuple(doubts(calibration, events, datetime.now(UTC))) if calibration is not None and events else ()
