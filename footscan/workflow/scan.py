"""One scan without a screen: home, check, sweep, and the measured foot; and the scans that were never processed."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from footscan.config import RecordingInfo, Subject, save_calibration
from footscan.coordinates import Side
from footscan.errors import FootscanError, QualityError, RecordingError, StorageError
from footscan.optics.calibration import Calibration
from footscan.scanning.recorder import MANIFEST
from footscan.scanning.recording import open_recording
from footscan.scanning.session.checkup import CheckOrder, check_before_scan
from footscan.scanning.session.control import Session
from footscan.scanning.session.plan import ScanPlan
from footscan.scanning.session.programs import COUNTDOWN_S, ScanOrder, home, scan
from footscan.scanning.session.session_file import COMPLETE, load_outcome
from footscan.scanning.session.states import Finding, Snapshot
from footscan.scanning.session.ticket import Ticket
from footscan.workflow.process import ProcessSettings, process_recording
from footscan.workflow.results import save_results

Tell = Callable[[Snapshot], None]
RECORDING, RESULTS, CALIBRATION = "recording", "results", "calibration.toml"
_LOOK_S = 0.05


@dataclass(frozen=True)
class ScanSettings:
    """One scan as the operator wants it.

    Attributes:
        folder: Gets `recording/`, `results/` and `calibration.toml`.
        side: Of the foot.
        plan: Sweeps, lasers, speed.
        subject: Load, cover, take.
        notes: For recording.toml.
        countdown_s: Between Start and the first beam.
        by_button: Start is a press of the button on the machine.
        process: How the recording becomes a foot.
    """

    folder: Path
    side: Side
    plan: ScanPlan
    subject: Subject = field(default_factory=Subject)
    notes: str = ""
    countdown_s: float = COUNTDOWN_S
    by_button: bool = False
    process: ProcessSettings = field(default_factory=ProcessSettings)


def prepare_machine(session: Session, settings: ScanSettings, tell: Tell) -> list[Finding]:
    """Home the head if needed and check everything before the scan; the machine must be armed.

    Raises:
        DeviceError: A device is in trouble.
    """
    if session.snapshot().theta_deg is None:
        _follow(session, session.post(home), tell)
    order = CheckOrder(settings.folder, settings.plan, session.setup.tables)
    _follow(session, session.post(lambda machine: check_before_scan(machine, order)), tell)
    return list(session.snapshot().findings)


def refuse_findings(findings: list[Finding]) -> None:
    """Stop before a scan that would be useless.

    Raises:
        QualityError: A blocking finding; the sentence of each.
    """
    blocking = [finding for finding in findings if finding.blocking]
    if blocking:
        raise QualityError(" ".join(f"{finding.cause}: {finding.sentence}" for finding in blocking))


def refuse_used_folder(folder: Path) -> None:
    """Nothing recorded is ever overwritten, nor the calibration it was made under.

    Raises:
        RecordingError: The folder holds a recording already.
        StorageError: It is no folder, or cannot be one.
    """
    place = next(parent for parent in (folder, *folder.absolute().parents) if parent.exists())
    if not place.is_dir():
        raise StorageError(f"{place} is a file, no folder for a scan; choose another place.")
    if (folder / RECORDING / "recording.toml").exists():
        raise RecordingError(f"{folder} already holds a recording; choose another folder, nothing is overwritten.")


def record_scan(session: Session, settings: ScanSettings, calibration: Calibration, tell: Tell) -> Path:
    """Sweep, and leave the recording with the calibration it was made under; returns the recording's folder.

    Raises:
        DeviceError: A device failed, or somebody stopped it; what was captured is kept.
        RecordingError: The folder holds a recording already.
        StorageError: The place cannot be written or the disk is full; what was captured is kept.
    """
    refuse_used_folder(settings.folder)
    recording = settings.folder / RECORDING
    created = datetime.now(UTC).isoformat(timespec="seconds")
    try:
        recording.mkdir(parents=True, exist_ok=True)
    except OSError as err:
        raise StorageError(f"{recording} could not be made ({err.strerror}); choose another place.") from err
    save_calibration(calibration, settings.folder / CALIBRATION)
    info = RecordingInfo("scan", settings.side, created, settings.notes, settings.subject)
    order = ScanOrder(recording, info, settings.plan, settings.countdown_s, settings.by_button)
    _follow(session, session.post(lambda machine: scan(machine, order)), tell)
    return recording


def measure_recorded(
    settings: ScanSettings, calibration: Calibration, progress: Callable[[int, int], None]
) -> dict[str, Any]:
    """Process a recorded scan into `results/`; returns the content of scan.json.

    Raises:
        FootscanError: As `process_recording` and `save_results`.
    """
    recording = open_recording(settings.folder / RECORDING)
    result = process_recording(recording, calibration, settings.process, progress)
    return save_results(result, settings.process, settings.folder / RESULTS)


def _follow(session: Session, ticket: Ticket, tell: Tell) -> None:
    while not ticket.done:
        tell(session.snapshot())
        time.sleep(_LOOK_S)
    ticket.wait()
    tell(session.snapshot())


@dataclass(frozen=True)
class StoredScan:
    """A scan found in the data folder: whole or broken off, processed or not."""

    folder: Path
    side: str
    created: str
    frames: int
    finished: bool
    processed: bool
    trouble: str = ""


def find_scans(scans: Path) -> list[StoredScan]:
    """All scans below `<data>/scans`, oldest first; a damaged one is listed with what is wrong."""
    folders = sorted(path.parent for path in scans.glob(f"*/{RECORDING}") if path.is_dir())
    return [_stored(folder) for folder in folders]


def _stored(folder: Path) -> StoredScan:
    finished = (folder / RECORDING / MANIFEST).is_file()
    processed = (folder / RESULTS / "scan.json").is_file()
    try:
        finished = finished and load_outcome(folder / RECORDING) in (COMPLETE, None)
        recording = open_recording(folder / RECORDING)
    except (FootscanError, RecordingError) as err:
        return StoredScan(folder, "?", "?", 0, finished, processed, str(err))
    info = recording.info
    return StoredScan(folder, info.side, info.created, len(recording.frames), finished, processed)


def process_words(folder: Path) -> list[str]:
    """The command that measures a scan, whole or broken off in its first sweep, when only one laser was on."""
    words = ["footscan", "process", str(folder / RECORDING), "--calibration", str(folder / CALIBRATION)]
    words += ["--out", str(folder / RESULTS)]
    try:
        one_laser = lit_by_one_laser(folder / RECORDING)
    except FootscanError:
        return words
    return [*words, "--one-laser"] if one_laser else words


def lit_by_one_laser(recording: Path) -> bool:
    """Whether a scan was broken off before its second laser was on.

    Raises:
        RecordingError: It cannot be read.
    """
    return len({record.laser for record in open_recording(recording).frames} - {"none"}) == 1


def scan_folder(scans: Path, side: Side, moment: datetime | None = None) -> Path:
    """A new folder `<YYYYmmdd-HHMMSS>-<side>`; a second scan in the same second gets a number."""
    stem = f"{(moment or datetime.now(UTC)).strftime('%Y%m%d-%H%M%S')}-{side}"
    names = [stem, *(f"{stem}-{number}" for number in range(2, 100))]
    return next(scans / name for name in names if not (scans / name).exists())
