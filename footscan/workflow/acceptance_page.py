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


def draw_page(title: str, broken: list[str], parts: "list[BodyPart]", lines: list[str]) -> bytes:
    """The page as PDF: the verdict, residuals as colours from above and from the side, their spread, the figures."""
    figure = Figure(figsize=_A4_INCH)
    FigureCanvasAgg(figure)
    residual = np.concatenate([part.residual_mm for part in parts])
    xyz = np.concatenate([part.xyz_world for part in parts])
    laser = np.concatenate([part.laser for part in parts])
    bound = float(np.percentile(np.abs(residual), 99.0))
    figure.text(0.09, 0.955, title, fontsize=14)
    figure.text(
        *(0.09, 0.925, "NOT ACCEPTED" if broken else "ACCEPTED"),
        fontsize=18,
        weight="bold",
        color="tab:red" if broken else "tab:green",
    )
    above = figure.add_axes((0.1, 0.68, 0.34, 0.22))
    _draw_dots(above, xyz, residual, ("x", "y"), bound)
    dots = _draw_dots(figure.add_axes((0.52, 0.68, 0.34, 0.22)), xyz, residual, ("x", "z"), bound)
    bar = figure.add_axes((0.89, 0.69, 0.015, 0.2))
    figure.colorbar(dots, cax=bar).set_label("residual, mm (+ is outside or above)", fontsize=7)
    _draw_spread(figure.add_axes((0.1, 0.45, 0.8, 0.17)), residual, laser, bound)
    wrapped = "\n".join(part for line in lines for part in textwrap.wrap(line, 96, subsequent_indent="    ") or [""])
    figure.text(0.09, 0.39, wrapped, family="monospace", fontsize=8, va="top")
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
