"""report.png: one page with the foot from above and from the side, sections, and the numbers."""

import io
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from footscan.config.toml_file import write_whole
from footscan.coordinates import Bools, Floats, Ints
from footscan.foot.measurements import Measurement, Measurements
from footscan.foot.section_files import cut_stack
from footscan.foot.shell import shell_from_mesh
from footscan.foot.skin_origin import Origin
from footscan.geometry.raster import front_facets

SOLE_SENTENCE = "Sole not measured, assumed flat: hatched skin was never seen, blue skin is bridged, grey is the cut."
WEDGE_SENTENCE = (
    "Scanned on a wedge of {height:g} mm and drawn so; measured, and cut across, with the rearfoot turned back."
)
_COLOURS = {
    Origin.SEEN: (0.93, 0.76, 0.62),
    Origin.BRIDGED: (0.62, 0.70, 0.85),
    Origin.ASSUMED_SOLE: (0.72, 0.72, 0.72),
}
_SHARES = (0.16, 0.35, 0.5, 0.62, 0.73)
_LIGHT = np.array([0.25, 0.35, 0.9]) / np.linalg.norm([0.25, 0.35, 0.9])
_PIXEL_MM = 0.4
_COLUMNS = 102


def save_report(
    mesh: trimesh.Trimesh, measured: Measurements, path: Path, title: str, notes: Sequence[str] = ()
) -> None:
    """Draw the page; the mesh is in the coordinates the measurements were taken in. Notes (the verdict) come first."""
    figure = Figure(figsize=(15.5, 10.0), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 0.85), height_ratios=(1.0, 0.85))
    turn, shift = measured.foot_from_input[:3, :3], measured.foot_from_input[:3, 3]
    xyz_foot = np.asarray(mesh.vertices) @ turn.T + shift
    faces, origin = np.asarray(mesh.faces), _face_origin(mesh)
    _draw_foot(figure.add_subplot(grid[0, 0]), xyz_foot, faces, origin, (0, 1, 2), "From above")
    _draw_foot(figure.add_subplot(grid[1, 0]), xyz_foot, faces, origin, (0, 2, 1), "Medial side")
    _draw_sections(figure.add_subplot(grid[1, 1]), mesh, measured)
    _write_numbers(figure.add_subplot(grid[0, 1]), measured, notes)
    stood = "" if measured.wedge is None else f", on a wedge of {measured.wedge.height_mm:g} mm"
    figure.suptitle(f"{title} - {measured.side} foot, axis {measured.axis}, load {measured.load}{stood}", fontsize=13)
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    write_whole(path, stream.getvalue())


def _face_origin(mesh: trimesh.Trimesh) -> Ints:
    origin = mesh.vertex_attributes.get("origin")
    if origin is None:
        return np.zeros(len(mesh.faces), dtype=np.int64)
    return np.asarray(origin, dtype=np.int64)[mesh.faces].max(axis=1)


def _draw_foot(axes: Any, xyz: Floats, faces: Ints, origin: Ints, order: tuple[int, int, int], title: str) -> None:
    """A shaded picture; `order` is horizontal, vertical, towards the eye."""
    horizontal, vertical, _ = order
    low, high = xyz.min(axis=0) - 6.0, xyz.max(axis=0) + 6.0
    corners = xyz[faces]
    rows, columns = np.ceil((high - low)[[vertical, horizontal]] / _PIXEL_MM).astype(int)
    facet = front_facets(corners[:, :, list(order)], low[[horizontal, vertical]], _PIXEL_MM, (int(rows), int(columns)))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    base = np.array([_COLOURS[Origin(min(kind, 2))] for kind in range(4)])[origin]
    colour = np.clip(base * (0.45 + 0.55 * np.abs(normal @ _LIGHT))[:, None], 0.0, 1.0)
    picture = np.where((facet >= 0)[..., None], colour[facet], 1.0)
    _hatch(picture, (facet >= 0) & (origin[facet] == Origin.ASSUMED_SOLE))
    extent = (low[horizontal], high[horizontal], low[vertical], high[vertical])
    axes.imshow(picture, origin="lower", extent=extent, aspect="equal", interpolation="antialiased")
    axes.set_title(title, fontsize=10)
    axes.set_xlabel(f"{'xyz'[horizontal]} (mm)")
    axes.set_ylabel(f"{'xyz'[vertical]} (mm)")


def _hatch(picture: Floats, assumed: Bools) -> None:
    row, column = np.nonzero(assumed)
    line = (row + column) % 8 < 2
    picture[row[line], column[line]] *= 0.45


def _draw_sections(axes: Any, mesh: trimesh.Trimesh, measured: Measurements) -> None:
    for named in cut_stack(shell_from_mesh(mesh), measured, _SHARES):
        for number, line in enumerate(named.section.polylines):
            yz = measured.frame.to_foot(np.asarray(line))[:, 1:]
            label = f"{100 * named.share:.0f} %: {named.section.width_mm:.1f} mm wide" if number == 0 else None
            axes.plot(yz[:, 0], yz[:, 1], linewidth=1.0, label=label)
    axes.axhspan(-4.0, 0.0, facecolor="0.85", hatch="///", edgecolor="0.6", linewidth=0.0)
    axes.set_aspect("equal")
    axes.set_title("Sections across the axis, share of the length from the heel", fontsize=10)
    axes.set_xlabel("y, medial (mm)")
    axes.set_ylabel("z (mm)")
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.02, 0.5))


def _write_numbers(axes: Any, measured: Measurements, said: Sequence[str]) -> None:
    axes.axis("off")
    lines = [_row(name, value) for name, value in measured.measurements.items() if value.value is not None]
    header = f"{'measurement':27}{'value':>9} {'unit':4} {'interval':>17}  mark"
    wedge = [] if measured.wedge is None else [WEDGE_SENTENCE.format(height=measured.wedge.height_mm)]
    notes = [SOLE_SENTENCE, *wedge, *(f"? {question}" for question in measured.questions)]
    sizes = ", ".join(f"{name} {value}" for name, value in measured.sizes.items() if isinstance(value, float | int))
    legend = "mark: ok = reliable; ? = see the reason in measurements.json; ! = unusual against the norm"
    ends = [f"Sizes (indicative): {sizes}", *notes, legend]
    text = [*_wrapped(said), *([""] if said else []), header, "-" * 66, *lines, "-" * 66, *_wrapped(ends)]
    axes.text(0.0, 1.0, "\n".join(text), family="monospace", fontsize=8.0, va="top", transform=axes.transAxes)


def _wrapped(notes: Sequence[str]) -> list[str]:
    """Lines that fit; Matplotlib's own wrapping measures every word again and again and takes seconds."""
    return [line for note in notes for line in textwrap.wrap(note, _COLUMNS, subsequent_indent="  ")]


def _row(name: str, value: Measurement) -> str:
    interval = "" if value.interval is None else f"{value.interval[0]:.1f} .. {value.interval[1]:.1f}"
    mark = ("ok" if value.reliable else "?") + ("!" if value.unusual else "")
    digits = 3 if value.unit == "1" else 1
    return f"{name.replace('_', ' '):27}{value.value:9.{digits}f} {value.unit:4} {interval:>17}  {mark}"
