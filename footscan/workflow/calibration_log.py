"""The history of a machine's calibrations in the data folder: a log of events, and every calibration there was.

`<data>/calibrations/<machine>.toml` is in force, `<machine>.log.jsonl` holds one event per line (calibration, scan,
service, recheck or daily), and `<machine>/<fingerprint>.toml` every calibration there was.
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
from footscan.optics.tables import build_tables

OLDEST_DAYS = 183
DRIFT_MM = 0.15
"""Median left/right disagreement of still scans may move this far from where it was right after calibrating."""
_RECENT = 5
_FOLDER = "calibrations"


@dataclass(frozen=True)
class Touched:
    """What an intervention is, what of the calibration it makes invalid, and what to do.

    Attributes:
        what: In words, where the technician gave none.
        parts: Of the calibration that are no longer known.
        remedy: What to do.
        blocking: No scan should rely on the calibration until then; else a passed check is enough.
    """

    what: str
    parts: str
    remedy: str
    blocking: bool


_WHOLE = "calibrate the whole machine"


def _renew(part: str) -> str:
    return f"renew it: footscan calibrate RECORDING --renew {part}, or {_WHOLE}"


TOUCHES: dict[str, Touched] = {
    "right-laser": Touched("new or moved right laser", "the right sheet", _renew("right-laser"), True),
    "left-laser": Touched("new or moved left laser", "the left sheet", _renew("left-laser"), True),
    "encoder": Touched("new encoder", "zero, direction, eccentricity, latency", _renew("encoder"), True),
    "footboard": Touched("new or moved footboard", "the floor plane", _renew("footboard"), True),
    "lens": Touched("lens exchanged or turned", "everything", _WHOLE, True),
    "camera": Touched("camera exchanged or moved", "everything", _WHOLE, True),
    "carriage": Touched("carriage or bearing repaired", "everything", _WHOLE, True),
    "moved": Touched("machine moved", "perhaps something", "re-check it: footscan calibration recheck", False),
    "cleaned": Touched(
        "glass or lens cleaned", "perhaps something", "re-check it: footscan calibration recheck", False
    ),
}
"""Interventions by the part they were made at."""


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
        InputError: It was recorded before an intervention.
        StorageError: A file could not be written.
    """
    machine, digest = machine_name(calibration), fingerprint(calibration)
    recorded_at = str(quality.get("recorded_at", ""))
    refuse_outdated(data, machine, recorded_at)
    content = calibration_toml(calibration, quality, history)
    write_whole(data / _FOLDER / _file_name(machine) / f"{digest[:16]}.toml", content)
    path = in_force_path(data, machine)
    write_whole(path.with_suffix(".tables.npz"), tables_bytes(build_tables(calibration)))
    write_whole(path, content)
    expected = quality.get("expected_error_mm", {})
    event: dict[str, Any] = {"sha256": digest, "expected_error_mm": expected, "recorded_at": recorded_at}
    renewed = {"renewed": history["renewed"]} if "renewed" in history else {}
    log_event(data, machine, "calibration", event | renewed)


def refuse_outdated(data: Path, machine: str, recorded_at: str) -> None:
    """Refuse to rely on what was recorded before an intervention that makes the calibration invalid.

    Raises:
        InputError: Such an intervention was noted after `recorded_at` (RFC 3339; empty: unknown, which is not refused).
    """
    for event in read_log(data, machine):
        part = str(event.get("part", ""))
        blocking = part not in TOUCHES or TOUCHES[part].blocking
        if event["kind"] == "service" and blocking and _before(recorded_at, event):
            raise InputError(
                f"the recording was made at {recorded_at}, before the intervention noted at {event['at']} "
                f"({event.get('what', part)}): it does not show the machine as it is now. Record again."
            )


def _before(recorded_at: str, event: dict[str, Any]) -> bool:
    """Whether something recorded at a moment cannot show what an event did; unknown moments can."""
    return bool(recorded_at) and _moment(recorded_at) < _moment(str(event["at"]))


def _moment(text: str) -> datetime:
    moment = datetime.fromisoformat(text)
    return moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)


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


@dataclass(frozen=True)
class Doubt:
    """Something that speaks against relying on a calibration; a blocking one makes scans wrong."""

    sentence: str
    blocking: bool = False


