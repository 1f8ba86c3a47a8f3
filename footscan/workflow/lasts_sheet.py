"""The last maker's sheet: a PDF at 1:1 on A3 or tiled A4, with a 100 mm check bar both ways on every page."""

import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from footscan.config.toml_file import write_whole
from footscan.coordinates import Floats
from footscan.shoelast.bottom_pattern import bottom_pattern
from footscan.shoelast.drawing import LastSection, cut_last
from footscan.shoelast.handed import mirrored, mirrored_mesh
from footscan.shoelast.mesh_out import solid_of
from footscan.shoelast.model import Shoelast
from footscan.shoelast.skin import Sampling, skin_of

Paper = Literal["a3", "a4"]
PAGES_MM: dict[Paper, tuple[float, float]] = {"a3": (420.0, 297.0), "a4": (210.0, 297.0)}
BAR_MM = 100.0

_EDGE_MM = 10.0
_STRIP_MM = 16.0
_SIDE_MM = 12.0
_OVERLAP_MM = 10.0
_GAP_MM = 8.0
_TABLE_MM = 84.0
_ROW_MM = 4.1
_INCH_MM = 25.4
_SAMPLING = Sampling(720, 160, 12)
_TAPES = ("ball", "waist", "instep", "short_heel", "long_heel")
_LABEL_MM = np.array([1.0, 1.5])
_LINE_COLOUR, _OUTLINE_COLOUR = "tab:blue", "red"


@dataclass(frozen=True)
class SheetHead:
    """What stands on every page beside the last's own name, side, size and fitting."""

    order: str
    date: str
    version: str


@dataclass(frozen=True)
class _Drawing:
    """Everything in mm on one large canvas; x to the toe, the plan below, the side view above."""

    plan: list[Floats]
    side: list[Floats]
    pattern: Floats
    lines: dict[str, tuple[Floats, Floats]]
    low: Floats
    size: Floats
    ground: float
    labels: dict[str, Floats]


def save_sheet(
    shoelast: Shoelast, dimensions: Mapping[str, tuple[float, str]], path: Path, head: SheetHead, paper: Paper = "a3"
) -> int:
    """Write the sheet.

    Args:
        shoelast: The last.
        dimensions: Name -> value and unit, as they shall stand in the table.
        path: PDF to write.
        head: What stands on every page.
        paper: a3 (landscape), or a4 (portrait pages to be glued on their crosses).

    Returns:
        The number of pages.

    Raises:
        StorageError: The place cannot be written.
    """
    drawing, cuts = _drawing(shoelast), cut_last(shoelast)
    free = np.array(PAGES_MM[paper]) - 2 * _EDGE_MM - [_SIDE_MM, _STRIP_MM]
    beside = paper == "a3" and drawing.size[0] + _TABLE_MM <= free[0]
    tiles = _tiles(drawing, free)
    count = len(tiles) + (0 if beside and len(tiles) == 1 else 1)
    stream = io.BytesIO()
    with PdfPages(stream, metadata={"Title": shoelast.name, "Creator": f"footscan {head.version}"}) as pages:
        for number, (low, words) in enumerate(tiles, 1):
            figure, axes = _page(paper)
            _draw_tile(axes, drawing, low, free, crosses=len(tiles) > 1)
            _frame(axes, paper, shoelast, head, f"page {number} of {count}{words}")
            if count == len(tiles):
                _draw_table(axes, dimensions, shoelast, cuts, _EDGE_MM + _SIDE_MM + free[0] - _TABLE_MM + 2.0)
            pages.savefig(figure)
        if count > len(tiles):
            figure, axes = _page(paper)
            _frame(axes, paper, shoelast, head, f"page {count} of {count}")
            _draw_table(axes, dimensions, shoelast, cuts, _EDGE_MM + _SIDE_MM + 5.0)
            pages.savefig(figure)
    write_whole(path, stream.getvalue())
    return count


def _drawing(shoelast: Shoelast) -> _Drawing:
    """Outlines, tapes and the pattern; the side view is lifted above the plan."""
    solid = solid_of(mirrored_mesh(skin_of(shoelast, _SAMPLING).mesh(), shoelast.side))
    plan = [np.asarray(ring) for ring in solid.project().to_polygons()]
    # Rows: picture right, picture up, towards the eye (which looks from -y, so that the toe points to the right).
    upright = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0]])
    side = [np.asarray(ring) for ring in solid.transform(upright).project().to_polygons()]
    flat, tall = np.vstack(plan), np.vstack(side)
    shift = np.array([0.0, flat[:, 1].max() + _GAP_MM - min(tall[:, 1].min(), 0.0)])
    lines = {}
    for name in (*(f"{tape}_tape" for tape in _TAPES), "ball_break_line"):
        if name in shoelast.lines:
            xyz = mirrored(shoelast.lines[name], shoelast.side)
            lines[name] = (xyz[:, :2], xyz[:, [0, 2]] + shift)
    side = [ring + shift for ring in side]
    everything = np.vstack([flat, *side])
    low = everything.min(axis=0) - _GAP_MM / 2
    size = np.ptp(everything, axis=0) + _GAP_MM
    labels = _tape_labels(lines) | _view_labels(shoelast, flat, shift)
    return _Drawing(plan, side, bottom_pattern(shoelast).plan, lines, low, size, float(shift[1]), labels)


