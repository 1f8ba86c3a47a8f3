"""Where the data of this computer's user lies."""

import os
from pathlib import Path

import platformdirs

from footscan.errors import StorageError

VARIABLE = "FOOTSCAN_DATA"
SCANS = "scans"
"""`<data>/scans/<YYYYmmdd-HHMMSS>-<side>/recording` and `/results`: scans before they are filed."""


def data_folder(given: Path | None = None) -> Path:
    """The data folder: as given, else `FOOTSCAN_DATA`, else the platform's folder for user data."""
    if given is not None:
        return given
    named = os.environ.get(VARIABLE)
    return Path(named) if named else platformdirs.user_data_path("footscan", appauthor=False)


def make_private(folder: Path) -> None:
    """Make a folder that only its owner may enter; one that exists keeps its permissions.

    Raises:
        StorageError: The place cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError as err:
        raise StorageError(
            f"the data folder {folder} cannot be made ({err.strerror}); choose another with --data or {VARIABLE}."
        ) from err
