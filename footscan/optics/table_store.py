"""Calibration tables on disk, with the fingerprint of their calibration: a stale table is never used."""

import io
import zipfile
import zlib
from pathlib import Path

import numpy as np

from footscan.coordinates import LASER_NAMES, LaserName
from footscan.errors import InputError, StaleTableError
from footscan.optics.calibration import Calibration, fingerprint
from footscan.optics.sheet import world_from_light
from footscan.optics.tables import LightTable

_FORMAT = "footscan-tables/1"


def tables_bytes(tables: dict[LaserName, LightTable]) -> bytes:
    """Both tables of one calibration as the content of a file."""
    stream = io.BytesIO()
    right, left = tables["right"], tables["left"]
    digest = right.calibration_sha256
    np.savez(stream, format=_FORMAT, calibration_sha256=digest, right=right.xy_light, left=left.xy_light)
    return stream.getvalue()


def load_tables(path: Path, calibration: Calibration) -> dict[LaserName, LightTable]:
    """Read the tables of a calibration.

    Raises:
        InputError: The file is missing, cut or of another kind.
        StaleTableError: The tables belong to another calibration.
    """
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as content:
            kind, made_for = str(content["format"]), str(content["calibration_sha256"])
            arrays = {name: content[name] for name in LASER_NAMES}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as err:
        raise InputError(f"{path} holds no complete calibration tables ({err}); build them again.") from err
    if kind != _FORMAT:
        raise InputError(f"{path} has format {kind!r}, allowed is {_FORMAT!r}; build the tables again.")
    if made_for != fingerprint(calibration):
        raise StaleTableError(f"{path} belongs to another calibration; build the tables again from this one.")
    return {
        name: LightTable(name, arrays[name], world_from_light(calibration.laser(name)), made_for)
        for name in LASER_NAMES
    }
