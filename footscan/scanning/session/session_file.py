"""`session.json` beside a recording: how its scan ended, what was planned, and what became of every frame."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from footscan.config.toml_file import write_whole
from footscan.errors import RecordingError
from footscan.scanning.session.plan import ScanPlan
from footscan.scanning.session.states import FrameCount

SESSION_FILE = "session.json"
COMPLETE = "complete"


def save_outcome(folder: Path, outcome: str, plan: ScanPlan, frames: FrameCount | None = None) -> None:
    """Write how a scan ended.

    Raises:
        StorageError: The place cannot be written.
    """
    report = {
        "format": "footscan-session/1",
        "outcome": outcome,
        "profile": plan.profile,
        "alternating": plan.alternating,
        "duration_s": round(plan.duration_s, 3),
        "speed_deg_per_s": round(float(np.rad2deg(plan.speed_rad_s)), 4),
        "stripe_spacing_mm": round(plan.spacing_mm, 3),
        "frames": None if frames is None else asdict(frames),
    }
    write_whole(folder / SESSION_FILE, (json.dumps(report, indent=1) + "\n").encode())


def load_outcome(folder: Path) -> str | None:
    """How the scan beside a recording ended; None if nothing was written about it.

    Raises:
        RecordingError: The file cannot be understood.
    """
    try:
        return str(json.loads((folder / SESSION_FILE).read_text(encoding="utf-8"))["outcome"])
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError) as err:
        raise RecordingError(
            f"{folder / SESSION_FILE} cannot be read ({err}); remove it, the frames are whole."
        ) from err
