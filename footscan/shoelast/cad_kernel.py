"""The only door to OCP (Open CASCADE 8, the extra `cad`): solids from patches, STEP and IGES files, triangles.

OCP 8 differs from 7: `TColgp` and `TColStd` arrays are `OCP.collections.Array...`, and functions with several results
return tuples. It has no usable types, hence `Any`.
"""

import importlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from footscan.coordinates import Floats, Ints
from footscan.errors import InputError, MeshError, StorageError
from footscan.foot.nurbs import DEGREE
from footscan.shoelast.nurbs_out import NurbsPatch

INSTALL = 'pip install "footscan[cad]"'
_SEW_MM = 1e-5
_DEGENERATE_MM = 1e-7
_VOLUME_RELATIVE = 1e-6


def _ocp(module: str) -> Any:
    """A module of OCP.

    Raises:
        InputError: The extra is not installed.
    """
    try:
        return importlib.import_module(f"OCP.{module}")
    except ImportError as err:
        raise InputError(
            f"STEP and IGES need the CAD kernel OCP, which is not installed ({err}); install it with {INSTALL}, "
            "or use 3dm, stl, obj or ply."
        ) from err


def _silence() -> None:
    """Take OCP's printers away: it writes its progress to standard output, where results belong."""
    message = _ocp("Message")
    message.Message.DefaultMessenger_s().RemovePrinters(message.Message_Printer.get_type_descriptor_s())


@dataclass(frozen=True)
class Body:
    """What is known of a shape: `faces`, `free_edges` (0 when closed), `valid` (OCP's own check), `volume_mm3`."""

    faces: int
    free_edges: int
    valid: bool
    volume_mm3: float


def solid_from_patches(patches: Sequence[NurbsPatch]) -> Any:
    """Sew patches whose edges coincide into a closed solid.

    Raises:
        MeshError: They do not close.
    """
    build = _ocp("BRepBuilderAPI")
    sewing = build.BRepBuilderAPI_Sewing(_SEW_MM)
    for patch in patches:
        sewing.Add(build.BRepBuilderAPI_MakeFace(_surface(patch), _DEGENERATE_MM).Face())
    sewing.Perform()
    shell = sewing.SewedShape()
    if sewing.NbFreeEdges() or shell.ShapeType() != _ocp("TopAbs").TopAbs_ShapeEnum.TopAbs_SHELL:
        raise MeshError(f"the patches of the last leave {sewing.NbFreeEdges()} open edges; import the last again.")
    solid = build.BRepBuilderAPI_MakeSolid(_ocp("TopoDS").TopoDS.Shell(shell)).Solid()
    _ocp("BRepLib").BRepLib.OrientClosedSolid_s(solid)
    return solid


def _surface(patch: NurbsPatch) -> Any:
    arrays, point = _ocp("collections"), _ocp("gp").gp_Pnt
    count_u, count_v = patch.net_mm.shape[:2]
    poles = arrays.Array2_gp_Pnt(1, count_u, 1, count_v)
    for i, row in enumerate(patch.net_mm.tolist(), 1):
        for j, (x, y, z) in enumerate(row, 1):
            poles.SetValue(i, j, point(x, y, z))
    (knots_u, times_u), (knots_v, times_v) = _knots(patch.knots_u), _knots(patch.knots_v)
    return _ocp("Geom").Geom_BSplineSurface(poles, knots_u, knots_v, times_u, times_v, DEGREE, DEGREE)


def _knots(knots: Floats) -> tuple[Any, Any]:
    """Values and multiplicities; 14 digits join knots that are equal but for rounding."""
    arrays = _ocp("collections")
    values, times = np.unique(np.round(knots, 14), return_counts=True)
    out, counts = arrays.Array1_double(1, len(values)), arrays.Array1_int(1, len(values))
    for k, (value, count) in enumerate(zip(values.tolist(), times.tolist(), strict=True), 1):
        out.SetValue(k, value)
        counts.SetValue(k, count)
    return out, counts