def _tape_labels(lines: Mapping[str, tuple[Floats, Floats]]) -> dict[str, Floats]:
    """Names of the tapes at their tops in the side view; those that meet there share one text."""
    tops = {name: side[side[:, 1].argmax()] for name, (_, side) in lines.items() if name.endswith("_tape")}
    labels: dict[str, Floats] = {}
    for name, top in tops.items():
        near = [other for other, there in tops.items() if np.linalg.norm(there - top) < 4.0]
        if near[0] == name:
            labels[", ".join(each.removesuffix("_tape").replace("_", " ") for each in near)] = top + _LABEL_MM
    return labels


def _view_labels(shoelast: Shoelast, flat: Floats, shift: Floats) -> dict[str, Floats]:
    """What the views are, and which side of the plan is medial."""
    left, low, high = float(flat[:, 0].min()), float(flat[:, 1].min()), float(flat[:, 1].max())
    up, down = ("medial", "lateral") if shoelast.side == "right" else ("lateral", "medial")
    middle = 0.5 * (left + float(flat[:, 0].max()))
    return {
        "plan from above: bottom pattern (feather edge) black, widest outline red": np.array([left, low - 3.0]),
        "side view; broken line: ground": np.array([left, shift[1] + 1.0]),
        f"{up} side": np.array([middle, high - 20.0]),
        f"{down} side": np.array([middle, low + 18.0]),
    }


def _tiles(drawing: _Drawing, free: Floats) -> list[tuple[Floats, str]]:
    """Lower left corners (mm of the canvas) of the pages, and their names; neighbours overlap by 10 mm."""
    step = free - _OVERLAP_MM
    counts = np.maximum(np.ceil((drawing.size - _OVERLAP_MM) / step), 1).astype(int)
    spare = np.maximum(free - drawing.size, 0.0) * [0.0, 0.5]
    corners = [(drawing.low - spare + step * [i, j], i, j) for j in range(counts[1]) for i in range(counts[0])]
    many = len(corners) > 1
    words = " (column {}, row {} from below; lay the crosses on each other)"
    return [(corner, words.format(i + 1, j + 1) if many else "") for corner, i, j in corners]


def _page(paper: Paper) -> tuple[Figure, Any]:
    width, height = PAGES_MM[paper]
    figure = Figure(figsize=(width / _INCH_MM, height / _INCH_MM))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0.0, width)
    axes.set_ylim(0.0, height)
    axes.axis("off")
    return figure, axes


def _draw_tile(axes: Any, drawing: _Drawing, low: Floats, free: Floats, crosses: bool) -> None:
    """What of the canvas lies on this page; page = canvas - low + edge."""
    to_page = np.array([_EDGE_MM + _SIDE_MM, _EDGE_MM + _STRIP_MM]) - low
    frame = Rectangle((to_page + low).tolist(), *free.tolist(), transform=axes.transData, fill=False, linewidth=0.0)
    axes.add_patch(frame)

    def draw(xy: Floats, **style: Any) -> None:
        (line,) = axes.plot(*(xy + to_page).T, **style)
        line.set_clip_path(frame)

    for ring in (*drawing.plan, *drawing.side):
        draw(np.vstack([ring, ring[:1]]), color=_OUTLINE_COLOUR, linewidth=0.5)
    draw(drawing.pattern, color="black", linewidth=0.8)
    for name, (plan, side) in drawing.lines.items():
        style = {"color": "tab:orange" if name == "ball_break_line" else _LINE_COLOUR, "linewidth": 0.4}
        draw(plan, **style)
        draw(side, **style)
    right = drawing.low[0] + drawing.size[0]
    ground = np.array([[drawing.low[0], drawing.ground], [right, drawing.ground]])
    draw(ground, color="0.4", linewidth=0.4, linestyle=(0, (8, 3, 2, 3)))
    for words, place in drawing.labels.items():
        if np.all(place >= low) and np.all(place <= low + free):
            axes.text(*(place + to_page), words, fontsize=6)
    if crosses:
        _draw_crosses(draw, drawing, free)


