"""The history of a machine's calibrations in the data folder: a log of events, and every calibration there was.

`<data>/calibrations/<machine>.toml` is in force, `<machine>.log.jsonl` holds one event per line (kind calibration, scan
or service), and `<machine>/<fingerprint>.toml` every calibration there was.
"""

import json
import os
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from footscan.config import calibration_toml
from footscan.config.toml_file import write_whole
from footscan.errors import InputError, StorageError
from footscan.optics.calibration import Calibration, fingerprint
from footscan.optics.table_store import tables_bytes
from footscan.workflow.process import build_tables

OLDEST_DAYS = 183
DRIFT_MM = 0.15
"""Median left/right disagreement of still scans may move this far from where it was right after calibrating."""
_RECENT = 5
_FOLDER = "calibrations"


@dataclass(frozen=True)
class ZoneTrend:
    """Left/right disagreement of still scans in one zone, oldest first."""

    zone: str
    created: tuple[str, ...]
    median_mm: tuple[float, ...]

    @property
    def drift_mm(self) -> float:
        """Median of the last scans minus that of the first ones."""
        return float(np.median(self.median_mm[-_RECENT:]) - np.median(self.median_mm[:_RECENT]))


def machine_name(calibration: Calibration) -> str:
    """The name under which a machine's calibrations are kept."""
    return calibration.machine_id or calibration.scanner


def in_force_path(data: Path, machine: str) -> Path:
    """Where the calibration in force of a machine lies."""
    return data / _FOLDER / f"{_file_name(machine)}.toml"


def log_path(data: Path, machine: str) -> Path:
    """Where the events of a machine are logged."""
    return data / _FOLDER / f"{_file_name(machine)}.log.jsonl"


def _file_name(machine: str) -> str:
    if not machine or Path(machine).name != machine or machine.startswith("."):
        raise InputError(f"a machine called {machine!r} cannot be a file name; correct machine_id in scanner.toml.")
    return machine


def keep_in_force(data: Path, calibration: Calibration, quality: dict[str, Any], history: dict[str, Any]) -> None:
    """Put a calibration in force: kept under its fingerprint, then copied, then logged.

    Raises:
        StorageError: A file could not be written.
    """
    machine, digest = machine_name(calibration), fingerprint(calibration)
    content = calibration_toml(calibration, quality, history)
    write_whole(data / _FOLDER / _file_name(machine) / f"{digest[:16]}.toml", content)
    path = in_force_path(data, machine)
    write_whole(path.with_suffix(".tables.npz"), tables_bytes(build_tables(calibration)))
    write_whole(path, content)
    expected = quality.get("expected_error_mm", {})
    log_event(data, machine, "calibration", {"sha256": digest, "expected_error_mm": expected})


def log_event(data: Path, machine: str, kind: str, content: dict[str, Any]) -> None:
    """Append one event; the line is on the disk when this returns.

    Raises:
        StorageError: The log could not be written.
    """
    path = log_path(data, machine)
    event = {"at": datetime.now(UTC).isoformat(timespec="seconds"), "kind": kind, **content}
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(event) + "\n")
            stream.flush()
            os.fsync(stream.fileno())
    except OSError as err:
        raise StorageError(
            f"{path} could not be written ({err.strerror}); free space or choose another place."
        ) from err


def read_log(data: Path, machine: str) -> list[dict[str, Any]]:
    """All events of a machine, oldest first; a machine without a log has none.

    Raises:
        InputError: A line is no event (a cut last line is left out: power may fail while writing).
    """
    path = log_path(data, machine)
    if not path.is_file():
        return []
    lines = path.read_text(encoding="utf-8").splitlines()
    events: list[dict[str, Any]] = []
    for number, line in enumerate(lines, start=1):
        try:
            events.append(dict(json.loads(line)))
        except ValueError:
            if number == len(lines):
                break
            raise InputError(f"{path} line {number} is no event; restore the file from a backup.") from None
    return events


def machines(data: Path) -> list[str]:
    """Machines with a log in the data folder."""
    return sorted(path.name.removesuffix(".log.jsonl") for path in (data / _FOLDER).glob("*.log.jsonl"))


def note_scan(data: Path, machine: str, report: dict[str, Any]) -> bool:
    """Log the left/right disagreement of a processed scan (the content of scan.json), if the foot was judged still.

    Returns:
        Whether it was logged: a foot that moved says nothing about the machine.
    """
    zones = {entry["zone"]: entry for entry in report.get("motion", {}).get("zones", [])}
    moved = [zone.get("moved") for zone in zones.values()]
    if not moved or any(word is True for word in moved) or all(word is None for word in moved):
        return False
    agreement = {z["zone"]: z["median_mm"] for z in report["agreement"] if z["median_mm"] is not None}
    content = {"agreement_mm": agreement, "sha256": report["calibration"]["sha256"], "recording": report["recording"]}
    log_event(data, machine, "scan", content)
    return True


def zone_trends(events: list[dict[str, Any]]) -> list[ZoneTrend]:
    """Left/right disagreement per zone of the scans since the last calibration."""
    since = max((k for k, event in enumerate(events) if event["kind"] == "calibration"), default=-1)
    scans = [event for event in events[since + 1 :] if event["kind"] == "scan"]
    names = sorted({zone for scan in scans for zone in scan["agreement_mm"]})
    trends: list[ZoneTrend] = []
    for name in names:
        own = [scan for scan in scans if name in scan["agreement_mm"]]
        values = tuple(float(scan["agreement_mm"][name]) for scan in own)
        trends.append(ZoneTrend(name, tuple(str(scan["at"]) for scan in own), values))
    return trends


def reminders(calibration: Calibration, events: list[dict[str, Any]], now: datetime) -> list[str]:
    """What speaks against relying on a calibration: its age, later interventions, drift of the lasers."""
    result: list[str] = []
    age_days = (now - datetime.fromisoformat(calibration.created)).days if calibration.created else None
    if age_days is None:
        result.append("the calibration does not say when it was made")
    elif age_days > OLDEST_DAYS:
        result.append(f"the calibration is {age_days} days old, at most {OLDEST_DAYS}: recalibrate")
    own = fingerprint(calibration)
    since = max((k for k, e in enumerate(events) if e["kind"] == "calibration" and e.get("sha256") == own), default=-1)
    for event in events[since + 1 :]:
        if event["kind"] == "service":
            result.append(f"{event['at'][:10]}: {event.get('what', 'intervention')}; recalibrate what it touched")
    for trend in zone_trends(events):
        if len(trend.median_mm) >= 2 * _RECENT and abs(trend.drift_mm) > DRIFT_MM:
            result.append(
                f"the lasers drift apart at the {trend.zone} by {trend.drift_mm:+.2f} mm over {len(trend.median_mm)} "
                f"still scans, at most {DRIFT_MM} mm: recalibrate"
            )
    return result
