"""The print of a calibration board inside compiled loops: where the board is, and what is black or white there.

Board system: origin at the top left corner of the pattern, x to the right and y down along the squares as the viewer
sees them, z into the board; the printed side faces -z. This is how OpenCV counts ChArUco corners.
"""

import numpy as np

from footscan.compiled import compiled_inline
from footscan.coordinates import Bytes, Floats, Ints

# Indices of the numbers that describe a printed board for the loops.
SQUARE_MM, MARKER_MM, SCALE_X, SCALE_Y, WIDTH_MM, HEIGHT_MM, MARGIN_MM, BOW_MM = range(8)
WHITE_LASER, BLACK_LASER, BACK_LASER, WHITE_GREY, BLACK_GREY, BACK_GREY = range(8, 14)
NUMBERS = 14

Print = tuple[Floats, Floats, Ints, Bytes]
"""board_from_(something) 4x4; the numbers above `(NUMBERS,)`, or none for a surface without print; squares
`(rows, columns)`: which marker a square holds, -1 for a black one; markers `(n, k, k)`: 1 white, 0 black."""


def no_print() -> Print:
    """What stands for a surface without print."""
    return np.eye(4), np.empty(0), np.empty((0, 0), dtype=np.int64), np.empty((0, 0, 0), dtype=np.uint8)


@compiled_inline
def depth_of_board(x: float, numbers: Floats) -> float:
    """Depth of the board at x, mm: one bent about its y axis stands `BOW_MM` towards the viewer in its middle."""
    half = 0.5 * numbers[WIDTH_MM] + numbers[MARGIN_MM]
    across = (x - 0.5 * numbers[WIDTH_MM]) / half
    return numbers[BOW_MM] * (across * across - 1.0)


@compiled_inline
def slope_of_board(x: float, numbers: Floats) -> float:
    """Slope of `depth_of_board` at x."""
    half = 0.5 * numbers[WIDTH_MM] + numbers[MARGIN_MM]
    return 2.0 * numbers[BOW_MM] * (x - 0.5 * numbers[WIDTH_MM]) / (half * half)


@compiled_inline
def is_white(x: float, y: float, numbers: Floats, squares: Ints, markers: Bytes) -> bool:
    """Whether the paper is white at a place of the printed side (mm)."""
    square = numbers[SQUARE_MM]
    s, t = x / (numbers[SCALE_X] * square), y / (numbers[SCALE_Y] * square)
    column, row = int(np.floor(s)), int(np.floor(t))
    if column < 0 or row < 0 or column >= squares.shape[1] or row >= squares.shape[0]:
        return True
    marker = squares[row, column]
    if marker < 0:
        return False
    modules = markers.shape[1]
    border, per_mm = 0.5 * (square - numbers[MARKER_MM]), modules / numbers[MARKER_MM]
    i = int(np.floor(((s - column) * square - border) * per_mm))
    j = int(np.floor(((t - row) * square - border) * per_mm))
    if i < 0 or j < 0 or i >= modules or j >= modules:
        return True
    return markers[marker, j, i] > 0


@compiled_inline
def laser_share(x: float, y: float, z: float, eye_x: float, eye_z: float, printed: Print) -> float:
    """Laser light that comes back from a place of the board, relative to skin.

    Args:
        x: Of the place, in the system that the print's matrix comes from.
        y: Of the place.
        z: Of the place.
        eye_x: Of the optical centre, in the board system.
        eye_z: Of the optical centre, in the board system.
        printed: The board.
    """
    m, numbers, squares, markers = printed
    board_x = m[0, 0] * x + m[0, 1] * y + m[0, 2] * z + m[0, 3]
    board_y = m[1, 0] * x + m[1, 1] * y + m[1, 2] * z + m[1, 3]
    board_z = m[2, 0] * x + m[2, 1] * y + m[2, 2] * z + m[2, 3]
    if slope_of_board(board_x, numbers) * (eye_x - board_x) - (eye_z - board_z) <= 0.0:
        return numbers[BACK_LASER]
    return numbers[WHITE_LASER] if is_white(board_x, board_y, numbers, squares, markers) else numbers[BLACK_LASER]
