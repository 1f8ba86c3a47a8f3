"""A last as a Rhino file (3DM, mm): three NURBS surfaces, named curves and points on layers, stub and meshes."""

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import rhino3dm as _rhino3dm
import trimesh

from footscan.config.toml_file import write_whole
from footscan.coordinates import Floats
from footscan.errors import StorageError
from footscan.foot.nurbs import DEGREE
from footscan.shoelast.file_datum import DATUM_POINTS, LAYER, said_of
from footscan.shoelast.handed import DATUM, mirrored
from footscan.shoelast.model import Shoelast
from footscan.shoelast.nurbs_out import NurbsPatch, clamped_patches

EXACT_LINES = ("feather_edge", "cone_edge", "back_line")
"""Lines that lie on edges of the upper and leave as exact NURBS curves."""

rhino3dm: Any = _rhino3dm  # its type stubs lack what containers and meshes can do

_VERSION = 7  # the oldest Rhino that most last makers still run
_TOLERANCE_MM = 0.001
_COLOURS = {
    "upper": (205, 170, 125),
    "bottom": (150, 110, 70),
    "cone_top": (150, 110, 70),
    "feather_edge": (200, 30, 30),
    "cone_edge": (30, 90, 200),
    "back_line": (20, 140, 60),
    "ball_break_line": (190, 120, 0),
}


def save_last_3dm(
    shoelast: Shoelast, path: Path, note: str, meshes: Mapping[str, trimesh.Trimesh] | None = None
) -> None:
    """Write a last as 3DM.

    Layers: upper, bottom, cone_top (NURBS, normals outward), one for every named line, points, and one for every mesh.
    Feather edge, cone edge and back line are the surfaces' own edges; the other lines are polylines. Three points on
    the layer `datum` are the frame, the file's texts say style, size and fitting: the last comes back as it was.

    Args:
        shoelast: Any last.
        path: Where to.
        note: About the last; it stands in the file's notes beside the datum.
        meshes: Bodies that are no NURBS (stub, an engraved copy), real handedness, mm.

    Raises:
        StorageError: The place cannot be written.
    """
    model = rhino3dm.File3dm()
    model.ApplicationName = "footscan"
    model.Settings.ModelUnitSystem = rhino3dm.UnitSystem.Millimeters
    model.Settings.ModelAbsoluteTolerance = _TOLERANCE_MM
    model.Strings.__setitem__("footscan", note)
    model.Strings.__setitem__("datum", DATUM)
    for key, value in said_of(shoelast).items():
        model.Strings.__setitem__(key, value)
    patches = clamped_patches(shoelast)
    for patch in patches:
        body = rhino3dm.Brep.CreateFromSurface(rhino_surface(patch))
        model.Objects.AddBrep(body, _on_layer(model, patch.name))
    for name, curve in _curves(shoelast, patches[0]).items():
        model.Objects.AddCurve(curve, _on_layer(model, name))
    for name, point in shoelast.points.items():
        x, y, z = mirrored(point, shoelast.side).tolist()
        model.Objects.AddPoint(rhino3dm.Point3d(x, y, z), _on_layer(model, "points", name))
    for name, place in DATUM_POINTS.items():
        model.Objects.AddPoint(rhino3dm.Point3d(*place), _on_layer(model, LAYER, name))
    for name, mesh in (meshes or {}).items():
        model.Objects.AddMesh(rhino_mesh(mesh), _on_layer(model, name))
    _write(model, path)


def _write(model: Any, path: Path) -> None:
    with tempfile.TemporaryDirectory(prefix="footscan-3dm-") as folder:
        written = Path(folder) / "last.3dm"
        if not model.Write(str(written), _VERSION):
            raise StorageError(f"{path} could not be written (rhino3dm refused); free space in {folder}.")
        write_whole(path, written.read_bytes())


def _on_layer(model: Any, layer: str, name: str = "") -> Any:
    """Attributes of an object on a layer, which is made at its first use; the object bears the layer's name or its
    own."""
    known = model.Layers.FindName(layer, "")
    attributes = rhino3dm.ObjectAttributes()
    attributes.Name = name or layer
    attributes.LayerIndex = model.Layers.AddLayer(layer, _colour(layer)) if known is None else known.Index
    return attributes


def _colour(layer: str) -> tuple[int, int, int, int]:
    return (*_COLOURS.get(layer, (90, 90, 90)), 255)


def rhino_surface(patch: NurbsPatch) -> Any:
    """A patch as Rhino holds it: knots without the first and the last."""
    count_u, count_v = patch.net_mm.shape[:2]
    surface = rhino3dm.NurbsSurface.Create(3, False, DEGREE + 1, DEGREE + 1, count_u, count_v)
    for k, knot in enumerate(patch.knots_u[1:-1].tolist()):
        surface.KnotsU[k] = knot
    for k, knot in enumerate(patch.knots_v[1:-1].tolist()):
        surface.KnotsV[k] = knot
    for i, row in enumerate(patch.net_mm.tolist()):
        for j, (x, y, z) in enumerate(row):
            surface.Points[i, j] = rhino3dm.Point4d(x, y, z, 1.0)
    return surface


def _curves(shoelast: Shoelast, upper: NurbsPatch) -> dict[str, Any]:
    curves: dict[str, Any] = {
        "feather_edge": _curve(upper.net_mm[:, 0], upper.knots_u),
        "cone_edge": _curve(upper.net_mm[:, -1], upper.knots_u),
        "back_line": _curve(upper.net_mm[0], upper.knots_v),
    }
    for name, line in shoelast.lines.items():
        if name not in curves:
            curves[name] = _polyline(mirrored(line, shoelast.side))
    return curves


def _curve(net_mm: Floats, knots: Floats) -> Any:
    curve = rhino3dm.NurbsCurve.Create(False, DEGREE, [rhino3dm.Point3d(x, y, z) for x, y, z in net_mm.tolist()])
    for k, knot in enumerate(knots[1:-1].tolist()):
        curve.Knots[k] = knot
    return curve


def _polyline(xyz: Floats) -> Any:
    return rhino3dm.PolylineCurve(rhino3dm.Point3dList([rhino3dm.Point3d(x, y, z) for x, y, z in xyz.tolist()]))


def rhino_mesh(mesh: trimesh.Trimesh) -> Any:
    """Triangles as Rhino holds them."""
    out = rhino3dm.Mesh()
    for x, y, z in np.asarray(mesh.vertices, dtype=np.float64).tolist():
        out.Vertices.Add(x, y, z)
    for a, b, c in np.asarray(mesh.faces).tolist():
        out.Faces.AddFace(a, b, c)
    out.Normals.ComputeNormals()
    return out
