"""`footscan info`: what a recording, calibration, scanner or board file holds."""

import math
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from footscan.cli.console import STDOUT, print_json
from footscan.config import file_kind, load_board, load_calibration, load_recording_info, load_scanner
from footscan.errors import ConfigError
from footscan.optics.calibration import camera_from_world, fingerprint, optical_centre_world
from footscan.optics.head import lens_offset_a_mm, translation_from_head
from footscan.optics.sheet import alpha_from_sheet, plane_in_camera
from footscan.scanning.recording import open_recording
from footscan.scanning.verify import verify_recording


def info(
    path: Annotated[Path, typer.Argument(help="Recording folder, calibration, scanner or board file.")],
    json_only: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Say what a recording, calibration, scanner or board is, and whether it is complete."""
    content = _recording(path) if path.is_dir() else _file(path)
    if json_only:
        print_json(content)
    else:
        _print(content, "")


def _file(path: Path) -> dict[str, Any]:
    kind = file_kind(path)
    if kind == "calibration":
        return _calibration(path)
    if kind == "scanner":
        return _scanner(path)
    if kind == "board":
        return {"kind": kind, **asdict(load_board(path))}
    if kind == "recording":
        return {"kind": kind, **asdict(load_recording_info(path))}
    raise ConfigError(f"{path} is a footscan {kind} file; info knows recording, calibration, scanner and board.")


def _calibration(path: Path) -> dict[str, Any]:
    calibration = load_calibration(path)
    at_home = camera_from_world(calibration)
    sheets = {
        sheet.name: {
            "alpha_deg": round(math.degrees(alpha_from_sheet(sheet)), 5),
            "lean_deg": round(math.degrees(math.asin(sheet.normal[2])), 5),
            "offset_mm": sheet.offset_mm,
            "plane_in_camera_abcd": [round(x, 9) for x in plane_in_camera(sheet, at_home)],
        }
        for sheet in calibration.lasers
    }
    parts = asdict(calibration)
    del parts["lasers"]
    centre = [round(float(x), 3) for x in optical_centre_world(calibration)]
    own = {"sha256": fingerprint(calibration), "optical_centre_world_mm": centre, "lasers": sheets}
    return {"kind": "calibration", **parts, **own}


def _scanner(path: Path) -> dict[str, Any]:
    scanner = load_scanner(path)
    translation = [round(float(t), 3) for t in translation_from_head(scanner.head)]
    derived = {"a_mm": round(lens_offset_a_mm(scanner.head), 3), "translation_mm": translation}
    return {"kind": "scanner", **asdict(scanner), "derived": derived}


def _recording(path: Path) -> dict[str, Any]:
    recording = open_recording(path)
    time_s = np.array([record.time_s for record in recording.frames])
    encoder = recording.encoder
    return {
        "kind": f"{recording.info.kind} recording",
        **asdict(recording.info),
        "scanner": recording.scanner.name,
        "machine_id": recording.scanner.machine_id,
        "frames": len(recording.frames),
        "frames_per_laser": dict(Counter(record.laser for record in recording.frames)),
        "frames_per_sweep": dict(Counter(record.sweep for record in recording.frames)),
        "duration_s": round(float(time_s.max() - time_s.min()), 3),
        "encoder_samples": len(encoder.time_s),
        "encoder_counts": [int(encoder.count.min()), int(encoder.count.max())],
        "problems": verify_recording(recording),
    }


def _print(content: dict[str, Any], indent: str) -> None:
    for key, value in content.items():
        if isinstance(value, dict):
            STDOUT.print(f"{indent}{key}")
            _print(value, indent + "  ")
        elif isinstance(value, list) and key == "problems":
            STDOUT.print(f"{indent}problems: {'none' if not value else ''}")
            for problem in value:
                STDOUT.print(f"{indent}  {problem}")
        else:
            STDOUT.print(f"{indent}{key}: {value}")
