"""Text cut into the cone top of a last: real geometry of the mesh, of one depth everywhere."""

from dataclasses import dataclass

import manifold3d
import numpy as np
import trimesh
from matplotlib import path as outlines
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.textpath import TextPath

from footscan.coordinates import Bools, Floats, Side
from footscan.errors import InputError
from footscan.shoelast.handed import mirrored
from footscan.shoelast.mesh_out import mesh_of_solid, solid_of
from footscan.shoelast.model import Shoelast

DEPTH_MM = 0.6
CAP_HEIGHTS_MM = (2.5, 7.0)
"""Smallest letters that a 1.5 mm mill cuts and people read, and the largest that are of use."""

_EDGE_MM = 3.0
_STEP_MM = 0.25
_STEEPEST = np.cos(np.radians(35.0))
_FONT = FontProperties(family="DejaVu Sans", weight="bold")  # comes with matplotlib, so all computers cut the same


@dataclass(frozen=True)
class Engraving:
    """What was cut: the text, its capitals' height (mm), and the volume taken away (mm3)."""

    text: str
    cap_height_mm: float
    volume_mm3: float


@dataclass(frozen=True)
class _Seat:
    """The plane of the cone top: `frame` columns are along the text, up the letters, outward; `outline` `(n, 2)`."""

    origin: Floats
    frame: Floats
    outline: Floats
    relief_mm: float


def engrave(mesh: trimesh.Trimesh, shoelast: Shoelast, text: str) -> tuple[trimesh.Trimesh, Engraving]:
    """Cut text into the cone top, reading from heel to toe, as large as fits 3 mm inside its edge.

    Args:
        mesh: The last's closed body, real handedness.
        shoelast: Whose cone top tells where.
        text: One line of printable characters.

    Raises:
        InputError: The text is empty or has characters the font lacks, it does not fit, or the cone top is no seat.
        MeshError: The mesh is not closed.
    """
    words = " ".join(text.split())
    flat = _letters(words)
    seat = _seat(shoelast, shoelast.side)
    size, place = _fit(words, flat, seat)
    letters = [size * ring + place for ring in flat]
    solid = solid_of(mesh)
    cut = solid - _cutter(letters, seat, solid)
    taken = solid.volume() - cut.volume()
    return mesh_of_solid(cut), Engraving(words, float(size * _cap_height()), float(taken))


def _letters(words: str) -> list[Floats]:
    """Rings `(n, 2)` of the letters, the text about 1 high, centred."""
    if not words:
        raise InputError("the text to engrave is empty; give a short order number, side and size.")
    known = get_font(findfont(_FONT)).get_charmap()
    missing = sorted({letter for letter in words if ord(letter) not in known})
    if missing:
        raise InputError(f"the engraving font has no {' '.join(map(repr, missing))}; use letters, digits and signs.")
    path = TextPath((0.0, 0.0), words, size=1.0, prop=_FONT)
    rings = [np.asarray(ring, dtype=np.float64) for ring in path.to_polygons(closed_only=True)]
    middle = 0.5 * (np.vstack(rings).min(axis=0) + np.vstack(rings).max(axis=0))
    return [ring - middle for ring in rings]


def _cap_height() -> float:
    """Height of a capital in the units of the rings."""
    capital = TextPath((0.0, 0.0), "H", size=1.0, prop=_FONT).vertices
    return float(np.ptp(np.asarray(capital)[:, 1]))


