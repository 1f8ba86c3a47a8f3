"""The last's frame inside a file: three points that move with the last, so it comes back standing as it was kept."""

from collections.abc import Mapping

import numpy as np

from footscan.coordinates import Floats
from footscan.shoelast.model import Shoelast

LAYER, SPAN_MM = "datum", 100.0
DATUM_POINTS: Mapping[str, tuple[float, float, float]] = {
    "datum_origin": (0.0, 0.0, 0.0),
    "datum_x": (SPAN_MM, 0.0, 0.0),
    "datum_z": (0.0, 0.0, SPAN_MM),
}
"""In the frame of the real last (y to the left): a millimetre file holds them as they stand here."""
_OFF_MM = 0.05
SAID = ("style", "size_eu", "fitting")
_KEY = "footscan_"


def said_of(shoelast: Shoelast) -> dict[str, str]:
    """What a file's texts say of a last, key -> text; what nobody knows is left out."""
    size = "" if shoelast.size_eu is None else f"{shoelast.size_eu:g}"
    values = (shoelast.style, size, shoelast.fitting)
    return {_KEY + name: value for name, value in zip(SAID, values, strict=True) if value}


def said_in(texts: Mapping[str, str]) -> dict[str, str]:
    """The same from all texts of a file, without the keys' prefix."""
    return {name: texts[_KEY + name] for name in SAID if texts.get(_KEY + name)}


def frame_from_points(points: Mapping[str, Floats]) -> tuple[Floats | None, tuple[str, ...]]:
    """A rigid 4x4 from a file to the frame of the real last, and words on datum points that are of no use.

    Args:
        points: Named points `(3,)` in mm as they lie in the file.

    Returns:
        None without all of `DATUM_POINTS`, or when they were moved apart.
    """
    if not all(name in points for name in DATUM_POINTS):
        return None, ()
    origin, x, z = (points[name] for name in DATUM_POINTS)
    along, up = (x - origin) / SPAN_MM, (z - origin) / SPAN_MM
    off = max(abs(np.linalg.norm(along) - 1.0), abs(np.linalg.norm(up) - 1.0), abs(float(along @ up)))
    if off * SPAN_MM > _OFF_MM:
        return None, (f"the file's datum points were moved apart by {off * SPAN_MM:.1f} mm and were not used",)
    along = along / np.linalg.norm(along)
    up = up - (up @ along) * along
    up = up / np.linalg.norm(up)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([along, np.cross(up, along), up])
    frame[:3, 3] = -frame[:3, :3] @ origin
    return frame, ()