def write_step(solid: Any, path: Path, name: str, description: str, face_names: Sequence[str]) -> None:
    """Write a solid as STEP AP214 in mm.

    Args:
        solid: From `solid_from_patches`.
        path: Where to.
        name: Of the product.
        description: One line for the head of the file.
        face_names: In the order of the faces.

    Raises:
        StorageError: OCP refused.
    """
    control, select = _ocp("STEPControl"), _ocp("IFSelect")
    _silence()
    writer = control.STEPControl_Writer()
    _set_text(("write.step.schema", "AP214IS"), ("write.step.unit", "MM"), ("write.step.product.name", name))
    done = writer.Transfer(solid, control.STEPControl_StepModelType.STEPControl_AsIs)
    text = _ocp("TCollection").TCollection_HAsciiString
    process = writer.WS().TransferWriter().FinderProcess()
    for face, face_name in zip(_parts(solid, "FACE"), face_names, strict=True):
        item = _ocp("STEPConstruct").STEPConstruct.FindEntity_s(process, face)
        if item is not None:
            item.SetName(text(face_name))
    head = _ocp("APIHeaderSection").APIHeaderSection_MakeHeader(writer.Model())
    head.SetName(text(name))
    head.SetDescriptionValue(1, text(description))
    head.SetOriginatingSystem(text("footscan"))
    if done != select.IFSelect_RetDone or writer.Write(str(path)) != select.IFSelect_RetDone:
        raise StorageError(f"{path} could not be written as STEP; free space or choose another place.")


def write_iges(solid: Any, path: Path, name: str) -> None:
    """Write a solid as IGES trimmed surfaces (entities 144 over 128), which every CAM program reads, in mm.

    Raises:
        StorageError: OCP refused.
    """
    iges = _ocp("IGESControl")
    _silence()
    iges.IGESControl_Controller.Init_s()
    _set_text(("write.iges.header.product", name), ("write.iges.header.author", "footscan"))
    writer = iges.IGESControl_Writer("MM", 0)
    added = writer.AddShape(solid)
    writer.ComputeModel()
    if not added or not writer.Write(str(path)):
        raise StorageError(f"{path} could not be written as IGES; free space or choose another place.")


def _set_text(*settings: tuple[str, str]) -> None:
    static = _ocp("Interface").Interface_Static
    for key, value in settings:
        static.SetCVal_s(key, value)


@dataclass(frozen=True)
class CadFile:
    """A shape read from a file (mm), and the names of its faces and loose edges as far as the file gives any."""

    shape: Any
    names: Any

    def name_of(self, part: Any) -> str:
        """The name of a face or edge, or an empty text."""
        entity = self.names.EntityFromShapeResult(part, 1)
        for reader in ("Name", "NameValue", "ShortLabel"):
            text = getattr(entity, reader)() if hasattr(entity, reader) else None
            if text is not None:
                return str(text.ToCString()).strip()
        return ""


def read_cad_file(path: Path) -> CadFile:
    """Read a STEP or IGES file; OCP turns its unit into mm.

    Raises:
        InputError: The extra is not installed.
        MeshError: It cannot be read or is empty.
    """
    step = path.suffix.lower() in {".step", ".stp"}
    control, kind = ("STEPControl", "STEP") if step else ("IGESControl", "IGES")
    module = _ocp(control)
    _silence()
    reader = getattr(module, f"{control}_Reader")()
    known = path.is_file() and reader.ReadFile(str(path)) == _ocp("IFSelect").IFSelect_RetDone
    if known:
        reader.TransferRoots()
    shape = reader.OneShape() if known else None
    if shape is None or shape.IsNull():
        raise MeshError(f"{path} cannot be read as {kind}, or holds no surface; export it again, or as STL.")
    return CadFile(shape, reader.WS().TransferReader())


def _parts(shape: Any, kind: str, outside: str | None = None) -> Iterator[Any]:
    """Faces or edges of a shape; with `outside`, those that lie in no such part."""
    kinds, top = _ocp("TopAbs").TopAbs_ShapeEnum, _ocp("TopoDS").TopoDS
    arguments = [getattr(kinds, f"TopAbs_{word}") for word in (kind, outside) if word]
    walk = _ocp("TopExp").TopExp_Explorer(shape, *arguments)
    while walk.More():
        yield getattr(top, kind.capitalize())(walk.Current())
        walk.Next()


