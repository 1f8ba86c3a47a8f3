"""Reading a foot from disk: any mesh file in any unit, or a folder made by `footscan process`."""

from contextlib import suppress
from pathlib import Path

import trimesh

from footscan.errors import MeshError
from footscan.foot.surface_files import load_surface_ply
from footscan.foot.units import mm_from_unit

KINDS = (".stl", ".ply", ".obj", ".off", ".glb", ".3mf")
SURFACE = "surface.ply"
_STL_HEADER_BYTES, _STL_TRIANGLE_BYTES, _STL_END_BYTES = 84, 50, 4096
_TEXT = frozenset(range(32, 127)) | frozenset(b"\t\r\n")


def load_foot_mesh(path: Path, unit: str = "mm") -> trimesh.Trimesh:
    """Read a foot, in mm.

    Args:
        path: A mesh file, or a folder that holds a `surface.ply` (then the origin of the skin comes with it).
        unit: Of a mesh file: mm, cm, m or in; a folder is always in mm.

    Raises:
        MeshError: Nothing there, or nothing that can be read as a mesh.
    """
    factor = mm_from_unit(unit)
    if path.is_dir():
        return load_surface_ply(path / SURFACE)
    if not path.is_file():
        raise MeshError(f"{path}: not there; give a mesh file ({', '.join(KINDS)}) or a folder made by `process`")
    if path.name == SURFACE and unit == "mm":
        with suppress(MeshError):  # another program's file of that name: read like any mesh, without an origin
            return load_surface_ply(path)
    return _load_any(path).apply_scale(factor)


def _load_any(path: Path) -> trimesh.Trimesh:
    if path.suffix.lower() not in KINDS:
        raise MeshError(f"{path}: kind {path.suffix or 'without ending'} is not read; allowed are {', '.join(KINDS)}")
    if path.stat().st_size == 0:
        raise MeshError(f"{path}: is empty (0 bytes); copy or export it again")
    if path.suffix.lower() == ".stl":
        _refuse_cut_stl(path)
    try:
        mesh = trimesh.load(path, force="mesh", process=False)
    except Exception as error:
        raise MeshError(
            f"{path}: cannot be read as a mesh ({error}): cut off, damaged or another kind of file; export it again"
        ) from error
    if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
        raise MeshError(f"{path}: holds no triangles; a mesh is needed, not a cloud, a drawing or text")
    return mesh


def _refuse_cut_stl(path: Path) -> None:
    """Refuse a binary STL that is shorter than its header says, and a text one without triangles or end."""
    size = path.stat().st_size
    with path.open("rb") as stream:
        start = stream.read(_STL_HEADER_BYTES)
        stream.seek(max(size - _STL_END_BYTES, 0))
        end = stream.read()
    count = int.from_bytes(start[80:84], "little")
    held = max(size - _STL_HEADER_BYTES, 0) // _STL_TRIANGLE_BYTES
    if len(start) == _STL_HEADER_BYTES and held >= count:
        return
    if start.lstrip().lower().startswith(b"solid"):
        if b"endsolid" not in end.lower():
            raise MeshError(f"{path}: cut off: a text STL ends with the word endsolid; copy or export it again")
        return
    if all(byte in _TEXT for byte in start):
        raise MeshError(f"{path}: is text, but no STL; export the mesh again")
    if len(start) < _STL_HEADER_BYTES:
        raise MeshError(f"{path}: cut off: {size} bytes, an STL has at least 84; copy or export it again")
    raise MeshError(f"{path}: cut off: the header counts {count} triangles, it holds {held}; copy or export it again")
