"""One page of an acceptance test: what was seen, how far off, and the figures."""

import io
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from footscan.workflow.accept import BodyPart

_MOST_DOTS = 6000
_A4_INCH = (8.27, 11.69)


def draw_page(title: str, parts: "list[BodyPart]", lines: list[str]) -> bytes:
    """The page as PDF: residuals as colours from above and from the side, their distribution, and the figures."""
    figure = Figure(figsize=_A4_INCH, layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(3, 2, height_ratios=(1.0, 0.8, 0.9))
    residual = np.concatenate([part.residual_mm for part in parts])
    xyz = np.concatenate([part.xyz_world for part in parts])
    laser = np.concatenate([part.laser for part in parts])
    bound = float(np.percentile(np.abs(residual), 99.0))
    _draw_dots(figure.add_subplot(grid[0, 0]), xyz, residual, ("x", "y"), bound)
    dots = _draw_dots(figure.add_subplot(grid[0, 1]), xyz, residual, ("x", "z"), bound)
    figure.colorbar(dots, ax=figure.axes, shrink=0.7, label="residual, mm (+ is outside or above)")
    _draw_spread(figure.add_subplot(grid[1, :]), residual, laser, bound)
    text = figure.add_subplot(grid[2, :])
    text.axis("off")
    wrapped = "\n".join(part for line in lines for part in textwrap.wrap(line, 100, subsequent_indent="    "))
    text.text(0.0, 1.0, wrapped, family="monospace", fontsize=7.5, va="top", transform=text.transAxes)
    figure.suptitle(title, fontsize=13)
    stream = io.BytesIO()
    figure.savefig(stream, format="pdf")
    return stream.getvalue()


def _draw_dots(axes: Any, xyz: Any, residual: Any, axis: tuple[str, str], bound: float) -> Any:
    """Points coloured by residual, seen along the third axis."""
    step = max(1, len(xyz) // _MOST_DOTS)
    across, up = ("xyz".index(name) for name in axis)
    dots = axes.scatter(
        xyz[::step, across], xyz[::step, up], c=residual[::step], s=1.5, cmap="coolwarm", vmin=-bound, vmax=bound
    )
    axes.set_aspect("equal")
    axes.set_xlabel(f"{axis[0]} (mm)")
    axes.set_ylabel(f"{axis[1]} (mm)")
    return dots


def _draw_spread(axes: Any, residual: Any, laser: Any, bound: float) -> None:
    """Distribution of the residuals of each laser."""
    edges = np.linspace(-2.0 * bound, 2.0 * bound, 81)
    for code, (name, colour) in enumerate((("right laser", "tab:red"), ("left laser", "tab:blue"))):
        axes.hist(residual[laser == code], bins=edges, histtype="step", label=name, color=colour)
    axes.set_xlabel("residual, mm")
    axes.set_ylabel("points")
    axes.legend(fontsize=8)
