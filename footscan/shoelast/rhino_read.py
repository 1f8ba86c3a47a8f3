"""Reading a Rhino file (3DM): meshes, surfaces and named curves, in mm by the unit that the file states."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import rhino3dm as _rhino3dm
import trimesh
from scipy.interpolate import BSpline

from footscan.coordinates import Floats, Ints
from footscan.errors import MeshError
from footscan.foot.nurbs import DEGREE
from footscan.geometry.nearest import PointTree
from footscan.shoelast.file_datum import frame_from_points, said_in
from footscan.shoelast.nurbs_out import NurbsPatch
from footscan.shoelast.source import LastSource, joined_lines, line_name
from footscan.shoelast.split_faces import LONGEST_MM
from footscan.shoelast.surface_facets import facets_of

rhino3dm: Any = _rhino3dm  # its type stubs lack what containers and meshes can do

_MM = {"Millimeters": 1.0, "Centimeters": 10.0, "Meters": 1000.0, "Inches": 25.4, "Feet": 304.8, "Microns": 0.001}
_CHORD_MM = 0.02
_EDGE_MM = 0.02
_SAME_BOX_MM = 3.0
_SUBDIVISIONS = 3


@dataclass
class _Found:
    """What was met so far, in the file's unit; `parts` are vertices and triangles."""

    meshes: list[tuple[Floats, Ints]] = field(default_factory=list[tuple[Floats, Ints]])
    surfaces: list[tuple[Floats, Ints]] = field(default_factory=list[tuple[Floats, Ints]])
    curves: list[tuple[str, Floats]] = field(default_factory=list[tuple[str, Floats]])
    patches: dict[str, NurbsPatch] = field(default_factory=dict[str, NurbsPatch])
    bodies: list[tuple[str, trimesh.Trimesh]] = field(default_factory=list[tuple[str, trimesh.Trimesh]])
    points: dict[str, Floats] = field(default_factory=dict[str, Floats])
    remarks: list[str] = field(default_factory=list[str])
    hidden: int = 0
    blocks: int = 0


def read_3dm(path: Path) -> LastSource:
    """Read a 3DM.

    Meshes are taken as they are, surfaces and solids by the meshes that Rhino stored with them, else evaluated when
    they are untrimmed. Where meshes and surfaces show the same body, the meshes count. Hidden objects stay out.

    Raises:
        MeshError: No Rhino file, no unit, no body, or a trimmed surface without a stored mesh.
    """
    model = rhino3dm.File3dm.Read(str(path)) if path.is_file() else None
    if model is None:
        raise MeshError(f"{path} cannot be read as a Rhino file; save it again as 3DM, or as STL with its unit.")
    unit = str(model.Settings.ModelUnitSystem).rpartition(".")[2]
    if unit not in _MM:
        raise MeshError(f"{path} has the unit {unit}; set the model's unit to millimetres in Rhino and save it again.")
    found = _Found()
    for entry in model.Objects:
        if _visible(model, entry):
            _take(path, model, entry, found, _CHORD_MM / _MM[unit])
        else:
            found.hidden += 1
    mm = _MM[unit]
    patches = {name: replace(patch, net_mm=patch.net_mm * mm) for name, patch in found.patches.items()}
    bodies = tuple((name, mesh.apply_scale(mm)) for name, mesh in found.bodies)
    texts = {str(key): str(value) for key, value in (model.Strings[k] for k in range(len(model.Strings)))}
    return replace(_source(path, found, unit), patches=patches, bodies=bodies, said=said_in(texts))


def _visible(model: Any, entry: Any) -> bool:
    layer = model.Layers.FindIndex(entry.Attributes.LayerIndex)
    return bool(entry.Attributes.Visible) and (layer is None or bool(layer.Visible))


def _take(path: Path, model: Any, entry: Any, found: _Found, chord: float) -> None:
    shape, name = entry.Geometry, str(entry.Attributes.Name or "")
    layer = model.Layers.FindIndex(entry.Attributes.LayerIndex)
    layer_name = "" if layer is None else str(layer.Name)
    if isinstance(shape, rhino3dm.Mesh):
        found.meshes.append(_mesh_parts(shape))
        found.bodies.append((name or layer_name, trimesh.Trimesh(*found.meshes[-1], process=False)))
    elif isinstance(shape, rhino3dm.SubD):
        found.surfaces.append(_subd_parts(shape, found))
    elif isinstance(shape, rhino3dm.Extrusion):
        found.surfaces += _brep_parts(path, shape.ToBrep(True), name or layer_name, chord)
    elif isinstance(shape, rhino3dm.Brep):
        found.surfaces += _brep_parts(path, shape, name or layer_name, chord)
        if shape.IsSurface and (patch := _bicubic(name, shape.Faces[0])) is not None:
            found.patches[name] = patch
    elif isinstance(shape, rhino3dm.Surface):
        found.surfaces.append(_surface_parts(shape, chord))
    elif isinstance(shape, rhino3dm.Curve):
        known = line_name(name, layer_name)
        found.curves.append((known or name or f"curve_{len(found.curves) + 1}", _curve_points(shape)))
    elif isinstance(shape, rhino3dm.Point):
        at = shape.Location
        found.points[name] = np.array([at.X, at.Y, at.Z])
    elif isinstance(shape, rhino3dm.InstanceReference):
        found.blocks += 1


