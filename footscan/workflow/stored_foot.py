"""What a result folder says of the foot in it: side, load and missing parts, so that nobody has to repeat them."""

import json
from dataclasses import dataclass
from pathlib import Path

from footscan.coordinates import Side
from footscan.errors import InputError


@dataclass(frozen=True)
class StoredSubject:
    """Side, load and missing parts as far as known."""

    side: Side | None = None
    load: str = "unknown"
    absent: tuple[str, ...] = ()


def stored_subject(place: Path) -> StoredSubject:
    """Read scan.json beside a processed foot; a bare mesh file says nothing.

    Raises:
        InputError: scan.json is damaged.
    """
    report = place / "scan.json"
    if not report.is_file():
        return StoredSubject()
    try:
        content = json.loads(report.read_text(encoding="utf-8"))
        side, subject = content["side"], content["subject"]
        load, absent = str(subject["load"]), tuple(str(part) for part in subject["absent"])
    except (ValueError, KeyError, TypeError) as err:
        raise InputError(f"{report} is damaged ({err}); process the recording again.") from err
    return StoredSubject("right" if side == "right" else "left" if side == "left" else None, load, absent)
