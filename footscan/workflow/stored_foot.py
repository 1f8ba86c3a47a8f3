"""What a result folder says of the foot in it: side, load and missing parts, so that nobody has to repeat them."""

import json
from dataclasses import dataclass
from pathlib import Path

from footscan.coordinates import Side
from footscan.errors import InputError
from footscan.foot.wedge import FLAT_MM, Wedge, wedge_from_json


@dataclass(frozen=True)
class StoredSubject:
    """Side, load, missing parts and the wedge under the heel (`placed`: where `process` found it) as far as known."""

    side: Side | None = None
    load: str = "unknown"
    absent: tuple[str, ...] = ()
    wedge_mm: float | None = None
    placed: Wedge | None = None

    @property
    def wedge(self) -> Wedge | float | None:
        """The wedge as it was found by `process`, else its declared height; None when nobody said."""
        return self.wedge_mm if self.placed is None else self.placed


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
        placed = wedge_from_json(content.get("wedge"))
    except (ValueError, KeyError, TypeError) as err:
        raise InputError(f"{report} is damaged ({err}); process the recording again.") from err
    if (wedge_mm or 0.0) > FLAT_MM and placed is None:
        raise InputError(
            f"{report} was made before feet on a wedge were measured as such (wedge of {wedge_mm:g} mm); process the "
            "recording again."
        )
    known: Side | None = "right" if side == "right" else "left" if side == "left" else None
    return StoredSubject(known, load, absent, wedge_mm, placed)
