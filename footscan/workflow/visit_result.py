"""A folder of results as what the records keep of it, and back: the settings with which it can be made again."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import footscan
from footscan.errors import InputError
from footscan.foot.measurements import definitions
from footscan.records import Measured, NewResult
from footscan.scanning.filters import FilterSettings
from footscan.scanning.sweep import SweepSettings
from footscan.workflow.foot import FootSettings
from footscan.workflow.process import ProcessSettings

_NO_FOOT = "points only, no foot was fitted"


def result_from_folder(folder: Path) -> NewResult:
    """Read scan.json and measurements.json of a folder made by `process`.

    Raises:
        InputError: A file is damaged, or of a footscan too old for the records.
    """
    report = _read(folder / "scan.json")
    try:
        foot = report.get("foot", {"refused": _NO_FOOT})
        refused = str(foot.get("refused", ""))
        subject = report["subject"]
        measured = () if refused else _measured(_read(folder / "measurements.json"), report["versions"])
        return NewResult(
            side=_side(folder, report, refused),
            load=subject["load"],
            missing=tuple(subject["absent"]),
            calibration_sha256=report["calibration"]["sha256"],
            settings=_settings(report),
            versions=report["versions"],
            refused=refused,
            measurements=measured,
        )
    except (KeyError, TypeError, AttributeError) as err:
        raise InputError(f"{folder} holds no complete results ({err!r}); process the recording again.") from err


def _side(folder: Path, report: Mapping[str, Any], refused: str) -> Any:
    """The side as used: that of the measurements, else of the order."""
    side = report["side"] if refused else _read(folder / "measurements.json")["side"]
    if side not in ("left", "right"):
        raise InputError(f"{folder} does not say which foot it is; process the recording again with --side.")
    return side


def _settings(report: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "threshold": report["threshold"] if report["threshold_source"] == "given" else None,
        "threshold_used": report["threshold"],
        "filter": report["filter"],
        "one_laser": report.get("one_laser", False),
        "foot_settings": report.get("foot_settings", asdict(FootSettings())),
        "object": report["object"],
    }


def settings_of_result(result: NewResult) -> ProcessSettings:
    """The settings a result was made with; what the operator says of the foot is not among them."""
    stored = result.settings
    sweep = SweepSettings(stored["threshold"], FilterSettings(**stored["filter"]))
    foot = FootSettings(**stored["foot_settings"])
    return ProcessSettings(sweep, stored["object"], one_laser=stored["one_laser"], foot=foot)


def _measured(content: Mapping[str, Any], versions: Mapping[str, Any]) -> tuple[Measured, ...]:
    texts = definitions() if versions["footscan"] == footscan.__version__ else {}
    return tuple(
        _one(name, value, texts.get(name, f"{name} as defined by footscan {versions['footscan']}"))
        for name, value in content["measurements"].items()
    )


def _one(name: str, value: Mapping[str, Any], definition: str) -> Measured:
    interval = value["interval"]
    return Measured(
        name=name,
        value=value["value"],
        unit=value["unit"],
        reliable=value["reliable"],
        reason=value["reason"],
        interval=None if interval is None else (interval[0], interval[1]),
        unusual=value["unusual"],
        definition=definition,
        version=hashlib.sha256(definition.encode()).hexdigest()[:12],
    )


def _read(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as err:
        raise InputError(f"{path} is missing or damaged ({err}); process the recording again.") from err
    if not isinstance(content, dict):
        raise InputError(f"{path} is damaged; process the recording again.")
    return content
