"""A last leaves: one function for every kind of file, with what was asked for and what was found when looking back."""

import datetime
from dataclasses import dataclass, replace
from pathlib import Path

import footscan
from footscan.errors import InputError
from footscan.shoelast.bottom_pattern import bottom_pattern
from footscan.shoelast.cad_file import IGES_KINDS, STEP_KINDS, save_last_cad
from footscan.shoelast.dimensions import dimensions
from footscan.shoelast.drawing import SPACING_MM, save_last_dxf
from footscan.shoelast.engraving import engrave
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.family_index import member_of_id
from footscan.shoelast.handed import mirrored_mesh
from footscan.shoelast.last_library import LastLibrary
from footscan.shoelast.mesh_out import OutMesh, Stub, mesh_of_last, save_last_mesh
from footscan.shoelast.model import Shoelast
from footscan.shoelast.nurbs_out import load_last_json, save_last_json
from footscan.shoelast.rhino_file import save_last_3dm
from footscan.workflow.lasts_sheet import Paper, SheetHead, save_sheet

MESH_KINDS = (".stl", ".obj", ".ply")
KINDS = (*MESH_KINDS, ".3dm", *STEP_KINDS, *IGES_KINDS, ".dxf", ".json", ".pdf")
CUSTOM = "custom.json"
_ENGRAVED = (*MESH_KINDS, ".3dm")
_APART = (".obj", ".3dm")


@dataclass(frozen=True)
class ExportWish:
    """What is asked for.

    Attributes:
        stub: Give the chuck stub back: joined to the last in STL and PLY, a body of its own in OBJ and 3DM.
        stub_apart: Keep it apart in STL and PLY too.
        engrave: Text for the cone top, or empty.
        sheet: Paper of the last maker's sheet, None for none; a file ending in pdf is the sheet itself.
        order: What the sheet and the heads of files call the order; no patient's name belongs there.
    """

    stub: bool = False
    stub_apart: bool = False
    engrave: str = ""
    sheet: Paper | None = None
    order: str = ""


@dataclass(frozen=True)
class Exported:
    """The files written, and what was found, in words."""

    files: tuple[Path, ...]
    found: tuple[str, ...]


def load_custom(folder: Path) -> Shoelast:
    """The last in a folder made by `lasts customise`.

    Raises:
        MeshError: None there, or damaged.
    """
    return load_last_json(folder / CUSTOM)


def last_to_export(library: LastLibrary, what: str, stub: bool) -> Shoelast:
    """The last that a command names: an id of the library, or a folder made by `lasts customise`.

    A built-in last is built with a chuck stub when one is wanted.

    Raises:
        InputError: No such id, or a damaged file.
        MeshError: The folder holds no customised last, or a damaged one.
    """
    folder = Path(what)
    if (folder / CUSTOM).is_file() or (folder.is_dir() and not library.versions(what)):
        return load_custom(folder)
    member = member_of_id(what) if stub and not library.versions(what) else None
    if member is None:
        return library.load(what)
    kind = (member.style, member.size_eu, member.fitting, member.pitch_mm, member.toe, member.side)
    return build_shoelast(*kind, stub=True)


def export_last(shoelast: Shoelast, path: Path, wish: ExportWish | None = None) -> Exported:
    """Write a last; the ending of `path` says as what.

    Raises:
        InputError: An ending that is not known, or a wish that this kind of file cannot hold.
        MeshError: A stub was asked for and there is none, or it does not touch.
        QualityError: What was written, read back, is not the last.
        StorageError: The place cannot be written.
    """
    asked, kind = wish or ExportWish(), path.suffix.lower()
    _check(path, kind, asked)
    if kind == ".pdf":
        return _sheet(shoelast, path, asked)
    found = _write(shoelast, path, kind, asked)
    if asked.sheet is None:
        return Exported((path,), found)
    beside = _sheet(shoelast, path.with_suffix(".pdf"), asked)
    return Exported((path, *beside.files), (*found, *beside.found))


def _check(path: Path, kind: str, asked: ExportWish) -> None:
    if kind not in KINDS:
        allowed = ", ".join(each[1:] for each in KINDS)
        raise InputError(f"{path}: kind {kind or 'without ending'} is not written; allowed are {allowed}.")
    if asked.engrave and kind not in _ENGRAVED:
        raise InputError(f"{kind[1:]} cannot hold an engraved text; engrave stl, obj, ply or 3dm.")
    if asked.stub and kind not in _ENGRAVED:
        raise InputError(f"{kind[1:]} cannot hold the stub, which is a mesh; give it back with stl, obj, ply or 3dm.")


