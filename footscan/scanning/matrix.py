"""The scan matrix (paper, Fig. 7): per frame its angle, and the light-plane places of its stripe points."""

import io
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from footscan.config.toml_file import write_whole
from footscan.coordinates import LASER_NAMES, Floats, Floats32, Ints, LaserName
from footscan.errors import RecordingError, StaleTableError

_FORMAT = "footscan-scan-matrix/1"


class ScanMatrix:
    """Points of a scan in the order of their frames, in memory that is allocated ahead and doubled when full."""

    def __init__(self, calibration_sha256: str, frames: int = 1024, points: int = 1 << 17) -> None:
        self.calibration_sha256 = calibration_sha256
        self._frame = np.empty((frames, 3))  # frame number, laser code, theta
        self._start = np.zeros(frames + 1, dtype=np.int64)
        self._point = np.empty((points, 3), dtype=np.float32)  # x_L, y_L, weight
        self._frames = 0

    def append(self, frame: int, laser: LaserName, theta_rad: float, xy_light: Floats, weight: Floats) -> None:
        """Add the `(n, 2)` light-plane points (mm) and `(n,)` weights of one frame."""
        begin = int(self._start[self._frames])
        end = begin + len(weight)
        self._make_room(end)
        self._frame[self._frames] = frame, LASER_NAMES.index(laser), theta_rad
        self._point[begin:end, 0:2] = xy_light
        self._point[begin:end, 2] = weight
        self._frames += 1
        self._start[self._frames] = end

    def _make_room(self, points: int) -> None:
        while len(self._point) < points:
            self._point = np.concatenate([self._point, np.empty_like(self._point)])
        if self._frames == len(self._frame):
            self._frame = np.concatenate([self._frame, np.empty_like(self._frame)])
            self._start = np.concatenate([self._start, np.zeros(len(self._start), dtype=np.int64)])

    @property
    def frame(self) -> Ints:
        """`(frames,)` frame numbers."""
        return self._frame[: self._frames, 0].astype(np.int64)

    @property
    def laser(self) -> Ints:
        """`(frames,)` laser codes: 0 right, 1 left."""
        return self._frame[: self._frames, 1].astype(np.int64)

    @property
    def theta_rad(self) -> Floats:
        """`(frames,)` head angles."""
        return self._frame[: self._frames, 2]

    @property
    def points_per_frame(self) -> Ints:
        """`(frames,)` numbers of points."""
        return np.diff(self._start[: self._frames + 1])

    @property
    def xy_light(self) -> Floats32:
        """`(n, 2)` mm in the light plane of each point's laser."""
        return self._point[: self._start[self._frames], 0:2]

    @property
    def weight(self) -> Floats32:
        """`(n,)` weights in 0..1."""
        return self._point[: self._start[self._frames], 2]

    def save(self, path: Path) -> None:
        """Write the matrix, whole or not at all."""
        stream = io.BytesIO()
        np.savez_compressed(
            stream,
            format=_FORMAT,
            calibration_sha256=self.calibration_sha256,
            frame=self._frame[: self._frames],
            start=self._start[: self._frames + 1],
            point=self._point[: self._start[self._frames]],
        )
        write_whole(path, stream.getvalue())


def load_scan_matrix(path: Path, calibration_sha256: str) -> ScanMatrix:
    """Read a matrix that was made with the calibration of this fingerprint.

    Raises:
        RecordingError: The file is missing, cut or no scan matrix.
        StaleTableError: It was made with another calibration: its millimetres are not this machine's.
    """
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as content:
            stored = {name: content[name] for name in ("format", "calibration_sha256", "frame", "start", "point")}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as err:
        raise RecordingError(f"{path} is no complete scan matrix ({err}); process the recording again.") from err
    if str(stored["format"]) != _FORMAT:
        raise RecordingError(f"{path} has format {str(stored['format'])!r}, allowed is {_FORMAT!r}.")
    if str(stored["calibration_sha256"]) != calibration_sha256:
        raise StaleTableError(f"{path} was made with another calibration; process the recording again with this one.")
    try:
        return _rebuilt(stored, calibration_sha256)
    except (ValueError, IndexError) as err:
        raise RecordingError(f"{path} contradicts itself ({err}); process the recording again.") from err


def _rebuilt(stored: dict[str, Any], calibration_sha256: str) -> ScanMatrix:
    matrix = ScanMatrix(calibration_sha256)
    for row, begin, end in zip(stored["frame"], stored["start"][:-1], stored["start"][1:], strict=True):
        part = stored["point"][begin:end]
        matrix.append(int(row[0]), LASER_NAMES[int(row[1])], float(row[2]), part[:, 0:2], part[:, 2])
    return matrix
