"""Typed settings: the only place that reads TOML. Files are validated by pydantic; frozen dataclasses come out."""

from footscan.config.board import DEFAULT_BOARD, Board, board_toml, load_board
from footscan.config.calibration_file import (
    CalibrationRecord,
    calibration_toml,
    load_calibration,
    load_calibration_record,
    save_calibration,
)
from footscan.config.recording_file import MOST_WEDGE_MM, RecordingInfo, Subject, load_recording_info, recording_toml
from footscan.config.scanner_file import load_scanner, scanner_toml
from footscan.config.toml_file import file_kind

__all__ = [
    "DEFAULT_BOARD",
    "MOST_WEDGE_MM",
    "Board",
    "CalibrationRecord",
    "RecordingInfo",
    "Subject",
    "board_toml",
    "calibration_toml",
    "file_kind",
    "load_board",
    "load_calibration",
    "load_calibration_record",
    "load_recording_info",
    "load_scanner",
    "recording_toml",
    "save_calibration",
    "scanner_toml",
]