def doubts(calibration: Calibration, events: list[dict[str, Any]], now: datetime) -> list[Doubt]:
    """What speaks against a calibration: its age, interventions since, failed checks, drift of the lasers."""
    found: list[Doubt] = []
    age_days = (now - datetime.fromisoformat(calibration.created)).days if calibration.created else None
    if age_days is None:
        found.append(Doubt("the calibration does not say when it was made"))
    elif age_days > OLDEST_DAYS:
        found.append(Doubt(f"the calibration is {age_days} days old, at most {OLDEST_DAYS}: recalibrate"))
    found += _interventions(_since(calibration, events))
    found += _failed_checks(_since(calibration, events))
    for trend in zone_trends(events):
        if len(trend.median_mm) >= 2 * _RECENT and abs(trend.drift_mm) > DRIFT_MM:
            found.append(
                Doubt(
                    f"the lasers drift apart at the {trend.zone} by {trend.drift_mm:+.2f} mm over "
                    f"{len(trend.median_mm)} still scans, at most {DRIFT_MM} mm: recalibrate"
                )
            )
    return found


def reminders(calibration: Calibration, events: list[dict[str, Any]], now: datetime) -> list[str]:
    """The sentences of all doubts."""
    return [doubt.sentence for doubt in doubts(calibration, events, now)]


def _since(calibration: Calibration, events: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What still counts: events after the calibration came into force, and before it what a renewal left open."""
    own = fingerprint(calibration)
    at = max((k for k, e in enumerate(events) if e["kind"] == "calibration" and e.get("sha256") == own), default=-1)
    if at < 0:
        return events
    if "renewed" not in events[at]:
        unseen = [e for e in events[:at] if e["kind"] == "service" and _before(events[at].get("recorded_at", ""), e)]
        return [*unseen, *events[at + 1 :]]
    whole = max((k for k in range(at) if events[k]["kind"] == "calibration" and "renewed" not in events[k]), default=-1)
    done = [events[k]["renewed"] for k in range(whole + 1, at + 1) if "renewed" in events[k]]
    left = [e for e in events[whole + 1 : at] if e["kind"] == "service" and e.get("part") not in done]
    return [*left, *events[at + 1 :]]


def _interventions(events: list[dict[str, Any]]) -> list[Doubt]:
    """Interventions that no later check has cleared."""
    open_: list[Doubt] = []
    checkable: list[tuple[dict[str, Any], Doubt]] = []
    for event in events:
        if event["kind"] == "service":
            touched = TOUCHES.get(event.get("part", ""))
            what = event.get("what") or (touched.what if touched else "intervention")
            remedy = touched.remedy if touched else "recalibrate what it touched"
            doubt = Doubt(f"{event['at'][:10]}: {what}; {remedy}", touched is not None and touched.blocking)
            if doubt.blocking or touched is None:
                open_.append(doubt)
            else:
                checkable.append((event, doubt))
        elif event["kind"] in ("recheck", "daily") and event.get("holds"):
            seen_at = str(event.get("recorded_at", ""))
            checkable = [(service, doubt) for service, doubt in checkable if _before(seen_at, service)]
    return [*open_, *(doubt for _, doubt in checkable)]


def _failed_checks(events: list[dict[str, Any]]) -> list[Doubt]:
    """The last check of each kind, if it failed."""
    last = {event["kind"]: event for event in events if event["kind"] in ("recheck", "daily")}
    word = {"recheck": "the re-check with the board", "daily": "the daily check with the test body"}
    return [
        Doubt(f"{event['at'][:10]}: {word[kind]} failed ({'; '.join(event.get('broken', []))}): recalibrate", True)
        for kind, event in last.items()
        if not event.get("holds")
    ]


def log_service(data: Path, machine: str, part: str, what: str) -> Touched:
    """Note an intervention; returns what it makes invalid.

    Raises:
        InputError: No such part.
        StorageError: The log could not be written.
    """
    touched = TOUCHES.get(part)
    if touched is None:
        raise InputError(f"an intervention is at one of {', '.join(TOUCHES)}; found {part!r}.")
    log_event(data, machine, "service", {"part": part, "what": what or touched.what})
    return touched