def _write(shoelast: Shoelast, path: Path, kind: str, asked: ExportWish) -> tuple[str, ...]:
    note = note_of(shoelast, asked.order)
    if kind in MESH_KINDS:
        return _mesh(shoelast, path, asked, note)
    if kind == ".3dm":
        return _rhino(shoelast, path, asked, note)
    if kind in (*STEP_KINDS, *IGES_KINDS):
        check = save_last_cad(shoelast, path, note)
        body = "one closed solid" if kind in STEP_KINDS else "surfaces that sew into one closed body"
        return (
            f"read back: {check.faces} faces, {body}, {check.deviation_mm:.1e} mm from the last at most, "
            f"{check.volume_mm3 / 1000.0:.1f} cm3",
        )
    if kind == ".dxf":
        save_last_dxf(shoelast, path, note)
        stretch = bottom_pattern(shoelast).edge_stretch
        return (f"sections every {SPACING_MM:.0f} mm, bottom in plan and laid flat (edge {stretch:+.2%})",)
    save_last_json(shoelast, path)
    return ("three NURBS surfaces, lines and points",)


def note_of(shoelast: Shoelast, order: str = "") -> str:
    """One line about a last for heads of files."""
    size = "" if shoelast.size_eu is None else f", EU {shoelast.size_eu:g}"
    fitting = f" {shoelast.fitting}" if shoelast.fitting else ""
    return f"{order + ': ' if order else ''}{shoelast.name}, {shoelast.side}{size}{fitting}"


def _mesh(shoelast: Shoelast, path: Path, asked: ExportWish, note: str) -> tuple[str, ...]:
    apart = asked.stub_apart or path.suffix.lower() in _APART
    stub: Stub = ("separate" if apart else "joined") if asked.stub else "without"
    out = mesh_of_last(shoelast, stub)
    out, said = _engraved(out, shoelast, asked.engrave)
    save_last_mesh(out, path, note)
    faces = sum(len(mesh.faces) for mesh in out.bodies.values())
    bodies = " and ".join(out.bodies)
    return (f"{faces} triangles ({bodies}), within {out.chord_error_mm:.3f} mm of the surface", *said)


def _engraved(out: OutMesh, shoelast: Shoelast, text: str) -> tuple[OutMesh, tuple[str, ...]]:
    if not text:
        return out, ()
    body, cut = engrave(out.bodies["last"], shoelast, text)
    said = f"engraved {cut.text!r}, capitals {cut.cap_height_mm:.1f} mm high, 0.6 mm deep"
    return replace(out, bodies=out.bodies | {"last": body}), (said,)


def _rhino(shoelast: Shoelast, path: Path, asked: ExportWish, note: str) -> tuple[str, ...]:
    stubs = [each for each in shoelast.attachments if each.kind == "stub"] if asked.stub else []
    if asked.stub and not stubs:
        mesh_of_last(shoelast, "separate")
    meshes = {
        f"stub{'' if k == 1 else f'_{k}'}": mirrored_mesh(each.mesh, shoelast.side) for k, each in enumerate(stubs, 1)
    }
    said: tuple[str, ...] = ()
    if asked.engrave:
        out, said = _engraved(mesh_of_last(shoelast), shoelast, asked.engrave)
        meshes["engraved_mesh"] = out.bodies["last"]
    save_last_3dm(shoelast, path, note, meshes)
    layers = ["three NURBS surfaces", f"{len(shoelast.lines)} named curves", *meshes]
    return (", ".join(layers), *said)


def _sheet(shoelast: Shoelast, path: Path, asked: ExportWish) -> Exported:
    paper: Paper = asked.sheet or "a3"
    values = {name: (one.value, one.unit) for name, one in dimensions(shoelast).items()}
    head = SheetHead(asked.order, datetime.datetime.now().astimezone().strftime("%Y-%m-%d"), footscan.__version__)
    count = save_sheet(shoelast, values, path, head, paper)
    return Exported((path,), (f"sheet at 1:1 on {paper.upper()}, {count} pages; check both 100 mm bars on the print",))
