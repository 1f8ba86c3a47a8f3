"""A last as STEP or IGES, checked by reading it back, and lasts read from such files (extra `cad`)."""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from footscan.config.toml_file import write_whole
from footscan.coordinates import Floats, Ints
from footscan.errors import MeshError, QualityError
from footscan.shoelast.cad_kernel import (
    body_of,
    face_grids,
    loose_curves,
    read_cad_file,
    sewn,
    solid_from_patches,
    triangles_of,
    write_iges,
    write_step,
)
from footscan.shoelast.handed import DATUM
from footscan.shoelast.model import Shoelast
from footscan.shoelast.nurbs_out import NurbsPatch, clamped_patches
from footscan.shoelast.source import LastSource, joined_lines, line_name

STEP_KINDS, IGES_KINDS = (".step", ".stp"), (".iges", ".igs")
DEVIATION_LIMIT_MM = 1e-3
_SHARES = np.linspace(0.0, 1.0, 41)
_CHORD_MM, _TURN_RAD = 0.02, 0.35
_SEW_FOREIGN_MM = 0.05
_MERGE_DIGITS = 5


@dataclass(frozen=True)
class CadCheck:
    """What the file, read back, is: largest deviation from the last (mm), faces, open edges, volume (mm3)."""

    deviation_mm: float
    faces: int
    free_edges: int
    volume_mm3: float


def save_last_cad(shoelast: Shoelast, path: Path, note: str) -> CadCheck:
    """Write a last as a closed solid of three faces (STEP) or as its three surfaces (IGES), and read it back.

    Raises:
        InputError: The extra `cad` is not installed.
        QualityError: What was read back is not the last within 0.001 mm, or not closed; nothing is written.
        StorageError: The place cannot be written.
    """
    patches = clamped_patches(shoelast)
    solid = solid_from_patches(patches)
    with tempfile.TemporaryDirectory(prefix="footscan-cad-") as folder:
        written = Path(folder) / f"last{path.suffix.lower()}"
        if path.suffix.lower() in STEP_KINDS:
            write_step(solid, written, note, DATUM, [patch.name for patch in patches])
        else:
            write_iges(solid, written, note)
        check = _read_back(written, patches)
        if check.deviation_mm > DEVIATION_LIMIT_MM or check.free_edges or check.faces != len(patches):
            raise QualityError(
                f"{path}: read back, the last strays {check.deviation_mm:.4f} mm, allowed are {DEVIATION_LIMIT_MM} mm, "
                f"with {check.free_edges} open edges; export it as 3dm and report this."
            )
        write_whole(path, written.read_bytes())
    return check


def _read_back(path: Path, patches: tuple[NurbsPatch, ...]) -> CadCheck:
    shape = read_cad_file(path).shape
    grids = face_grids(shape, _SHARES)
    wanted = [patch.grid(_SHARES, _SHARES) for patch in patches]
    deviation = max(min(float(np.abs(grid - want).max()) for grid in grids) for want in wanted)
    body = body_of(shape, DEVIATION_LIMIT_MM)
    return CadCheck(deviation, body.faces, body.free_edges, body.volume_mm3)


def _merged(xyz: Floats, faces: Ints) -> trimesh.Trimesh:
    """Vertices of neighbouring faces joined; triangles that shrink to a line (at poles and seams) left out."""
    mesh = trimesh.Trimesh(xyz, faces, process=False)
    mesh.merge_vertices(digits_vertex=_MERGE_DIGITS)
    corner = np.asarray(mesh.faces)
    whole = (corner != np.roll(corner, 1, axis=1)).all(axis=1)
    return trimesh.Trimesh(mesh.vertices, corner[whole], process=False)


def read_cad(path: Path, chord_mm: float = _CHORD_MM) -> LastSource:
    """Read a last from STEP or IGES: faces meshed on common edges within `chord_mm`, loose curves by their names.

    Raises:
        InputError: The extra `cad` is not installed.
        MeshError: It cannot be read, or has no faces.
    """
    file = read_cad_file(path)
    xyz, faces = triangles_of(sewn(file.shape, _SEW_FOREIGN_MM), chord_mm, _TURN_RAD)
    if len(faces) == 0:
        raise MeshError(f"{path} holds no faces, only curves or points; export the last with its surfaces.")
    pieces = loose_curves(file, _CHORD_MM, _TURN_RAD)
    named = [(line_name(name) or name or f"curve_{k}", line) for k, (name, line) in enumerate(pieces, 1)]
    return LastSource(
        _merged(xyz, faces),
        joined_lines(named),
        "millimeters",
        (f"{path.suffix[1:]}: lengths in mm by the file's unit",),
        states_unit=True,
    )
