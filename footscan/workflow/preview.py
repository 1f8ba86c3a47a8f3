"""preview.png: the aggregated stripes as in the paper's Fig. 2, and the cloud from above and from the side."""

import io
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from footscan.config.toml_file import write_whole
from footscan.coordinates import LASER_NAMES, Floats
from footscan.workflow.process import ScanResult

_COLOURS = {"right": (0.85, 0.25, 0.10), "left": (0.10, 0.35, 0.80)}
_CELL_MM = 0.5


def save_preview(result: ScanResult, path: Path) -> None:
    """Draw the three pictures and write them as one PNG."""
    figure = Figure(figsize=(15, 5.2), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    stripes, top, side = figure.subplots(1, 3, width_ratios=(1.15, 1.0, 1.0))
    _draw_stripes(stripes, result)
    _draw_cloud(top, result, 0, 1, "Seen from above")
    _draw_cloud(side, result, 0, 2, "Seen from the side")
    top.legend(handles=_legend(result), loc="upper right", fontsize=8)
    side_name, kept = result.recording.info.side, len(result.cloud)
    figure.suptitle(
        f"{result.recording.folder.name}: {side_name} foot, {kept} points, threshold {result.sweep.threshold}"
    )
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    write_whole(path, stream.getvalue())


def _draw_stripes(axes: Any, result: ScanResult) -> None:
    picture = np.zeros((*result.sweep.brightest["right"].shape, 3))
    for name in LASER_NAMES:
        grey = np.sqrt(result.sweep.brightest[name] / 255.0)
        picture = np.maximum(picture, grey[..., None] * (0.35 + 0.65 * np.array(_COLOURS[name])))
    axes.imshow(np.clip(picture, 0.0, 1.0))
    axes.set_title("All stripes in one picture (camera's view)", fontsize=10)
    axes.set_xlabel("u (px)")
    axes.set_ylabel("v (px)")


def _draw_cloud(axes: Any, result: ScanResult, horizontal: int, vertical: int, title: str) -> None:
    xyz_world = result.cloud.xyz_world
    low, high = xyz_world.min(axis=0) - 5.0, xyz_world.max(axis=0) + 5.0
    picture = np.ones((*np.ceil((high - low)[[vertical, horizontal]] / _CELL_MM).astype(int), 3))
    for code, name in enumerate(LASER_NAMES):
        density = _density(xyz_world[result.cloud.laser == code], low, picture.shape, horizontal, vertical)
        picture -= density[..., None] * (1.0 - np.array(_COLOURS[name]))
    extent = (low[horizontal], high[horizontal], low[vertical], high[vertical])
    axes.imshow(np.clip(picture, 0.0, 1.0), origin="lower", extent=extent, aspect="equal", interpolation="nearest")
    axes.set_title(title, fontsize=10)
    axes.set_xlabel(f"{'xyz'[horizontal]} (mm)")
    axes.set_ylabel(f"{'xyz'[vertical]} (mm)")


def _density(xyz: Floats, low: Floats, shape: tuple[int, ...], horizontal: int, vertical: int) -> Floats:
    column = ((xyz[:, horizontal] - low[horizontal]) / _CELL_MM).astype(np.int64)
    row = ((xyz[:, vertical] - low[vertical]) / _CELL_MM).astype(np.int64)
    count = np.bincount(row * shape[1] + column, minlength=shape[0] * shape[1]).reshape(shape[:2])
    return np.minimum(np.sqrt(count / 3.0), 1.0)


def _legend(result: ScanResult) -> list[Any]:
    counts = [int((result.cloud.laser == code).sum()) for code in range(2)]
    return [
        Patch(color=_COLOURS[name], label=f"{name} laser, {count} points")
        for name, count in zip(LASER_NAMES, counts, strict=True)
    ]
