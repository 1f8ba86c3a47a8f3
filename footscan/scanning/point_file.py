"""points.ply: the cleaned cloud, binary little-endian; board.npy: where the bare footboard was seen."""

from io import BytesIO
from pathlib import Path

import numpy as np

from footscan.config.toml_file import write_whole
from footscan.coordinates import Floats
from footscan.errors import InputError
from footscan.scanning.cloud import Cloud

_ROW = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("laser", "u1"), ("weight", "<f4")])
_PROPERTIES = (
    "property float x",
    "property float y",
    "property float z",
    "property uchar laser",
    "property float weight",
)


def save_points(cloud: Cloud, path: Path, comment: str) -> None:
    """Write `(n, 3)` world points (mm) with `laser` (0 right, 1 left) and `weight`, whole or not at all."""
    rows = np.empty(len(cloud), dtype=_ROW)
    for k, name in enumerate("xyz"):
        rows[name] = cloud.xyz_world[:, k]
    rows["laser"], rows["weight"] = cloud.laser, cloud.weight
    lines = ["ply", "format binary_little_endian 1.0", f"comment {comment}", f"element vertex {len(cloud)}"]
    header = "\n".join([*lines, *_PROPERTIES, "end_header", ""])
    write_whole(path, header.encode("ascii", "replace") + rows.tobytes())


def load_points(path: Path) -> Cloud:
    """Read a cloud written by `save_points`; its frame numbers are unknown (-1).

    Raises:
        InputError: The file is missing, cut or another kind of PLY.
    """
    try:
        head, body = path.read_bytes().split(b"end_header\n", 1)
    except (OSError, ValueError) as err:
        raise InputError(f"{path} is no point cloud of footscan ({err}); process the recording again.") from err
    lines = head.decode("ascii", "replace").splitlines()
    counts = [line.removeprefix("element vertex ") for line in lines if line.startswith("element vertex ")]
    count = int(counts[0]) if counts and counts[0].isdecimal() else -1
    if [line for line in lines if line.startswith("property")] != list(_PROPERTIES) or len(
        body
    ) != count * _ROW.itemsize:
        raise InputError(f"{path} is cut or was written by another program; process the recording again.")
    rows = np.frombuffer(body, dtype=_ROW)
    xyz_world = np.column_stack([rows[name] for name in "xyz"]).astype(np.float64)
    return Cloud(xyz_world, rows["laser"].astype(np.int64), rows["weight"].copy(), np.full(count, -1))


def save_bare_board(xy_world: Floats, path: Path) -> None:
    """Write `(n, 2)` places of the bare footboard (mm, world), whole or not at all."""
    stream = BytesIO()
    np.save(stream, xy_world.astype(np.float32))
    write_whole(path, stream.getvalue())


def load_bare_board(path: Path) -> Floats | None:
    """Read places `(n, 2)` written by `save_bare_board`; None where results of an older version have none.

    Raises:
        InputError: The file is damaged.
    """
    if not path.is_file():
        return None
    try:
        xy_world = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError) as err:
        raise InputError(f"{path} is cut or damaged ({err}); process the recording again.") from err
    if xy_world.ndim != 2 or xy_world.shape[1] != 2:
        raise InputError(f"{path} was written by another program; process the recording again.")
    return np.asarray(xy_world, dtype=np.float64)
