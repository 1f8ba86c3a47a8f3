"""board.toml (`footscan-board/1`): the ChArUco board of a calibration."""

from dataclasses import asdict, dataclass
from pathlib import Path

from pydantic import Field, model_validator

from footscan.config.toml_file import Strict, Table, load_file, toml_bytes

_MOST_OFF = 0.1
"""A print further off its nominal size than this was measured in another way than meant."""


@dataclass(frozen=True)
class Board:
    """A ChArUco board: squares in x and y, their side, the markers' side, and the marker dictionary.

    Attributes:
        measured_x_mm: Length over all squares of a row, measured on the print with a calliper; `None`: not measured.
        measured_y_mm: The same over a column.
    """

    squares_x: int
    squares_y: int
    square_mm: float
    marker_mm: float
    dictionary: str
    measured_x_mm: float | None = None
    measured_y_mm: float | None = None

    @property
    def square_x_mm(self) -> float:
        """Width of a square: as measured where it was measured."""
        return self.square_mm if self.measured_x_mm is None else self.measured_x_mm / self.squares_x

    @property
    def square_y_mm(self) -> float:
        """Height of a square: as measured where it was measured."""
        return self.square_mm if self.measured_y_mm is None else self.measured_y_mm / self.squares_y

    @property
    def measured(self) -> bool:
        """Whether both lengths were measured, so that the scale of everything is known."""
        return self.measured_x_mm is not None and self.measured_y_mm is not None


DEFAULT_BOARD = Board(squares_x=7, squares_y=5, square_mm=30.0, marker_mm=22.0, dictionary="DICT_4X4_50")
"""The board that calibration is tuned for: fits on A4, seven squares by five."""


class BoardModel(Strict):
    """The whole file."""

    squares_x: int = Field(ge=3, le=50)
    squares_y: int = Field(ge=3, le=50)
    square_mm: float = Field(gt=1, lt=500)
    marker_mm: float = Field(gt=0.5, lt=500)
    dictionary: str = Field(pattern=r"^DICT_")
    measured_x_mm: float | None = Field(default=None, gt=3, lt=25000)
    measured_y_mm: float | None = Field(default=None, gt=3, lt=25000)

    @model_validator(mode="after")
    def _marker_fits(self) -> "BoardModel":
        if self.marker_mm >= self.square_mm:
            raise ValueError(f"a marker ({self.marker_mm} mm) must be smaller than its square ({self.square_mm} mm)")
        return self

    @model_validator(mode="after")
    def _measured_fits(self) -> "BoardModel":
        pairs = (("x", self.measured_x_mm, self.squares_x), ("y", self.measured_y_mm, self.squares_y))
        for axis, measured, squares in pairs:
            nominal = squares * self.square_mm
            if measured is not None and abs(measured / nominal - 1.0) > _MOST_OFF:
                raise ValueError(
                    f"measured_{axis}_mm is {measured:g}, {squares} squares of {self.square_mm:g} mm make {nominal:g}; "
                    "measure over all squares, without the white border, or correct square_mm"
                )
        return self


def load_board(path: Path | str) -> Board:
    """Read and validate board.toml.

    Raises:
        ConfigError: Anything wrong with the file.
    """
    return Board(**load_file(Path(path), "board", BoardModel).model_dump())


def board_toml(board: Board) -> bytes:
    """board.toml of a board."""
    table: Table = {"format": "footscan-board/1"}
    table |= {key: value for key, value in asdict(board).items() if value is not None}
    return toml_bytes(table)
