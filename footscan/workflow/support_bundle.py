"""`footscan support-bundle`: what somebody far away needs to help with a machine, and nothing about a person.

Two fences, one behind the other. What goes in is chosen key by key (figures, dates, hashes, names of parts; never free
text, never a path, never a picture). And whatever the records know of persons is removed from the finished text.
"""

import io
import json
import platform
import re
import zipfile
from collections.abc import Iterable
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from typing import Any

from footscan.config import load_calibration_record
from footscan.config.rig_file import Rig
from footscan.config.toml_file import write_whole
from footscan.errors import FootscanError
from footscan.optics.calibration import Calibration, fingerprint
from footscan.records import RecordStore
from footscan.records.data_folder import SCANS
from footscan.records.database import FILE_NAME
from footscan.workflow.calibration_log import TOUCHES, doubts, in_force_path, machines, read_log, zone_trends
from footscan.workflow.scan import find_scans

_EVENT_KEYS = ("at", "kind", "sha256", "expected_error_mm", "renewed", "holds", "figures", "agreement_mm")
_FIGURES = (
    "expected_error_mm",
    "standard_deviation",
    "standard_deviation_mm",
    "residual_px",
    "corners",
    "stripe_places",
    "scale_verified",
    "board",
    "seconds",
)
_MOST_PATIENTS = 10**6
_REMOVED = "(removed)"
_PATH = re.compile(r"\S*[/\\]\S*")
_QUOTED = re.compile(r"'[^']*'|\"[^\"]*\"")
_README = """What this bundle holds: versions, the machine's rig, its calibrations and their figures, when it was
calibrated, serviced and checked, how its lasers agreed in scans, and what the machine said of itself.
What it does not hold: patients, visits, scans, pictures, notes, names, paths of files.
"""


def save_support_bundle(data: Path, out: Path, rig: Rig | None = None) -> list[str]:
    """Write the bundle (ZIP); returns the names of its members.

    Raises:
        InputError: A damaged log or calibration.
        StorageError: The file cannot be written.
    """
    known = names_of_persons(data)
    members = {name: without(text, known) for name, text in _members(data, rig).items()}
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as bundle:
        for name, text in members.items():
            bundle.writestr(name, text)
    write_whole(out, stream.getvalue())
    return list(members)


def _members(data: Path, rig: Rig | None) -> dict[str, str]:
    members = {"README.txt": _README, "versions.json": _json(_versions()), "scans.json": _json(_scan_counts(data))}
    if rig is not None:
        members["rig.json"] = _json(_rig(rig))
    for number, machine in enumerate(machines(data), start=1):
        members |= _machine(data, machine, f"machine-{number}")
    if (data / "page.log").is_file():
        members["machine-log.txt"] = "\n".join(machine_lines((data / "page.log").read_text("utf-8", "replace")))
    return members


def _json(value: object) -> str:
    return json.dumps(value, indent=1, default=str) + "\n"


def _versions() -> dict[str, Any]:
    packages: dict[str, str] = {}
    try:
        wanted = requires("footscan") or []
    except PackageNotFoundError:
        wanted = []
    for name in ("footscan", *(re.split(r"[^A-Za-z0-9_.-]", line)[0] for line in wanted)):
        try:
            packages[name] = version(name)
        except PackageNotFoundError:
            packages[name] = "not installed"
    system = {"system": platform.system(), "release": platform.release(), "machine": platform.machine()}
    return {"made_at": _now(), "python": platform.python_version(), **system, "packages": packages}


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def _scan_counts(data: Path) -> dict[str, int]:
    found = find_scans(data / SCANS)
    return {
        "waiting": len(found),
        "broken_off": sum(not scan.finished for scan in found),
        "not_processed": sum(not scan.processed for scan in found),
    }


def _rig(rig: Rig) -> dict[str, Any]:
    """The parsed rig: comments are gone, and paths that are no device."""
    devices = rig.devices.model_dump(mode="json")
    return _without_paths(
        {"scanner": asdict(rig.scanner), "motion": rig.motion.model_dump(mode="json"), "devices": devices}
    )


def _without_paths(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_paths(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_without_paths(part) for part in value]
    if isinstance(value, str) and _PATH.search(value) and not value.startswith("/dev/"):
        return "(path)"
    return value


def _machine(data: Path, machine: str, place: str) -> dict[str, str]:
    events = read_log(data, machine)
    members = {f"{place}/log.json": _json([_event(event) for event in events])}
    path = in_force_path(data, machine)
    content: dict[str, Any] = {"machine_id": machine, "in_force": path.is_file()}
    if path.is_file():
        record = load_calibration_record(path)
        found = doubts(record.calibration, events, datetime.now(UTC))
        content["doubts"] = {"blocking": sum(d.blocking for d in found), "others": sum(not d.blocking for d in found)}
        content["calibration"] = _calibration(record.calibration)
        content["quality"] = {key: record.quality[key] for key in _FIGURES if key in record.quality}
        content["parents"] = [str(parent)[:64] for parent in record.history.get("parents", [])]
    content["drift"] = [asdict(trend) | {"drift_mm": trend.drift_mm} for trend in zone_trends(events)]
    return members | {f"{place}/calibration.json": _json(content)}


def _calibration(calibration: Calibration) -> dict[str, Any]:
    return asdict(calibration) | {"sha256": fingerprint(calibration)}


def _event(event: dict[str, Any]) -> dict[str, Any]:
    """An event without what somebody typed, and without where a recording lies."""
    kept = {key: event[key] for key in _EVENT_KEYS if key in event}
    return kept | ({"part": event["part"]} if event.get("part") in TOUCHES else {})


def machine_lines(log: str) -> list[str]:
    """What the machine said in the page's log; paths and quoted words are taken out."""
    lines = [line for line in log.splitlines() if re.match(r"\S+ {2}machine: ", line)]
    return [_QUOTED.sub("(text)", _PATH.sub("(path)", line)) for line in lines]


def names_of_persons(data: Path) -> list[str]:
    """Everything in the records that says who somebody is: names and their parts, numbers, birth dates, operators.

    A data folder without records, or with records that cannot be read, has none: then the first fence is the only one.
    """
    if not (data / FILE_NAME).is_file():
        return []
    words: set[str] = set()
    try:
        with RecordStore(data) as store:
            for patient in store.find_patients(limit=_MOST_PATIENTS):
                born = [] if patient.born is None else [patient.born.isoformat(), patient.born.strftime("%d.%m.%Y")]
                words |= {patient.name, patient.number or "", *patient.name.split(), *born}
            words |= {entry.by for entry in store.audit()}
    except FootscanError:
        return []
    return sorted((word for word in words if len(word) > 1), key=len, reverse=True)


def without(text: str, words: Iterable[str]) -> str:
    """A text with every whole occurrence of some words taken out, whatever their case."""
    found = [re.escape(word) for word in words]
    if not found:
        return text
    return re.sub(rf"(?<!\w)(?:{'|'.join(found)})(?!\w)", _REMOVED, text, flags=re.IGNORECASE)