def _draw_crosses(draw: Any, drawing: _Drawing, free: Floats) -> None:
    """Crosses of 8 mm in the overlaps, every 50 mm up and along, where both neighbours show them."""
    step = free - _OVERLAP_MM
    middle = drawing.low + step + 0.5 * _OVERLAP_MM
    spots = [(middle[0], y) for y in np.arange(drawing.low[1] + 10.0, drawing.low[1] + drawing.size[1], 50.0)]
    if drawing.size[1] > free[1]:
        spots += [(x, middle[1]) for x in np.arange(drawing.low[0] + 10.0, drawing.low[0] + drawing.size[0], 50.0)]
    for x, y in spots:
        draw(np.array([[x - 4.0, y], [x + 4.0, y]]), color="black", linewidth=0.3)
        draw(np.array([[x, y - 4.0], [x, y + 4.0]]), color="black", linewidth=0.3)


def _frame(axes: Any, paper: Paper, shoelast: Shoelast, head: SheetHead, words: str) -> None:
    """Both check bars and the two lines of text at the foot of the page."""
    left, foot = _EDGE_MM, _EDGE_MM
    for x, y, width, height in (
        (left + _SIDE_MM, foot, BAR_MM, 1.5),
        (left, foot + _STRIP_MM, 1.5, BAR_MM),
    ):
        axes.add_patch(Rectangle((x, y), width, height, color="black", linewidth=0.0))
    for mm in range(0, 101, 10):
        axes.plot([left + _SIDE_MM + mm] * 2, [foot + 1.5, foot + 3.0], color="black", linewidth=0.3)
        axes.plot([left + 1.5, left + 3.0], [foot + _STRIP_MM + mm] * 2, color="black", linewidth=0.3)
    axes.text(left + _SIDE_MM + BAR_MM + 2.0, foot, "100 mm: print at 100 %, measure both bars", fontsize=6)
    size = "" if shoelast.size_eu is None else f", EU {shoelast.size_eu:g}"
    fitting = f", fitting {shoelast.fitting}" if shoelast.fitting else ""
    order = f"{head.order}: " if head.order else ""
    first = f"{order}{shoelast.name}, {shoelast.side} last{size}{fitting}"
    second = f"{head.date}, footscan {head.version}, scale 1:1, mm, {words}"
    axes.text(left + _SIDE_MM, foot + 9.0, first, fontsize=9, fontweight="bold")
    axes.text(left + _SIDE_MM, foot + 5.0, second, fontsize=6.5)


def _draw_table(
    axes: Any, dimensions: Mapping[str, tuple[float, str]], shoelast: Shoelast, cuts: list[LastSection], left: float
) -> None:
    """Tapes with their places, the other dimensions, and the upright sections."""
    height = axes.get_ylim()[1] - _EDGE_MM - 4.0
    rows: list[tuple[str, ...]] = [("Tape", "mm", "at bottom", "at top")]
    for tape in _TAPES:
        value = dimensions.get(f"{tape}_girth")
        if value is not None:
            rows.append((f"{tape.replace('_', ' ')} girth", f"{value[0]:.1f}", *_places(shoelast, f"{tape}_tape")))
    rows += [("", "", "", ""), ("Dimension", "", "", "")]
    rows += [
        (name.replace("_", " "), f"{value:.1f}", unit, "")
        for name, (value, unit) in dimensions.items()
        if not name.endswith("_girth")
    ]
    rows += [("", "", "", ""), ("Upright section at", "tape mm", "width", "height")]
    for cut in cuts:
        part = cut.section
        tape, width, tall = part.hull_perimeter_mm, part.width_mm, part.height_mm
        rows.append((f"{cut.x_mm:.0f} mm", f"{tape:.1f}", f"{width:.1f}", f"{tall:.1f}"))
    for number, row in enumerate(rows):
        bold = "bold" if row[0] in {"Tape", "Dimension", "Upright section at"} else "normal"
        for text, x, side in zip(row, (0.0, 46.0, 64.0, 80.0), ("left", "right", "right", "right"), strict=True):
            axes.text(left + x, height - _ROW_MM * number, text, fontsize=6.5, ha=side, fontweight=bold)
    note = "Places in mm along the axis from the rearmost point of the back."
    axes.text(left, height - _ROW_MM * (len(rows) + 1), note, fontsize=5.5)


def _places(shoelast: Shoelast, line: str) -> tuple[str, str]:
    """Where a tape crosses the bottom and the top, along the axis from the rearmost point of the upper."""
    if line not in shoelast.lines:
        return "", ""
    xyz = shoelast.lines[line]
    back = float(shoelast.upper.net_mm[..., 0].min())
    return f"{xyz[xyz[:, 2].argmin(), 0] - back:.1f}", f"{xyz[xyz[:, 2].argmax(), 0] - back:.1f}"
