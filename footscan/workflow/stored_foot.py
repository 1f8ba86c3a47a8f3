"""What a result folder says of the foot in it: side, load and missing parts, so that nobody has to repeat them."""

import json
from dataclasses import dataclass
from pathlib import Path

from footscan.coordinates import Side
from footscan.errors import InputError


@dataclass(frozen=True)
class StoredSubject:
    """Side, load, missing parts and the wedge under the heel as far as known."""

    side: Side | None = None
    load: str = "unknown"
    absent: tuple[str, ...] = ()
    wedge_mm: float | None = None


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
        wedge = subject.get("wedge_mm")
        wedge_mm = None if wedge is None else float(wedge)
    except (ValueError, KeyError, TypeError) as err:
        raise InputError(f"{report} is damaged ({err}); process the recording again.") from err
    return StoredSubject("right" if side == "right" else "left" if side == "left" else None, load, absent, wedge_mm)
