"""A recording on disk: read, with everything wrong named; written so that what was captured survives a power cut."""

import csv
import io
import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from footscan.config import Board, RecordingInfo, load_board, load_recording_info, load_scanner
from footscan.coordinates import Floats
from footscan.errors import RecordingError
from footscan.optics.scanner import Scanner

FrameLaser = Literal["none", "right", "left"]
FrameSweep = Literal["cw", "ccw", "static"]
FRAME_COLUMNS = ("frame", "file", "time_s", "laser", "sweep", "setup")
ENCODER_COLUMNS = ("time_s", "count")
MANIFEST = "manifest.sha256"


@dataclass(frozen=True)
class FrameRecord:
    """One row of frames.csv."""

    frame: int
    file: str
    time_s: float
    laser: FrameLaser
    sweep: FrameSweep
    setup: str


@dataclass(frozen=True)
class EncoderTrack:
    """encoder.csv: the encoder's own samples, `(n,)` times (s, never going back) and counts."""

    time_s: Floats
    count: Floats


@dataclass(frozen=True)
class Recording:
    """A recording whose tables have been read and checked; its frames are read one by one."""

    folder: Path
    info: RecordingInfo
    scanner: Scanner
    frames: tuple[FrameRecord, ...]
    encoder: EncoderTrack
    board: Board | None

    def path(self, record: FrameRecord) -> Path:
        """Where the picture of a frame lies."""
        return self.folder / record.file


def open_recording(folder: Path | str) -> Recording:
    """Read the tables of a recording folder.

    Raises:
        RecordingError: The folder or a table is missing, cut, empty or contradicts itself; the row is named.
        ConfigError: One of its TOML files is wrong.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise RecordingError(f"{folder} is no folder; give the folder of a recording (it holds recording.toml).")
    if not (folder / "recording.toml").is_file():
        raise RecordingError(f"{folder} has no recording.toml, so it is no recording; give the recording's own folder.")
    info = load_recording_info(folder / "recording.toml")
    board = load_board(folder / "board.toml") if info.kind == "calibration" else None
    scanner = load_scanner(folder / "scanner.toml")
    frames, encoder = _load_frames(folder / "frames.csv"), _load_encoder(folder / "encoder.csv")
    return Recording(folder, info, scanner, frames, encoder, board)


def _rows(path: Path, columns: tuple[str, ...]) -> list[tuple[int, list[str]]]:
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise RecordingError(f"{path} is missing; the recording is incomplete, copy it again.") from None
    except (OSError, UnicodeDecodeError) as err:
        raise RecordingError(f"{path} cannot be read ({err}); copy the recording again.") from err
    reader = csv.reader(io.StringIO(text.removeprefix("\ufeff")))
    try:
        rows = [(reader.line_num, row) for row in reader if row]
    except csv.Error as err:
        raise RecordingError(f"{path} line {reader.line_num} is no CSV ({err}); copy the recording again.") from err
    if not rows or tuple(rows[0][1]) != columns:
        found = ",".join(rows[0][1]) if rows else "nothing"
        raise RecordingError(f"{path}: the first line is {found!r}, it must be {','.join(columns)!r}.")
    if len(rows) == 1:
        raise RecordingError(f"{path} has no rows; the recording is empty, scan again.")
    for line, row in rows[1:]:
        if len(row) != len(columns):
            raise RecordingError(f"{path} line {line} has {len(row)} of {len(columns)} values: the file was cut.")
    return rows[1:]


def _number(path: Path, line: int, name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RecordingError(f"{path} line {line}: {name} is {text!r}, a finite number is needed.")
    return value


def _load_frames(path: Path) -> tuple[FrameRecord, ...]:
    records: list[FrameRecord] = []
    seen: set[str] = set()
    for line, row in _rows(path, FRAME_COLUMNS):
        number, file, time_s, laser, sweep, setup = row
        if laser not in ("none", "right", "left"):
            raise RecordingError(f"{path} line {line}: laser is {laser!r}, allowed are none, right, left.")
        if sweep not in ("cw", "ccw", "static"):
            raise RecordingError(f"{path} line {line}: sweep is {sweep!r}, allowed are cw, ccw, static.")
        if file in seen:
            raise RecordingError(f"{path} line {line}: {file} is named twice; every frame has its own file.")
        if not file or "\0" in file or Path(file).is_absolute() or ".." in Path(file).parts:
            raise RecordingError(
                f"{path} line {line}: {file!r} is no file inside the recording; only such paths are allowed."
            )
        seen.add(file)
        if not number.strip().isdecimal() or len(number) > 15:
            raise RecordingError(f"{path} line {line}: frame is {number!r}, a whole number from 0 on is needed.")
        index = int(number)
        when = _number(path, line, "time_s", time_s)
        records.append(FrameRecord(index, file, when, laser, sweep, setup))
    return tuple(records)


def _load_encoder(path: Path) -> EncoderTrack:
    rows = _rows(path, ENCODER_COLUMNS)
    values = [(_number(path, i, "time_s", t), _number(path, i, "count", c)) for i, (t, c) in rows]
    table = np.array(values)
    back = np.flatnonzero(np.diff(table[:, 0]) < 0.0)
    if len(back):
        line, before, after = rows[back[0] + 1][0], table[back[0], 0], table[back[0] + 1, 0]
        raise RecordingError(f"{path} line {line}: time goes back from {before:.6f} to {after:.6f} s; record again.")
    return EncoderTrack(table[:, 0].copy(), table[:, 1].copy())


def csv_line(values: Iterable[object]) -> str:
    """One line of a CSV file of a recording."""
    return ",".join(str(value) for value in values) + "\n"
