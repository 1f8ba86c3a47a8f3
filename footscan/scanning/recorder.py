"""Writing a recording: a frame is written before its row is, so a killed program leaves rows of whole frames only."""

import contextlib
import hashlib
import os
from collections.abc import Collection
from pathlib import Path
from types import TracebackType
from typing import TextIO

import cv2

from footscan.config import RecordingInfo, recording_toml
from footscan.config.toml_file import write_whole
from footscan.coordinates import Floats, Frame, Ints
from footscan.errors import RecordingError, StorageError
from footscan.scanning.recording import (
    ENCODER_COLUMNS,
    FRAME_COLUMNS,
    MANIFEST,
    FrameLaser,
    FrameSweep,
    csv_line,
    open_recording,
)

# run lengths of unfiltered rows: for dark frames with a line, a fifth of the default's time and half its size
_PNG = [
    *(cv2.IMWRITE_PNG_COMPRESSION, 1),
    *(cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE),
    *(cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_NONE),
]


class RecordingWriter:
    """An open recording folder; use as a context manager or call `close`.

    Raises:
        RecordingError: The folder already holds a recording: nothing recorded is ever overwritten.
        StorageError: The place cannot be written or the disk is full; frames already there stay valid.
    """

    def __init__(self, folder: Path, info: RecordingInfo, scanner_toml: bytes) -> None:
        if (folder / "recording.toml").exists():
            raise RecordingError(f"{folder} already holds a recording; choose another folder, nothing is overwritten.")
        self._folder = folder
        self._count = 0
        write_whole(folder / "recording.toml", recording_toml(info))
        write_whole(folder / "scanner.toml", scanner_toml)
        try:
            (folder / "frames").mkdir(exist_ok=True)
            self._frames = self._table("frames.csv", FRAME_COLUMNS)
            self._encoder = self._table("encoder.csv", ENCODER_COLUMNS)
        except OSError as err:
            raise _full(folder, err) from err

    def _table(self, name: str, columns: tuple[str, ...]) -> TextIO:
        stream = (self._folder / name).open("w", encoding="utf-8", buffering=1)
        stream.write(csv_line(columns))
        return stream

    def add_frame(self, frame: Frame, time_s: float, laser: FrameLaser, sweep: FrameSweep, setup: str = "") -> None:
        """Store one upright frame `(height, width)` uint8, taken at `time_s`.

        Raises:
            ValueError: `setup` holds a comma, a quote or a line break.
            StorageError: The disk is full.
        """
        if any(mark in setup for mark in ',"\r\n'):
            raise ValueError(f"a setup is a plain word, found {setup!r}")
        file = f"frames/{self._count:06d}.png"
        encoded = cv2.imencode(".png", frame, _PNG)[1]
        try:
            (self._folder / file).write_bytes(encoded.tobytes())
            self._frames.write(csv_line((self._count, file, f"{time_s:.6f}", laser, sweep, setup)))
        except OSError as err:
            raise _full(self._folder, err) from err
        self._count += 1

    def add_counts(self, time_s: Floats, count: Ints) -> None:
        """Append encoder samples, `(n,)` times (s) and counts."""
        lines = (csv_line((f"{t:.6f}", int(c))) for t, c in zip(time_s, count, strict=True))
        try:
            self._encoder.write("".join(lines))
        except OSError as err:
            raise _full(self._folder, err) from err

    def close(self) -> None:
        """Finish the tables and write the checksums of everything; safe to call twice."""
        if not self._frames.closed:
            self._close_tables()
            write_whole(self._folder / MANIFEST, manifest_of(self._folder).encode())

    def _close_tables(self) -> None:
        try:
            for stream in (self._frames, self._encoder):
                stream.flush()
                os.fsync(stream.fileno())
                stream.close()
        except OSError as err:
            raise _full(self._folder, err) from err

    def __enter__(self) -> "RecordingWriter":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.close()
        else:
            self.break_off()

    def break_off(self) -> None:
        """Close what is written: readable, but without the checksums of a finished recording."""
        if not self._frames.closed:
            with contextlib.suppress(StorageError):
                self._close_tables()


def leave_out_setups(folder: Path, setups: Collection[str]) -> None:
    """Take all frames of some setups out of the table of a finished recording; their pictures stay in the folder.

    Raises:
        StorageError: The folder cannot be written.
    """
    recording = open_recording(folder)
    kept = [
        csv_line((r.frame, r.file, f"{r.time_s:.6f}", r.laser, r.sweep, r.setup))
        for r in recording.frames
        if r.setup not in setups
    ]
    write_whole(folder / "frames.csv", (csv_line(FRAME_COLUMNS) + "".join(kept)).encode())
    write_whole(folder / MANIFEST, manifest_of(folder).encode())


def _full(folder: Path, err: OSError) -> StorageError:
    return StorageError(
        f"{folder} could not be written ({err.strerror}); what was captured before is kept. Free space and scan again."
    )


def recorded_files(folder: Path) -> list[Path]:
    """The files that make a recording, in name order: TOML, CSV and frames."""
    files = [path for path in folder.iterdir() if path.suffix in (".toml", ".csv")]
    frames = folder / "frames"
    files += list(frames.iterdir()) if frames.is_dir() else []
    return sorted(path for path in files if not path.name.startswith(("truth", ".")))


def manifest_of(folder: Path) -> str:
    """Checksums of a recording in the format of sha256sum."""
    names = [path.relative_to(folder).as_posix() for path in recorded_files(folder)]
    return "".join(f"{hashlib.sha256((folder / name).read_bytes()).hexdigest()}  {name}\n" for name in names)
