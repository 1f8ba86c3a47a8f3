"""Shaded views of meshes from six sides, as matplotlib shows them, and writing a figure."""

import io
from pathlib import Path
from typing import Any, Literal

import numpy as np

from footscan.config.toml_file import write_whole
from footscan.coordinates import Bools, Bytes, Floats, Ints
from footscan.geometry.raster import front_facets

View = Literal["above", "below", "medial", "lateral", "front", "back"]

_LIGHT = np.array([-0.35, 0.45, 0.82]) / np.linalg.norm([-0.35, 0.45, 0.82])
_AMBIENT = 0.6
_GAIN = 1.06
_MARGIN_MM = 6.0


def view_axes(view: View, side: str) -> Floats:
    """Rows: right, up and towards the eye, in real coordinates (x to the toe, y left, z up)."""
    medial = 1.0 if side == "right" else -1.0
    away = {"medial": medial, "lateral": -medial}
    if view in away:
        return np.array([[-away[view], 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, away[view], 0.0]])
    rows = {
        "above": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "below": [[medial, 0, 0], [0, -medial, 0], [0, 0, -1]],
        "front": [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
        "back": [[0, -1, 0], [0, 0, 1], [-1, 0, 0]],
    }
    return np.array(rows[view], dtype=np.float64)


def draw_view(
    axes: Any, xyz: Floats, faces: Ints, colours: Bytes, view: View, side: str, pixel_mm: float = 0.4
) -> None:
    """Show a shaded mesh.

    Args:
        axes: Of matplotlib.
        xyz: `(n, 3)` real coordinates (mm).
        faces: `(m, 3)`.
        colours: `(n, 3)` per vertex or `(m, 3)` per face; a face takes the mean of its corners.
        view: From where.
        side: Of the real body, for medial and lateral.
        pixel_mm: Size of a picture element.
    """
    turned = xyz @ view_axes(view, side).T
    facet, extent = _raster(turned, faces, pixel_mm)
    corners = turned[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    per_face = colours if len(colours) == len(faces) else colours[faces].mean(axis=1)
    lit = np.clip(per_face / 255.0 * (_AMBIENT + (1.0 - _AMBIENT) * np.abs(normal @ _LIGHT))[:, None] * _GAIN, 0.0, 1.0)
    picture = np.where((facet >= 0)[..., None], lit[facet], 1.0)
    axes.imshow(picture, origin="lower", extent=extent, aspect="equal", interpolation="antialiased")


def silhouette(xyz: Floats, faces: Ints, view: View, side: str, pixel_mm: float = 0.4) -> tuple[Bools, Floats]:
    """Where a mesh is in front of the paper: `(rows, columns)`, and the extent (left, right, low, high) in mm."""
    facet, extent = _raster(xyz @ view_axes(view, side).T, faces, pixel_mm)
    return facet >= 0, np.array(extent)


def _raster(turned: Floats, faces: Ints, pixel_mm: float) -> tuple[Ints, tuple[float, float, float, float]]:
    low, high = turned[:, :2].min(axis=0) - _MARGIN_MM, turned[:, :2].max(axis=0) + _MARGIN_MM
    columns, rows = np.ceil((high - low) / pixel_mm).astype(int)
    facet = front_facets(turned[faces], low, pixel_mm, (int(rows), int(columns)))
    right, top = low + pixel_mm * np.array([columns, rows])
    return facet, (float(low[0]), float(right), float(low[1]), float(top))


def save_figure(figure: Any, path: Path) -> None:
    """Write a figure as PNG, whole or not at all.

    Raises:
        StorageError: The place cannot be written.
    """
    write_whole(path, figure_png(figure))


def figure_png(figure: Any) -> bytes:
    """A figure as PNG."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    return stream.getvalue()
