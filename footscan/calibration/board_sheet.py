"""The printable board: a PDF at 1:1 with rulers along both edges, to check the print with a calliper."""

import io
from typing import Any

import cv2
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from footscan.calibration.charuco import dictionary_number
from footscan.config import Board
from footscan.coordinates import Bools
from footscan.errors import InputError

_PAGES_MM = {"A4": (297.0, 210.0), "A3": (420.0, 297.0), "A2": (594.0, 420.0), "A1": (841.0, 594.0)}
_EDGE_MM = 10.0
_RULER_MM = 14.0
_INCH_MM = 25.4


def page_of(board: Board) -> tuple[str, float, float]:
    """The smallest page (name, width, height in mm, landscape) that holds the board with its white edge and rulers.

    Raises:
        InputError: The board is larger than A1.
    """
    width, height = board.squares_x * board.square_mm, board.squares_y * board.square_mm
    for name, (page_x, page_y) in _PAGES_MM.items():
        if width + 2.0 * _EDGE_MM + _RULER_MM <= page_x and height + 2.0 * _EDGE_MM + _RULER_MM <= page_y:
            return name, page_x, page_y
    raise InputError(
        f"a board of {width:g} x {height:g} mm does not fit on A1 landscape; use fewer or smaller squares."
    )


def draw_board(board: Board) -> bytes:
    """The board as a PDF page at 1:1, nominal size; what the printer made of it is to be measured.

    Raises:
        InputError: It fits on no page, or the dictionary has too few markers.
    """
    name, page_x, page_y = page_of(board)
    figure = Figure(figsize=(page_x / _INCH_MM, page_y / _INCH_MM))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0.0, page_x)
    axes.set_ylim(page_y, 0.0)  # y downwards, as OpenCV counts squares
    axes.axis("off")
    width, height = board.squares_x * board.square_mm, board.squares_y * board.square_mm
    left, top = 0.5 * (page_x - width + _RULER_MM), 0.5 * (page_y - height - _RULER_MM)
    _draw_squares(axes, board, left, top)
    _draw_markers(axes, board, left, top)
    _draw_ruler(axes, left, top + height + 5.0, width, upright=False)
    _draw_ruler(axes, left - 5.0, top, height, upright=True)
    text = (
        f"footscan board {board.squares_x} x {board.squares_y}, squares {board.square_mm:g} mm, {board.dictionary}. "
        f"Print on {name} at 100 %, glue on a flat plate, measure over all squares: {width:g} x {height:g} mm wanted."
    )
    axes.text(left, top + height + 15.0, text, fontsize=6.5, va="bottom")
    stream = io.BytesIO()
    figure.savefig(stream, format="pdf")
    return stream.getvalue()


def _draw_squares(axes: Any, board: Board, left: float, top: float) -> None:
    side = board.square_mm
    for row in range(board.squares_y):
        for column in range(row % 2, board.squares_x, 2):
            _black(axes, left + column * side, top + row * side, side)


def _draw_markers(axes: Any, board: Board, left: float, top: float) -> None:
    marks = cv2.aruco.getPredefinedDictionary(dictionary_number(board))
    size = (board.squares_x, board.squares_y)
    grid = cv2.aruco.CharucoBoard(size, board.square_mm, board.marker_mm, marks)
    numbers = np.asarray(grid.getIds()).ravel()
    if int(numbers.max()) >= len(marks.bytesList):
        raise InputError(
            f"a board of {size[0]} x {size[1]} squares needs {len(numbers)} markers, {board.dictionary} has "
            f"{len(marks.bytesList)}; use a larger dictionary."
        )
    for number, corners in zip(numbers, grid.getObjPoints(), strict=True):
        x, y, _ = np.asarray(corners)[0]
        _draw_bits(axes, marker_bits(marks, int(number)), left + float(x), top + float(y), board.marker_mm)


def marker_bits(marks: Any, number: int) -> Bools:
    """Black cells `(k, k)` of a marker with its black border, top row first."""
    cells = int(marks.markerSize) + 2
    picture = marks.generateImageMarker(number, 10 * cells)
    return np.asarray(picture)[5::10, 5::10] < 128


def _draw_bits(axes: Any, black: Bools, x: float, y: float, side: float) -> None:
    """Runs of black cells as one patch each, so that no seams are printed between them."""
    cell = side / len(black)
    for row, line in enumerate(black):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(np.int8), [0]])))
        for start, end in edges.reshape(-1, 2):
            patch = Rectangle((x + start * cell, y + row * cell), (end - start) * cell, cell, color="black", lw=0)
            axes.add_patch(patch)


def _black(axes: Any, x: float, y: float, side: float) -> None:
    axes.add_patch(Rectangle((x, y), side, side, color="black", lw=0))


def _draw_ruler(axes: Any, x: float, y: float, length: float, upright: bool) -> None:
    """Millimetre ticks over the whole length of the squares; numbers every 10 mm."""
    for mm in range(round(length) + 1):
        tick = 4.0 if mm % 10 == 0 else 2.5 if mm % 5 == 0 else 1.5
        if upright:
            axes.plot([x, x - tick], [y + mm, y + mm], color="black", linewidth=0.3)
        else:
            axes.plot([x + mm, x + mm], [y, y + tick], color="black", linewidth=0.3)
        if mm % 10 == 0:
            place = (x - 4.5, y + mm) if upright else (x + mm, y + 4.5)
            axes.text(
                *place, str(mm), fontsize=5, ha="right" if upright else "center", va="center" if upright else "top"
            )
