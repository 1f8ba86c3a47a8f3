"""Pictures of lasts: foot and last in plan, clearance map, a customised last with its changes, thumbnails."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from footscan.coordinates import Floats, Ints
from footscan.shoelast.handed import mirrored
from footscan.shoelast.model import Shoelast
from footscan.shoelast.skin import BOTTOM, LastSkin, Sampling, skin_of
from footscan.workflow.lasts_colours import (
    CHANGED,
    CLEARANCE_MM,
    UNCHANGED,
    UNSEEN,
    change_colours,
    clearance_colours,
)
from footscan.workflow.lasts_views import View, draw_view, figure_png, save_figure, silhouette

_PLAN_SAMPLING = Sampling(240, 60, 8)
_PLAN_HEIGHT_MM = 70.0
_EDGE_STEPS = 721
_FOOT_GREY, _LAST_GREY = "0.82", "0.35"
_FOUR: tuple[View, ...] = ("above", "below", "lateral", "medial")
_WORDS: dict[View, str] = {
    "above": "From above",
    "below": "From below",
    "lateral": "Lateral side",
    "medial": "Medial side",
}


def save_plan_picture(path: Path, shoelast: Shoelast, foot_xyz: Floats, foot_faces: Ints, title: str) -> None:
    """The foot's outline against the last's bottom pattern and outline, in plan (paper, Fig. 12).

    Args:
        path: PNG to write.
        shoelast: The last.
        foot_xyz: `(n, 3)` the foot as posed and registered, in xyz_shoelast.
        foot_faces: `(m, 3)`.
        title: What stands above.

    Raises:
        StorageError: The place cannot be written.
    """
    side = shoelast.side
    figure, axes = _page(10.0, 5.2)
    skin, seat = skin_of(shoelast, _PLAN_SAMPLING), float(np.min(shoelast.bottom.net_mm[..., 2]))
    low = (foot_xyz[foot_faces][:, :, 2] < seat + _PLAN_HEIGHT_MM).all(axis=1)
    _fill(axes, mirrored(foot_xyz, side), foot_faces[low], side, _FOOT_GREY, "-")
    edge = mirrored(shoelast.upper.grid(np.linspace(0.0, 1.0, _EDGE_STEPS), np.zeros(1))[0], side)
    axes.fill(edge[:, 0], edge[:, 1], facecolor=_LAST_GREY, alpha=0.55, edgecolor="none", zorder=3)
    axes.plot(edge[:, 0], edge[:, 1], color="black", linewidth=1.4, zorder=5)
    _outline(axes, mirrored(skin.xyz_shoelast, side), skin.faces, side, "black", "--")
    if "ball_break_line" in shoelast.lines:
        line = mirrored(shoelast.lines["ball_break_line"], side)
        axes.plot(line[:, 0], line[:, 1], color="tab:orange", linewidth=1.0, zorder=6)
    figure.legend(handles=_plan_legend(), loc="outside lower center", ncol=4, fontsize=8)
    _label(axes, f"{title}\n{side}, in plan; foot below {_PLAN_HEIGHT_MM:.0f} mm over the lowest bottom", side)
    save_figure(figure, path)


def _plan_legend() -> list[Any]:
    return [
        Patch(facecolor=_FOOT_GREY, edgecolor="tab:red", label="foot"),
        Patch(facecolor=_LAST_GREY, alpha=0.55, label="bottom pattern of the last"),
        Patch(facecolor="none", edgecolor="black", linestyle="--", label="widest outline of the last"),
        Patch(facecolor="tab:orange", label="ball break line"),
    ]


def _fill(axes: Any, xyz: Floats, faces: Ints, side: str, grey: str, line: str) -> None:
    inside, extent = silhouette(xyz, faces, "above", side)
    x, y = _places(inside, extent)
    axes.contourf(x, y, inside.astype(np.float64), levels=(0.5, 2.0), colors=[grey], zorder=1)
    axes.contour(
        x, y, inside.astype(np.float64), levels=(0.5,), colors="tab:red", linewidths=1.2, linestyles=line, zorder=4
    )


def _outline(axes: Any, xyz: Floats, faces: Ints, side: str, colour: str, line: str) -> None:
    inside, extent = silhouette(xyz, faces, "above", side)
    x, y = _places(inside, extent)
    axes.contour(
        x, y, inside.astype(np.float64), levels=(0.5,), colors=colour, linewidths=0.9, linestyles=line, zorder=4
    )


def _places(inside: Any, extent: Floats) -> tuple[Floats, Floats]:
    rows, columns = inside.shape
    half_x, half_y = 0.5 * (extent[1] - extent[0]) / columns, 0.5 * (extent[3] - extent[2]) / rows
    return (
        np.linspace(extent[0] + half_x, extent[1] - half_x, columns),
        np.linspace(extent[2] + half_y, extent[3] - half_y, rows),
    )


def save_clearance_map(
    path: Path,
    xyz_shoelast: Floats,
    faces: Ints,
    clearance_mm: Floats,
    side: str,
    title: str,
    target_mm: float = 0.0,
) -> None:
    """Signed clearance on a skin from four sides, in the fixed colours from -6 to +10 mm with their legend.

    Args:
        path: PNG to write.
        xyz_shoelast: `(n, 3)` the skin (of the foot, or of the last).
        faces: `(m, 3)`.
        clearance_mm: `(n,)`, positive where the last stands away from the skin; NaN where it was never seen.
        side: Of the real foot.
        title: What stands above.
        target_mm: The clearance that is white.

    Raises:
        StorageError: The place cannot be written.
    """
    figure, panels = _four_panels()
    real = mirrored(xyz_shoelast, "left" if side == "left" else "right")
    colours = clearance_colours(clearance_mm, target_mm)
    for axes, view in zip(panels, _FOUR, strict=True):
        draw_view(axes, real, faces, colours, view, side)
        axes.set_title(_WORDS[view], fontsize=10)
        axes.set_axis_off()
    _clearance_legend(figure, target_mm)
    seen = clearance_mm[~np.isnan(clearance_mm)]
    said = f"{len(seen) / max(len(clearance_mm), 1):.0%} of the skin was seen and lies in the last: it is judged"
    if len(seen):
        low, high = np.percentile(seen, (5.0, 95.0))
        said += f"; seen skin: least {seen.min():.1f}, 5 % {low:.1f}, mean {seen.mean():.1f}, 95 % {high:.1f} mm"
    figure.suptitle(f"{title}\n{said}", fontsize=12)
    save_figure(figure, path)


def _clearance_legend(figure: Figure, target_mm: float) -> None:
    edges = np.linspace(*CLEARANCE_MM, 161)
    middles = 0.5 * (edges[1:] + edges[:-1])
    colours = ListedColormap(clearance_colours(middles, target_mm) / 255.0)
    scale = ScalarMappable(Normalize(*CLEARANCE_MM), colours)
    place = figure.add_axes((0.15, 0.085, 0.6, 0.025))
    bar = figure.colorbar(scale, cax=place, orientation="horizontal", extend="both")
    bar.set_ticks(np.arange(CLEARANCE_MM[0], CLEARANCE_MM[1] + 1.0, 2.0).tolist())
    bar.set_label(f"clearance (mm): red = the last is tighter than the skin, white = {target_mm:g}, blue = room")
    figure.legend(
        handles=[_patch(UNSEEN, "never seen, below the feather line or above the top line: not judged")],
        loc="lower right",
        fontsize=9,
    )


def _patch(colour: tuple[int, int, int], words: str) -> Patch:
    return Patch(facecolor="#" + bytes(colour).hex(), edgecolor="0.4", label=words)


def save_changed_picture(path: Path, skin: LastSkin, displacement_mm: Floats, side: str, title: str) -> None:
    """A customised last from four sides, what was changed in pale grey (paper, Fig. 13).

    Args:
        path: PNG to write.
        skin: Mesh of the customised last.
        displacement_mm: `(n,)` how far each of its vertices moved.
        side: Of the real last.
        title: What stands above.

    Raises:
        StorageError: The place cannot be written.
    """
    figure, panels = _four_panels()
    real = mirrored(skin.xyz_shoelast, "left" if side == "left" else "right")
    colours = change_colours(displacement_mm)
    for axes, view in zip(panels, _FOUR, strict=True):
        draw_view(axes, real, skin.faces, colours, view, side)
        axes.set_title(_WORDS[view], fontsize=10)
        axes.set_axis_off()
    handles = [_patch(CHANGED, "changed (moved more than 0.01 mm)"), _patch(UNCHANGED, "as the standard last")]
    figure.legend(handles=handles, loc="lower center", ncol=2, fontsize=10)
    moved = np.abs(displacement_mm) > 0.01
    most = (
        f"out {np.maximum(displacement_mm, 0.0).max():.1f}, in {np.maximum(-displacement_mm, 0.0).max():.1f} mm at most"
    )
    figure.suptitle(f"{title}\n{moved.mean():.0%} of the points changed; {most}", fontsize=12)
    save_figure(figure, path)


def thumbnail_png(shoelast: Shoelast) -> bytes:
    """A small picture of a last for the library: its lateral side, and its bottom below."""
    figure = Figure(figsize=(2.4, 2.2), dpi=100)
    FigureCanvasAgg(figure)
    skin = skin_of(shoelast, _PLAN_SAMPLING)
    real = mirrored(skin.xyz_shoelast, shoelast.side)
    colours = np.where((skin.patch == BOTTOM)[:, None], [120, 90, 62], UNCHANGED).astype(np.uint8)
    parts: tuple[tuple[tuple[float, float, float, float], View], ...] = (
        ((0.0, 0.42, 1.0, 0.58), "lateral"),
        ((0.0, 0.0, 1.0, 0.42), "below"),
    )
    for place, view in parts:
        axes = figure.add_axes(place)
        draw_view(axes, real, skin.faces, colours, view, shoelast.side, pixel_mm=1.0)
        axes.set_axis_off()
    return figure_png(figure)


def _four_panels() -> tuple[Figure, list[Any]]:
    figure = Figure(figsize=(12.0, 7.4), dpi=100)
    FigureCanvasAgg(figure)
    return figure, [figure.add_axes((x, y, 0.48, 0.33)) for y in (0.55, 0.16) for x in (0.01, 0.51)]


def _page(width: float, height: float) -> tuple[Figure, Any]:
    figure = Figure(figsize=(width, height), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.add_subplot()


def _label(axes: Any, title: str, side: str) -> None:
    axes.set_aspect("equal")
    axes.set_title(title, fontsize=11)
    axes.set_xlabel("x from the heel back (mm)")
    axes.set_ylabel("medial up (mm)" if side == "right" else "lateral up (mm)")
    axes.grid(visible=True, linewidth=0.3)
