"""surface.stl, surface.ply and surface.json: the foot as others read it."""

import json
import struct
from pathlib import Path

import numpy as np
import trimesh
from geomdl import NURBS

from footscan.config.toml_file import write_whole
from footscan.coordinates import Floats
from footscan.errors import MeshError
from footscan.foot.nurbs import DEGREE, SplineTube

_STL_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_PLY_VERTEX = np.dtype(
    [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("origin", "u1"), ("sheets", "u1"), ("residual_mm", "<f4")]
)
_PLY_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
_PLY_TYPES = {"<f4": "float", "|u1": "uchar"}
_DELTA = 0.02  # geomdl's default step of evaluation


def save_surface_stl(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write a mesh as binary STL in mm.

    Raises:
        StorageError: The place cannot be written.
    """
    rows = np.zeros(len(mesh.faces), _STL_FACET)
    rows["corners"] = mesh.triangles
    rows["normal"] = mesh.face_normals
    write_whole(path, b"footscan foot surface, mm".ljust(80) + struct.pack("<I", len(rows)) + rows.tobytes())


def save_surface_ply(mesh: trimesh.Trimesh, path: Path, comment: str) -> None:
    """Write a mesh of `mesh_from_surface` as binary PLY with `origin`, `sheets` and `residual_mm` per vertex.

    Raises:
        StorageError: The place cannot be written.
    """
    rows = np.zeros(len(mesh.vertices), _PLY_VERTEX)
    for k, name in enumerate("xyz"):
        rows[name] = mesh.vertices[:, k]
    for name in ("origin", "sheets", "residual_mm"):
        rows[name] = mesh.vertex_attributes[name]
    faces = np.zeros(len(mesh.faces), _PLY_FACE)
    faces["count"], faces["corners"] = 3, mesh.faces
    properties = [f"property {_PLY_TYPES[_PLY_VERTEX[name].str]} {name}" for name in _PLY_VERTEX.names or ()]
    lines = ["ply", "format binary_little_endian 1.0", f"comment {comment}", f"element vertex {len(rows)}", *properties]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    write_whole(path, "\n".join(lines).encode("ascii", "replace") + rows.tobytes() + faces.tobytes())


def load_surface_ply(path: Path) -> trimesh.Trimesh:
    """Read a surface.ply back with its `vertex_attributes` (origin, sheets, residual_mm).

    Raises:
        MeshError: Missing, cut, or another kind of PLY.
    """
    try:
        head, body = path.read_bytes().split(b"end_header\n", 1)
    except (OSError, ValueError) as err:
        raise MeshError(f"{path} is no surface.ply of footscan ({err}); process the recording again") from err
    counts = [int(line.split()[2]) for line in head.decode("ascii", "replace").splitlines() if line[:7] == "element"]
    if len(counts) != 2 or len(body) != counts[0] * _PLY_VERTEX.itemsize + counts[1] * _PLY_FACE.itemsize:
        raise MeshError(f"{path} is no surface.ply of footscan, or it is cut; process the recording again")
    rows = np.frombuffer(body, _PLY_VERTEX, counts[0])
    faces = np.frombuffer(body, _PLY_FACE, counts[1], offset=rows.nbytes)
    xyz = np.column_stack([rows[name] for name in "xyz"]).astype(np.float64)
    mesh = trimesh.Trimesh(xyz, faces["corners"].astype(np.int64), process=False)
    for name in ("origin", "sheets", "residual_mm"):
        mesh.vertex_attributes[name] = rows[name].copy()
    return mesh


def clamped_net(tube: SplineTube) -> tuple[Floats, Floats]:
    """The same surface with clamped knots in both directions (knots inserted at both ends of u).

    Returns:
        Control points `(n_v, n_u + 3, 3)` and the knots around, `(n_u + 7,)`.
    """
    wrapped = np.concatenate([tube.net_mm, tube.net_mm[:, :DEGREE]], axis=1)
    net = wrapped.copy()
    net[:, 0] = (wrapped[:, 0] + 4.0 * wrapped[:, 1] + wrapped[:, 2]) / 6.0
    net[:, 1] = (2.0 * wrapped[:, 1] + wrapped[:, 2]) / 3.0
    net[:, -1] = (wrapped[:, -3] + 4.0 * wrapped[:, -2] + wrapped[:, -1]) / 6.0
    net[:, -2] = (wrapped[:, -3] + 2.0 * wrapped[:, -2]) / 3.0
    inner = np.arange(tube.count_u + 1) / tube.count_u
    return net, np.concatenate([np.zeros(DEGREE), inner, np.ones(DEGREE)])


def geomdl_surface(tube: SplineTube) -> NURBS.Surface:
    """The tube as a geomdl surface: u around, v from the board up, unit weights."""
    net, knots_u = clamped_net(tube)
    surface = NURBS.Surface(normalize_kv=False)
    surface.degree_u = surface.degree_v = DEGREE
    surface.ctrlpts_size_u, surface.ctrlpts_size_v = net.shape[1], net.shape[0]
    weighted = np.concatenate([net, np.ones((*net.shape[:2], 1))], axis=2).transpose(1, 0, 2)
    surface.ctrlptsw = weighted.reshape(-1, 4).tolist()
    surface.knotvector_u, surface.knotvector_v = knots_u.tolist(), tube.knots_v.tolist()
    surface.delta = _DELTA
    return surface


def save_surface_json(tube: SplineTube, path: Path) -> None:
    """Write the skin as geomdl's JSON exchange reads it (`geomdl.exchange.import_json`); its ends lie flat.

    Raises:
        StorageError: The place cannot be written.
    """
    net, knots_u = clamped_net(tube)
    points = net.transpose(1, 0, 2).reshape(-1, 3)
    shape = {
        "type": "spline",
        "name": "foot skin, mm; v = 0 on the board, v = 1 in the cut",
        "rational": True,
        "dimension": 3,
        "degree_u": DEGREE,
        "degree_v": DEGREE,
        "knotvector_u": knots_u.tolist(),
        "knotvector_v": tube.knots_v.tolist(),
        "size_u": net.shape[1],
        "size_v": net.shape[0],
        "control_points": {"points": points.tolist(), "weights": [1.0] * len(points)},
        "delta": [_DELTA, _DELTA],
    }
    text = json.dumps({"shape": {"type": "surface", "count": 1, "data": [shape]}})
    write_whole(path, text.encode())
