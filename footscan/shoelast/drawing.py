"""A last as a DXF drawing (mm, real side): sections in space at stated planes, and the bottom pattern."""

import io
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from footscan.config.toml_file import write_whole
from footscan.coordinates import Floats
from footscan.foot.sections import Section, measure_cut
from footscan.foot.shell import Shell
from footscan.shoelast.bottom_pattern import BottomPattern, bottom_pattern
from footscan.shoelast.chord import breaks_within
from footscan.shoelast.handed import DATUM, mirrored_mesh
from footscan.shoelast.model import Shoelast
from footscan.shoelast.skin import skin_of

SPACING_MM = 20.0
BESIDE_MM = 160.0
"""How far beside the plan (towards -y) the developed pattern is drawn."""
_CHORD_MM = 0.05
_MILLIMETRES = 4
_TEXT_MM = 4.0
_TEXT_COLUMNS = 80


@dataclass(frozen=True)
class LastSection:
    """One cut: `x_mm` from the rearmost point, and what was measured there (real side)."""

    x_mm: float
    section: Section


def cut_last(shoelast: Shoelast, spacing_mm: float = SPACING_MM) -> list[LastSection]:
    """Cut a last upright across its axis every `spacing_mm` from the rearmost point."""
    fine, _ = breaks_within(shoelast, _CHORD_MM)
    mesh = mirrored_mesh(skin_of(shoelast, fine).mesh(), shoelast.side)
    shell = Shell(np.asarray(mesh.vertices), np.ascontiguousarray(mesh.faces))
    back, front = float(shell.xyz[:, 0].min()), float(shell.xyz[:, 0].max())
    ahead = np.array([1.0, 0.0, 0.0])
    places = np.arange(spacing_mm, front - back, spacing_mm)
    return [LastSection(x, measure_cut(shell, np.array([back + x, 0.0, 0.0]), ahead)) for x in places.tolist()]


def save_last_dxf(shoelast: Shoelast, path: Path, note: str, spacing_mm: float = SPACING_MM) -> None:
    """Write the drawing.

    Layers: SECTION_0020 and so on (closed 3-D polylines at their place, x in mm from the rearmost point), BOTTOM_PLAN
    (feather edge from above), BOTTOM_MIDDLE, BOTTOM_DEVELOPED (laid flat, 160 mm beside the plan), one layer for every
    named line of the last, TEXT.

    Raises:
        StorageError: The place cannot be written.
    """
    pattern = bottom_pattern(shoelast)
    layers: dict[str, Sequence[Floats]] = {
        f"SECTION_{cut.x_mm:04.0f}": cut.section.polylines for cut in cut_last(shoelast, spacing_mm)
    }
    layers |= {"BOTTOM_PLAN": [_level(pattern.plan)], "BOTTOM_MIDDLE": [_level(pattern.middle)]}
    layers["BOTTOM_DEVELOPED"] = [_level(pattern.developed - [0.0, BESIDE_MM])]
    real = np.array([1.0, -1.0 if shoelast.side == "left" else 1.0, 1.0])
    layers |= {name.upper(): [line * real] for name, line in shoelast.lines.items()}
    write_whole(path, dxf_of(layers, _labels(shoelast, pattern, note)).encode())


def _level(xy: Floats) -> Floats:
    return np.column_stack([xy, np.zeros(len(xy))])


def _labels(shoelast: Shoelast, pattern: BottomPattern, note: str) -> list[tuple[str, tuple[float, float]]]:
    laid = (
        f"Bottom developed along its middle ({pattern.length_mm:.1f} mm) {BESIDE_MM:.0f} mm beside the plan, "
        f"its edge {pattern.edge_stretch:+.1%} against the feather edge"
    )
    texts = [f"{note}, {shoelast.side}; mm", *textwrap.wrap(DATUM, _TEXT_COLUMNS), *textwrap.wrap(laid, _TEXT_COLUMNS)]
    top = float(pattern.developed[:, 1].min()) - BESIDE_MM - 12.0
    return [(text, (0.0, top - 2.0 * _TEXT_MM * k)) for k, text in enumerate(texts)]


def dxf_of(layers: Mapping[str, Sequence[Floats]], labels: Sequence[tuple[str, tuple[float, float]]] = ()) -> str:
    """A DXF (R2000, unit mm) of 3-D polylines.

    Args:
        layers: Name -> lines `(n, 3)`; one that ends where it begins is closed and its end not repeated.
        labels: Texts and their places.
    """
    import ezdxf  # noqa: PLC0415  half a second that other commands need not wait for

    drawing: Any = ezdxf.new("R2000", setup=True)  # pyright: ignore[reportPrivateImportUsage]
    drawing.units = _MILLIMETRES
    space = drawing.modelspace()
    for number, (name, lines) in enumerate(layers.items()):
        drawing.layers.add(name, color=1 + number % 6)
        for line in lines:
            closed = len(line) > 2 and bool(np.allclose(line[0], line[-1], atol=1e-9))
            corners = (line[:-1] if closed else line).tolist()
            space.add_polyline3d(corners, close=closed, dxfattribs={"layer": name})
    for text, place in labels:
        space.add_text(text, height=_TEXT_MM, dxfattribs={"layer": "TEXT"}).set_placement(place)
    stream = io.StringIO()
    drawing.write(stream)
    return stream.getvalue()
