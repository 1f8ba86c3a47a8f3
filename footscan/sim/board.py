"""A printed ChArUco board that stands somewhere in the machine, with the faults a real one may have."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from footscan.config import Board
from footscan.coordinates import Bytes, Floats, Ints
from footscan.errors import InputError
from footscan.geometry.rigid import rigid, transform_points
from footscan.sim import board_print
from footscan.sim.board_print import Print
from footscan.sim.surface import Surface, grid_faces

DEFAULT_BOARD = Board(squares_x=7, squares_y=5, square_mm=30.0, marker_mm=22.0, dictionary="DICT_4X4_50")
_STEP_MM = 5.0


@dataclass(frozen=True)
class Paper:
    """How bright the board is.

    Attributes:
        margin_mm: White edge around the pattern.
        white_grey: Ambient grey value of white paper, whatever its tilt: light comes from everywhere.
        black_grey: Ambient grey value of the print.
        back_grey: Ambient grey value of the back.
        white_laser: Laser light that comes back from white paper, relative to skin.
        black_laser: The same for the print.
        back_laser: The same for the back.
    """

    margin_mm: float = 10.0
    white_grey: float = 101.0
    black_grey: float = 7.0
    back_grey: float = 10.0
    white_laser: float = 0.95
    black_laser: float = 0.23
    back_laser: float = 0.32


DEFAULT_PAPER = Paper()


@dataclass(frozen=True)
class PrintFaults:
    """What may be wrong with a board.

    Attributes:
        scale_x: Printed length over intended length, along the squares' x.
        scale_y: Along their y.
        bow_mm: How far the middle stands out towards the viewer: a board bent about its y axis.
    """

    scale_x: float = 1.0
    scale_y: float = 1.0
    bow_mm: float = 0.0

    def __post_init__(self) -> None:
        if not (0.9 <= self.scale_x <= 1.1 and 0.9 <= self.scale_y <= 1.1):
            raise InputError(
                f"a print is 0.9 to 1.1 of its intended size, found {self.scale_x:g} by {self.scale_y:g}; "
                "choose scales close to 1."
            )
        if not -10.0 <= self.bow_mm <= 10.0:
            raise InputError(f"a board is bent by at most 10 mm either way, found {self.bow_mm:g} mm.")


NO_FAULTS = PrintFaults()


@dataclass(frozen=True)
class PrintedBoard:
    """A board at a pose.

    Attributes:
        board: The pattern as intended (board.toml).
        world_from_board: 4x4; the board system has its origin at the pattern's top left corner, x to the right, y
            down, z into the board.
        faults: What is wrong with the print and the plate.
        paper: Its brightness.
    """

    board: Board
    world_from_board: Floats
    faults: PrintFaults = NO_FAULTS
    paper: Paper = DEFAULT_PAPER

    @property
    def size_mm(self) -> tuple[float, float]:
        """Width and height of the pattern as printed."""
        board, faults = self.board, self.faults
        return (
            board.squares_x * board.square_mm * faults.scale_x,
            board.squares_y * board.square_mm * faults.scale_y,
        )

    @cached_property
    def surface(self) -> Surface:
        """The plate in the world, without thickness."""
        width, height = self.size_mm
        margin = self.paper.margin_mm
        x: Floats = np.linspace(-margin, width + margin, int(np.ceil((width + 2 * margin) / _STEP_MM)) + 1)
        y: Floats = np.linspace(-margin, height + margin, int(np.ceil((height + 2 * margin) / _STEP_MM)) + 1)
        xy: Floats = np.column_stack([np.repeat(x, len(y)), np.tile(y, len(x))]).astype(np.float64)
        xyz_world = transform_points(self.world_from_board, self._on_plate(xy))
        return Surface(np.ascontiguousarray(xyz_world), grid_faces(len(x), len(y)), closed=False)

    def corners_world(self) -> Floats:
        """`(n, 3)` the inner corners of the squares in the order of OpenCV's ids, where they really are."""
        board, faults = self.board, self.faults
        column, row = np.meshgrid(np.arange(1, board.squares_x), np.arange(1, board.squares_y))
        step_x, step_y = board.square_mm * faults.scale_x, board.square_mm * faults.scale_y
        xy: Floats = np.column_stack([column.ravel() * step_x, row.ravel() * step_y]).astype(np.float64)
        return transform_points(self.world_from_board, self._on_plate(xy))

    def for_loops(self, board_from: Floats) -> Print:
        """What the loops need; `board_from` is the 4x4 from the system they work in."""
        board, faults, paper = self.board, self.faults, self.paper
        numbers = np.zeros(board_print.NUMBERS)
        numbers[board_print.SQUARE_MM], numbers[board_print.MARKER_MM] = board.square_mm, board.marker_mm
        numbers[board_print.SCALE_X], numbers[board_print.SCALE_Y] = faults.scale_x, faults.scale_y
        numbers[board_print.WIDTH_MM], numbers[board_print.HEIGHT_MM] = self.size_mm
        numbers[board_print.MARGIN_MM], numbers[board_print.BOW_MM] = paper.margin_mm, faults.bow_mm
        numbers[board_print.WHITE_LASER], numbers[board_print.WHITE_GREY] = paper.white_laser, paper.white_grey
        numbers[board_print.BLACK_LASER], numbers[board_print.BLACK_GREY] = paper.black_laser, paper.black_grey
        numbers[board_print.BACK_LASER], numbers[board_print.BACK_GREY] = paper.back_laser, paper.back_grey
        squares, markers = self._pattern
        return np.ascontiguousarray(board_from), numbers, squares, markers

    @cached_property
    def _pattern(self) -> tuple[Ints, Bytes]:
        return pattern_of(self.board)

    def _on_plate(self, xy: Floats) -> Floats:
        """Places `(n, 2)` of the plate as `(n, 3)` of the board system; arc and chord are taken as equal."""
        width, _ = self.size_mm
        half = 0.5 * width + self.paper.margin_mm
        z = self.faults.bow_mm * (((xy[:, 0] - 0.5 * width) / half) ** 2 - 1.0)
        return np.column_stack([xy, z])


