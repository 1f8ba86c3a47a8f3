"""The ChArUco board: its corners, its outline, how it is found in an upright frame, and why it was not."""

from dataclasses import dataclass, replace
from typing import Any, cast

import cv2
import numpy as np

from footscan.calibration.saddle import refine_corners
from footscan.config import Board
from footscan.coordinates import Floats, Frame, Ints
from footscan.errors import ConfigError

FEWEST_CORNERS = 6
_DARK_GREY = 30
_LIT_SHARE = 0.002
_COMMON_DICTIONARIES = ("DICT_4X4_50", "DICT_4X4_100", "DICT_5X5_50", "DICT_5X5_100", "DICT_6X6_50", "DICT_6X6_250")


@dataclass(frozen=True)
class BoardCorners:
    """Corners found in one frame: `(n,)` numbers and `(n, 2)` places (u, v) of the upright frame."""

    number: Ints
    uv: Floats


class BoardFinder:
    """Finds one kind of board; holds OpenCV's detector, so one per thread."""

    def __init__(self, board: Board) -> None:
        marks = cv2.aruco.getPredefinedDictionary(dictionary_number(board))
        size = (board.squares_x, board.squares_y)
        grid = cv2.aruco.CharucoBoard(size, board.square_mm, board.marker_mm, marks)
        self._detector = cv2.aruco.CharucoDetector(grid)

    def find(self, frame: Frame) -> BoardCorners | None:
        """Find the board in an upright frame; `None` where fewer than six clear corners are seen."""
        places, numbers, _, _ = cast("tuple[Any, Any, Any, Any]", self._detector.detectBoard(frame))
        if numbers is None or len(numbers) < FEWEST_CORNERS:
            return None
        uv, good = refine_corners(frame, np.asarray(places, np.float64).reshape(-1, 2))
        if np.count_nonzero(good) < FEWEST_CORNERS:
            return None
        return BoardCorners(np.asarray(numbers, np.int64).ravel()[good], uv[good])

    def markers(self, frame: Frame) -> int:
        """How many markers of the board's dictionary are seen."""
        numbers = cast("tuple[Any, Any, Any, Any]", self._detector.detectBoard(frame))[3]
        return 0 if numbers is None else len(numbers)


def dictionary_number(board: Board) -> int:
    """OpenCV's number of the board's dictionary.

    Raises:
        ConfigError: OpenCV knows no such dictionary.
    """
    number = getattr(cv2.aruco, board.dictionary, None)
    if not isinstance(number, int):
        raise ConfigError(f'board.toml: key "dictionary" is {board.dictionary!r}, which OpenCV does not know.')
    return number


def corners_mm(board: Board) -> Floats:
    """Inner corners `(n, 2)` in the order of their numbers: x along the rows, y downwards, from the board's middle.

    Where lengths were measured on the print, they count, and not the nominal side of the squares.
    """
    column, row = np.meshgrid(np.arange(1, board.squares_x), np.arange(1, board.squares_y))
    x = (column.ravel() - 0.5 * board.squares_x) * board.square_x_mm
    y = (row.ravel() - 0.5 * board.squares_y) * board.square_y_mm
    return np.asarray(np.stack([x, y], axis=-1), dtype=np.float64)


def half_size_mm(board: Board) -> Floats:
    """Half width and half height `(2,)` of the board's squares."""
    return np.asarray(
        [0.5 * board.squares_x * board.square_x_mm, 0.5 * board.squares_y * board.square_y_mm], dtype=np.float64
    )


def why_not_found(board: Board, frames: list[Frame]) -> str:
    """Why no frame of several shows the board: the first reason that holds, as a clause with what to do."""
    if _dark(frames):
        return "the pictures are too dark (almost no pixel above grey value 30): open the lens or light the board"
    if _seen(board, [np.ascontiguousarray(frame[:, ::-1]) for frame in frames]):
        return "the board is mirrored: the pictures or the print are reversed left to right; undo that"
    for name in _COMMON_DICTIONARIES:
        if name != board.dictionary and _seen(replace(board, dictionary=name), frames):
            return f"the board has another dictionary ({name}) than board.toml says ({board.dictionary}); correct it"
    if _seen(board, [_enlarged(frame) for frame in frames]):
        return "the board is seen too small: place it nearer to the axis, or print it larger"
    if any(BoardFinder(board).markers(frame) for frame in frames):
        return "only single markers are seen: the board is edge-on or mostly out of the picture; turn it to the camera"
    return (
        "no marker is seen: the board is edge-on, covered, out of the picture, or of another kind than board.toml says"
    )


def _dark(frames: list[Frame]) -> bool:
    return all(np.count_nonzero(frame > _DARK_GREY) < _LIT_SHARE * frame.size for frame in frames)


def _enlarged(frame: Frame) -> Frame:
    return np.asarray(cv2.resize(frame, None, fx=3.0, fy=3.0, interpolation=cv2.INTER_CUBIC), dtype=np.uint8)


def _seen(board: Board, frames: list[Frame]) -> bool:
    finder = BoardFinder(board)
    return any(finder.find(frame) is not None for frame in frames)