def face_grids(shape: Any, share: Floats) -> list[Floats]:
    """Points `(m, m, 3)` of the surface of every face at shares `(m,)` of its own parameters."""
    tool, grids = _ocp("BRep").BRep_Tool, []
    for face in _parts(shape, "FACE"):
        surface = tool.Surface_s(face)
        low_u, high_u, low_v, high_v = surface.Bounds()
        values = [
            surface.Value(low_u + (high_u - low_u) * u, low_v + (high_v - low_v) * v)
            for u in share.tolist()
            for v in share.tolist()
        ]
        grids.append(np.array([(p.X(), p.Y(), p.Z()) for p in values]).reshape(len(share), len(share), 3))
    return grids


def body_of(shape: Any, sew_mm: float) -> Body:
    """Sew what lies within `sew_mm`, and look at it."""
    sewing = _ocp("BRepBuilderAPI").BRepBuilderAPI_Sewing(sew_mm)
    sewing.Add(shape)
    sewing.Perform()
    mass = _ocp("GProp").GProp_GProps()
    _ocp("BRepGProp").BRepGProp.VolumeProperties_s(shape, mass, _VOLUME_RELATIVE)
    valid = bool(_ocp("BRepCheck").BRepCheck_Analyzer(shape).IsValid())
    return Body(sum(1 for _ in _parts(shape, "FACE")), int(sewing.NbFreeEdges()), valid, float(mass.Mass()))


def sewn(shape: Any, sew_mm: float) -> Any:
    """The shape with faces joined that lie within `sew_mm`, so that they are meshed on common edges."""
    sewing = _ocp("BRepBuilderAPI").BRepBuilderAPI_Sewing(sew_mm)
    sewing.Add(shape)
    sewing.Perform()
    return sewing.SewedShape()


def triangles_of(shape: Any, chord_mm: float, turn_rad: float) -> tuple[Floats, Ints]:
    """Mesh every face; vertices on edges are not merged.

    Returns:
        `(n, 3)` mm and `(m, 3)` counter-clockwise seen from outside.
    """
    _ocp("BRepMesh").BRepMesh_IncrementalMesh(shape, chord_mm, False, turn_rad, True)
    tool, location_of = _ocp("BRep").BRep_Tool, _ocp("TopLoc").TopLoc_Location
    backward = _ocp("TopAbs").TopAbs_Orientation.TopAbs_REVERSED
    points, corners, begin = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
    for face in _parts(shape, "FACE"):
        place = location_of()
        mesh = tool.Triangulation_s(face, place)
        if mesh is None:
            continue
        move = place.Transformation()
        nodes = [mesh.Node(k).Transformed(move) for k in range(1, mesh.NbNodes() + 1)]
        three = np.array([mesh.Triangle(k).Get() for k in range(1, mesh.NbTriangles() + 1)], dtype=np.int64) - 1
        points.append(np.array([(p.X(), p.Y(), p.Z()) for p in nodes]))
        corners.append((three[:, ::-1] if face.Orientation() == backward else three) + begin)
        begin += len(nodes)
    return np.vstack(points), np.vstack(corners)


def loose_curves(file: CadFile, chord_mm: float, turn_rad: float) -> list[tuple[str, Floats]]:
    """Names and `(n, 3)` polylines of the edges that belong to no face."""
    adaptor, deflection = _ocp("BRepAdaptor").BRepAdaptor_Curve, _ocp("GCPnts").GCPnts_TangentialDeflection
    curves: list[tuple[str, Floats]] = []
    for edge in _parts(file.shape, "EDGE", outside="FACE"):
        points = deflection(adaptor(edge), turn_rad, chord_mm)
        values = [points.Value(k) for k in range(1, points.NbPoints() + 1)]
        curves.append((file.name_of(edge), np.array([(p.X(), p.Y(), p.Z()) for p in values])))
    return curves
