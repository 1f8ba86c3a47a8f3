"""board.toml (`footscan-board/1`): the ChArUco board of a calibration."""

from dataclasses import dataclass
from pathlib import Path

from pydantic import Field, model_validator

from footscan.config.toml_file import Strict, load_file


@dataclass(frozen=True)
class Board:
    """A ChArUco board: squares in x and y, their side, the markers' side, and the marker dictionary."""

    squares_x: int
    squares_y: int
    square_mm: float
    marker_mm: float
    dictionary: str


class BoardModel(Strict):
    """The whole file."""

    squares_x: int = Field(ge=3, le=50)
    squares_y: int = Field(ge=3, le=50)
    square_mm: float = Field(gt=1, lt=500)
    marker_mm: float = Field(gt=0.5, lt=500)
    dictionary: str = Field(pattern=r"^DICT_")

    @model_validator(mode="after")
    def _marker_fits(self) -> "BoardModel":
        if self.marker_mm >= self.square_mm:
            raise ValueError(f"a marker ({self.marker_mm} mm) must be smaller than its square ({self.square_mm} mm)")
        return self


def load_board(path: Path | str) -> Board:
    """Read and validate board.toml.

    Raises:
        ConfigError: Anything wrong with the file.
    """
    return Board(**load_file(Path(path), "board", BoardModel).model_dump())