def pattern_of(board: Board) -> tuple[Ints, Bytes]:
    """Squares and markers of a board as `board_print.Print` holds them.

    Raises:
        InputError: A dictionary that OpenCV does not know, or one with too few markers.
    """
    number = getattr(cv2.aruco, board.dictionary, None)
    if not isinstance(number, int):
        raise InputError(
            f"the marker dictionary {board.dictionary!r} is unknown; use one of OpenCV's, DICT_4X4_50 say."
        )
    dictionary = cv2.aruco.getPredefinedDictionary(number)
    needed = (board.squares_x * board.squares_y) // 2
    if needed > len(dictionary.bytesList):
        raise InputError(
            f"a board of {board.squares_x} x {board.squares_y} squares needs {needed} markers, {board.dictionary} has "
            f"{len(dictionary.bytesList)}; choose a larger dictionary."
        )
    charuco = cv2.aruco.CharucoBoard((board.squares_x, board.squares_y), board.square_mm, board.marker_mm, dictionary)
    squares = np.full((board.squares_y, board.squares_x), -1, dtype=np.int64)
    modules = dictionary.markerSize + 2
    markers = np.zeros((len(charuco.getIds()), modules, modules), dtype=np.uint8)
    for k, (name, corner) in enumerate(zip(np.ravel(charuco.getIds()), charuco.getObjPoints(), strict=True)):
        column, row = (int(place // board.square_mm) for place in np.asarray(corner).mean(axis=0)[:2])
        squares[row, column] = k
        markers[k] = dictionary.generateImageMarker(int(name), modules, borderBits=1) > 0
    return squares, markers


@dataclass(frozen=True)
class Placement:
    """How a board stands: middle of its pattern, and which way its printed side looks.

    Attributes:
        centre_world: mm.
        azimuth_rad: Heading of the printed side's normal, counter-clockwise from X seen from above.
        elevation_rad: How far that normal points upwards.
        roll_rad: Turn about it, clockwise as the viewer sees it.
    """

    centre_world: tuple[float, float, float]
    azimuth_rad: float
    elevation_rad: float
    roll_rad: float = 0.0

    def world_from_board(self, size_mm: tuple[float, float]) -> Floats:
        """4x4 for a pattern of this width and height."""
        ce, se = np.cos(self.elevation_rad), np.sin(self.elevation_rad)
        ca, sa = np.cos(self.azimuth_rad), np.sin(self.azimuth_rad)
        into = -np.array([ce * ca, ce * sa, se])
        level = np.array([-sa, ca, 0.0])
        down = np.cross(into, level)
        c, s = np.cos(self.roll_rad), np.sin(self.roll_rad)
        x, y = c * level + s * down, c * down - s * level
        rotation = np.stack([x, y, into], axis=1)
        middle = np.array([0.5 * size_mm[0], 0.5 * size_mm[1], 0.0])
        return rigid(rotation, np.array(self.centre_world) - rotation @ middle)