def _source(path: Path, found: _Found, unit: str) -> LastSource:
    parts, remarks = found.meshes + found.surfaces, list(found.remarks)
    if found.meshes and found.surfaces and _same_body(found, _MM[unit]):
        parts = found.meshes
        remarks.append(f"{len(found.surfaces)} surfaces show the body of the meshes and were left out")
    if found.hidden:
        remarks.append(f"{found.hidden} hidden objects were left out")
    if found.blocks:
        remarks.append(
            f"{found.blocks} block instances were left out; explode them in Rhino if they belong to the last"
        )
    if not parts:
        raise MeshError(
            f"{path} holds no visible mesh or surface, only {len(found.curves)} curves, {found.hidden} hidden objects "
            f"and {found.blocks} blocks; a last needs surfaces or a mesh: show or explode them in Rhino, save it again."
        )
    starts = np.cumsum([0, *(len(xyz) for xyz, _ in parts)])
    xyz = np.vstack([points for points, _ in parts]) * _MM[unit]
    faces = np.vstack([corners + start for (_, corners), start in zip(parts, starts, strict=False)])
    lines = joined_lines([(name, curve * _MM[unit]) for name, curve in found.curves])
    frame, words = frame_from_points({name: place * _MM[unit] for name, place in found.points.items()})
    mesh = trimesh.Trimesh(xyz, faces, process=False)
    return LastSource(mesh, lines, unit.lower(), (*remarks, *words), states_unit=True, frame=frame)


def _same_body(found: _Found, mm: float) -> bool:
    first, second = (_box(parts) for parts in (found.meshes, found.surfaces))
    return bool(np.abs(first - second).max() * mm <= _SAME_BOX_MM)


def _box(parts: list[tuple[Floats, Ints]]) -> Floats:
    xyz = np.vstack([points for points, _ in parts])
    return np.stack([xyz.min(axis=0), xyz.max(axis=0)])


def _mesh_parts(mesh: Any) -> tuple[Floats, Ints]:
    xyz = np.array([(p.X, p.Y, p.Z) for p in mesh.Vertices.ToPoint3dArray()], dtype=np.float64).reshape(-1, 3)
    corners = np.array([mesh.Faces[k] for k in range(len(mesh.Faces))], dtype=np.int64).reshape(-1, 4)
    quads = corners[corners[:, 2] != corners[:, 3]]
    return xyz, np.vstack([corners[:, :3], quads[:, [0, 2, 3]]])


def _subd_parts(shape: Any, found: _Found) -> tuple[Floats, Ints]:
    shape.Subdivide(_SUBDIVISIONS)
    found.remarks.append(f"a SubD was taken as its net after {_SUBDIVISIONS} subdivisions")
    return _mesh_parts(rhino3dm.Mesh.CreateFromSubDControlNet(shape, False))


def _brep_parts(path: Path, brep: Any, name: str, chord: float) -> list[tuple[Floats, Ints]]:
    parts: list[tuple[Floats, Ints]] = []
    for k in range(len(brep.Faces)):
        face = brep.Faces[k]
        stored = face.GetMesh(rhino3dm.MeshType.Any)
        if stored is not None and len(stored.Faces):
            parts.append(_mesh_parts(stored))
            continue
        surface = face.UnderlyingSurface()
        if not brep.IsSurface and not _untrimmed(brep, face, surface):
            raise MeshError(
                f"{path}: face {k + 1} of {name or 'a solid'} is trimmed and has no stored mesh; save the file in "
                "Rhino with its shaded meshes (not as small file), or export the last as STL or STEP."
            )
        xyz, faces = _surface_parts(surface, chord)
        parts.append((xyz, faces[:, ::-1] if face.OrientationIsReversed else faces))
    return parts


