"""Reading a last from a file of any kind, or from a scan of a last made by `process --object last`."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from footscan.coordinates import Side
from footscan.errors import InputError, MeshError
from footscan.foot.mesh_file import SURFACE, load_foot_mesh
from footscan.shoelast.cad_file import IGES_KINDS, STEP_KINDS, read_cad
from footscan.shoelast.import_last import check_side_of_shape, shoelast_from_mesh
from footscan.shoelast.import_pose import likely_unit
from footscan.shoelast.model import Shoelast
from footscan.shoelast.own_surfaces import shoelast_of_surfaces
from footscan.shoelast.rhino_read import read_3dm
from footscan.shoelast.source import LastSource
from footscan.workflow.lasts_scan import LAST_REMARKS

MESH_KINDS = (".stl", ".obj", ".ply", ".off", ".glb", ".3mf")


def import_last(
    place: Path,
    *,
    side: Side,
    unit: str | None = None,
    name: str | None = None,
    size_eu: float | None = None,
    fitting: str = "",
    style: str = "",
    pitch_mm: float | None = None,
) -> Shoelast:
    """Import a last.

    Args:
        place: A file (STL, OBJ, PLY, 3DM, STEP, IGES), or a folder that holds a `surface.ply`.
        side: Of the real last.
        unit: mm, cm, m or in, for mesh files; the other kinds state theirs.
        name: For people; default: the file's name.
        size_eu: Paris points, if known; default: what the file says.
        fitting: Width, as the maker writes it; default: what the file says.
        style: A word; default: what the file says.
        pitch_mm: Heel height at which it stands, if known.

    Raises:
        InputError: Nothing there, a kind that is not read, or no unit given for a mesh file.
        MeshError: No last, or not a whole one; see `import_last.shoelast_from_mesh`.
    """
    source = read_last(place, unit)
    title = name or (place.name if place.is_dir() else place.stem)
    shoelast = shoelast_of_surfaces(source, side, title) if pitch_mm is None else None
    if shoelast is None:
        shoelast, _ = shoelast_from_mesh(source, side, title, unit or "mm", pitch_mm, scanned=place.is_dir())
    else:
        check_side_of_shape(shoelast, side)
    said = source.said
    size = size_eu if size_eu is not None or "size_eu" not in said else float(said["size_eu"])
    return replace(
        shoelast, size_eu=size, fitting=fitting or said.get("fitting", ""), style=style or said.get("style", "")
    )


def read_last(place: Path, unit: str | None) -> LastSource:
    """What a file or folder holds, in mm.

    Raises:
        InputError: Nothing there, a kind that is not read, or no unit.
        MeshError: The file is damaged.
    """
    kind = place.suffix.lower()
    if not place.exists():
        raise InputError(f"{place} is not there; give a mesh, 3DM, STEP or IGES file, or a folder made by `process`.")
    if place.is_dir():
        if not (place / SURFACE).is_file():
            raise InputError(f"{place} holds no {SURFACE}; run `footscan process RECORDING --object last` first.")
        return LastSource(load_foot_mesh(place), remarks=LAST_REMARKS)
    if kind in (".3dm", *STEP_KINDS, *IGES_KINDS) and unit not in (None, "mm"):
        raise InputError(f"{place} states its unit itself; leave --unit {unit} out.")
    if kind == ".3dm":
        return read_3dm(place)
    if kind in (*STEP_KINDS, *IGES_KINDS):
        return read_cad(place)
    if kind not in MESH_KINDS:
        raise InputError(
            f"{place}: kind {kind or 'without ending'} is not read; allowed are {', '.join(MESH_KINDS)}, "
            ".3dm, .step and .iges."
        )
    return LastSource(load_foot_mesh(place, _unit_of(place, unit)), unit=unit or "mm")


def _unit_of(place: Path, unit: str | None) -> str:
    """The unit that was given; a mesh file does not state one, and nothing is guessed.

    Raises:
        MeshError: None given, with the unit that its size suggests.
    """
    if unit is not None:
        return unit
    xyz = np.asarray(load_foot_mesh(place).vertices, dtype=np.float64)
    extent = float(np.ptp(xyz[np.isfinite(xyz).all(axis=1)], axis=0).max())
    raise MeshError(f"{place} does not say its unit; {likely_unit(extent)}.")
