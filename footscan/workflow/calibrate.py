"""From a calibration recording to files: calibration.toml, its tables, and a place in the machine's history."""

from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from footscan.calibration.calibrate import Calibrated, Options, calibrate_recording
from footscan.calibration.intake import Progress
from footscan.calibration.joint import USUAL, Choices
from footscan.calibration.paper_mode import compare_with_paper
from footscan.calibration.quality import quality_table, recording_sha256
from footscan.config import Board, calibration_toml, load_calibration_record
from footscan.config.toml_file import write_whole
from footscan.errors import InputError, MachineMismatchError
from footscan.optics.calibration import Calibration, fingerprint
from footscan.optics.table_store import tables_bytes
from footscan.optics.tables import build_tables
from footscan.scanning.recording import Recording, open_recording
from footscan.workflow.calibration_log import keep_in_force, refuse_outdated


@dataclass(frozen=True)
class CalibrateSettings:
    """What may be chosen.

    Attributes:
        measured_mm: Lengths of the board over all squares, x and y, from a calliper; `None` leaves the recording's own.
        choices: What to estimate beyond the usual.
        paper_mode: Also compare with the paper's own model.
        data: The data folder in which the calibration comes into force; `None`: only the file is written.
    """

    measured_mm: tuple[float, float] | None = None
    choices: Choices = USUAL
    paper_mode: bool = False
    data: Path | None = None


def run_calibration(
    folder: Path, out: Path, settings: CalibrateSettings, progress: Progress = lambda done, total: None
) -> Calibrated:
    """Calibrate from a recording and write the result; a refusal changes no file.

    Raises:
        RecordingError: The recording is incomplete or shows no board.
        MachineMismatchError: `out` holds the calibration of another machine.
        InputError: It is to come into force, and was recorded before an intervention.
        PoorFitError: A gate refused the result; the calibration in force stays.
        StorageError: A file could not be written.
    """
    recording = open_recording(folder)
    if settings.data is not None:
        refuse_outdated(settings.data, _name(recording), recording.info.created)
    history = _parent(recording, out)
    board = _measured(recording, settings.measured_mm)
    now = datetime.now(UTC).isoformat(timespec="seconds")
    result = calibrate_recording(recording, board, Options(settings.choices, progress=progress, created=now))
    quality = quality_table(result, recording_sha256(folder))
    quality |= {"recorded_at": recording.info.created, "made_at": now}
    if settings.paper_mode:
        quality["paper_mode"] = compare_with_paper(result.joint).lines()
    _save(result.calibration, out, quality, history)
    if settings.data is not None:
        keep_in_force(settings.data, result.calibration, quality, history)
    return replace(result)


def _name(recording: Recording) -> str:
    return recording.scanner.machine_id or recording.scanner.name


def _save(calibration: Calibration, out: Path, quality: dict[str, Any], history: dict[str, Any]) -> None:
    """The tables first: they carry the fingerprint of their calibration, so that older ones are never used."""
    write_whole(tables_path(out), tables_bytes(build_tables(calibration)))
    write_whole(out, calibration_toml(calibration, quality, history))


def tables_path(calibration_file: Path) -> Path:
    """Where the tables of a calibration file lie: beside it."""
    return calibration_file.with_suffix(".tables.npz")


def _parent(recording: Recording, out: Path) -> dict[str, Any]:
    """What stands in `out` now becomes the parent of the new calibration."""
    if not out.is_file():
        return {}
    old = load_calibration_record(out)
    machine, before = recording.scanner.machine_id, old.calibration.machine_id
    if None not in (machine, before) and machine != before:
        raise MachineMismatchError(
            f"{out} holds the calibration of machine {before!r}, the recording is of {machine!r}; choose another --out."
        )
    parents = [fingerprint(old.calibration), *old.history.get("parents", [])]
    return {"parents": parents, "parent_created": old.calibration.created}


def measured_board(folder: Path, measured_mm: tuple[float, float] | None) -> Board | None:
    """The board of a recording with lengths measured over all its squares; None leaves the recording's own.

    Raises:
        InputError: A length that cannot be that of all squares.
        RecordingError: No recording.
    """
    return _measured(open_recording(folder), measured_mm)


def _measured(recording: Recording, measured_mm: tuple[float, float] | None) -> Board | None:
    if measured_mm is None or recording.board is None:
        return None
    x, y = measured_mm
    board = recording.board
    for along, length, squares in (("row", x, board.squares_x), ("column", y, board.squares_y)):
        nominal = squares * board.square_mm
        if not 0.9 < length / nominal < 1.1:
            raise InputError(
                f"the length along a {along} is {length:g} mm, {squares} squares of {board.square_mm:g} mm make "
                f"{nominal:g} mm; measure over all squares, without the white border."
            )
    return replace(board, measured_x_mm=x, measured_y_mm=y)