def _untrimmed(brep: Any, face: Any, surface: Any) -> bool:
    """Whether all edges of a face run along the border of its surface."""
    if len(face.Loops) != 1:
        return False
    trims = face.OuterLoop.Trims
    edges = {trims[k].EdgeIndex for k in range(len(trims))} - {-1}
    points = np.vstack([_sampled(brep.Edges[edge], 33) for edge in edges])
    grid = _evaluator(surface)[0](np.linspace(0.0, 1.0, 2049), np.linspace(0.0, 1.0, 2049), border=True)
    size = float(np.ptp(grid, axis=0).max())
    return bool(PointTree(grid).nearest(points, 1)[0].max() <= max(_EDGE_MM, 1e-3 * size))


def _surface_parts(surface: Any, chord: float) -> tuple[Floats, Ints]:
    """A whole surface as triangles within the chord error."""
    evaluate, breaks = _evaluator(surface)
    return facets_of(evaluate, breaks, chord, chord * LONGEST_MM / _CHORD_MM)


def _bicubic(name: str, face: Any) -> NurbsPatch | None:
    """A surface as the patches of a last are; None for other degrees, weights, or a face that looks inward."""
    nurbs = face.UnderlyingSurface().ToNurbsSurface()
    net, knots, degrees = _net_and_knots(nurbs)
    plain = degrees == (DEGREE, DEGREE) and np.ptp(net[..., 3]) == 0.0 and net[0, 0, 3] == 1.0
    if not plain or face.OrientationIsReversed:
        return None
    u, v = ((each - each[DEGREE]) / (each[-DEGREE - 1] - each[DEGREE]) for each in knots)
    return NurbsPatch(name, np.ascontiguousarray(net[..., :3]), np.clip(u, 0.0, 1.0), np.clip(v, 0.0, 1.0))


def _net_and_knots(nurbs: Any) -> tuple[Floats, list[Floats], tuple[int, int]]:
    """Weighted control points `(n, m, 4)`, all knots both ways, and degrees."""
    count_u, count_v = nurbs.Points.CountU, nurbs.Points.CountV
    raw = [nurbs.Points[i, j] for i in range(count_u) for j in range(count_v)]
    net = np.array([(p.X, p.Y, p.Z, p.W) for p in raw])  # Rhino keeps them weighted
    knots = [_full_knots(list(each)) for each in (nurbs.KnotsU.ToList(), nurbs.KnotsV.ToList())]
    return net.reshape(count_u, count_v, 4), knots, (nurbs.Degree(0), nurbs.Degree(1))


def _evaluator(surface: Any) -> tuple[Any, tuple[Floats, Floats]]:
    """A function of two parameters on 0..1 that gives points, and the ends of the spans both ways."""
    net, knots, degrees = _net_and_knots(surface.ToNurbsSurface())
    ends = [(k[p], k[len(k) - p - 1]) for k, p in zip(knots, degrees, strict=True)]

    def at(share: Floats, way: int) -> Floats:
        low, high = ends[way]
        return low + (high - low) * share

    def evaluate(u: Floats, v: Floats, border: bool = False) -> Floats:
        if border:
            sides = [(u[[0, -1]], v), (u, v[[0, -1]])]
            return np.vstack([evaluate(*side).reshape(-1, 3) for side in sides])
        along = BSpline(knots[0], net, degrees[0], axis=0)(at(u, 0))
        weighted = BSpline(knots[1], along, degrees[1], axis=1)(at(v, 1))
        return weighted[..., :3] / weighted[..., 3:]

    first, second = (np.unique((k - low) / (high - low)) for k, (low, high) in zip(knots, ends, strict=True))
    return evaluate, (first[(first >= 0.0) & (first <= 1.0)], second[(second >= 0.0) & (second <= 1.0)])


def _full_knots(knots: list[float]) -> Floats:
    """Rhino leaves the first and the last knot out; their values are of no effect."""
    return np.array([knots[0], *knots, knots[-1]], dtype=np.float64)


def _curve_points(curve: Any) -> Floats:
    """A polyline's own corners; else points so dense that the chord error is far below the fit of a last."""
    if curve.IsPolyline():
        return np.array([(p.X, p.Y, p.Z) for p in curve.TryGetPolyline()], dtype=np.float64)
    return _sampled(curve, int(np.clip(24 * curve.SpanCount, 96, 4096)) + 1)


def _sampled(curve: Any, count: int) -> Floats:
    low, high = curve.Domain.T0, curve.Domain.T1
    points = [curve.PointAt(t) for t in np.linspace(low, high, count).tolist()]
    return np.array([(p.X, p.Y, p.Z) for p in points], dtype=np.float64)