def _seat(shoelast: Shoelast, side: Side) -> _Seat:
    """The plane fitted to the cone top, its axes and its outline."""
    share = np.linspace(0.0, 1.0, 121)
    grid = mirrored(shoelast.cone_top.grid(share, share[::6]), side)
    xyz = grid.reshape(-1, 3)
    origin = xyz.mean(axis=0)
    normal = np.linalg.svd(xyz - origin, full_matrices=False)[2][2]
    normal = normal if normal[2] > 0 else -normal
    if normal[2] < _STEEPEST:
        tilt = np.degrees(np.arccos(normal[2]))
        raise InputError(f"the cone top leans {tilt:.0f} degrees, at most 35 can be engraved; leave the text away.")
    across = np.cross(normal, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    frame = np.column_stack([np.cross(across, normal), across, normal])
    outline = np.vstack([grid[:, -1], grid[::-1, 0]])
    relief = np.abs((xyz - origin) @ normal).max()
    return _Seat(origin, frame, (outline - origin) @ frame[:, :2], float(relief))


def _fit(words: str, flat: list[Floats], seat: _Seat) -> tuple[float, Floats]:
    """The largest size, and the place, at which the whole text lies 3 mm inside the outline."""
    box = np.ptp(np.vstack(flat), axis=0)
    free, low = _free(seat.outline)
    smallest, largest = (height / _cap_height() for height in CAP_HEIGHTS_MM)
    for size in np.linspace(largest, smallest, 46):
        cells = np.maximum(np.ceil(size * box / _STEP_MM).astype(int) + 1, 1)
        place = _window(free, cells)
        if place is not None:
            return float(size), low + _STEP_MM * (place + 0.5 * (cells - 1))
    extent = np.ptp(seat.outline, axis=0)
    raise InputError(
        f"{words!r} does not fit on the cone top of {extent[0]:.0f} x {extent[1]:.0f} mm with letters of at least "
        f"{CAP_HEIGHTS_MM[0]} mm; shorten the text."
    )


def _free(outline: Floats) -> tuple[Bools, Floats]:
    """Cells of a raster `(x, y)` that lie inside the outline and away from it, and the place of the first."""
    ring = manifold3d.CrossSection([outline.tolist()], manifold3d.FillRule.NonZero).offset(
        -_EDGE_MM, manifold3d.JoinType.Round
    )
    low, high = outline.min(axis=0), outline.max(axis=0)
    counts = np.ceil((high - low) / _STEP_MM).astype(int) + 1
    places = low + _STEP_MM * np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1)
    inside = np.zeros(tuple(counts), dtype=np.bool_)
    for polygon in ring.to_polygons():
        inside ^= _inside(places, np.asarray(polygon, dtype=np.float64))
    return inside, low


def _inside(places: Floats, ring: Floats) -> Bools:
    """Whether places `(..., 2)` lie in a ring `(n, 2)` (even-odd)."""
    return outlines.Path(ring).contains_points(places.reshape(-1, 2)).reshape(places.shape[:-1])


def _window(free: Bools, cells: Floats) -> Floats | None:
    """The first cell of the most central window of `cells` that is wholly free, or None."""
    if np.any(cells > free.shape):
        return None
    total = np.pad(np.cumsum(np.cumsum(free, axis=0), axis=1), ((1, 0), (1, 0)))
    m, n = int(cells[0]), int(cells[1])
    count = total[m:, n:] - total[:-m, n:] - total[m:, :-n] + total[:-m, :-n]
    whole = np.argwhere(count == m * n)
    if not len(whole):
        return None
    centre = np.argwhere(free).mean(axis=0) - 0.5 * np.array([m - 1, n - 1])
    return whole[np.linalg.norm(whole - centre, axis=1).argmin()].astype(np.float64)


def _cutter(letters: list[Floats], seat: _Seat, solid: manifold3d.Manifold) -> manifold3d.Manifold:
    """Prisms of the letters, bounded below by the last's own surface let down by the depth."""
    reach = seat.relief_mm + 1.0 + DEPTH_MM
    prism = manifold3d.CrossSection([ring.tolist() for ring in letters], manifold3d.FillRule.EvenOdd).extrude(2 * reach)
    matrix = np.column_stack([seat.frame, seat.origin - reach * seat.frame[:, 2]])
    down = (-DEPTH_MM * seat.frame[:, 2]).tolist()
    return prism.transform(matrix) - solid.translate(down)
