"""A last as a closed mesh of the real last: within the chord error, with its stub on request, as STL, OBJ or PLY."""

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import manifold3d
import numpy as np
import trimesh

from footscan.config.toml_file import write_whole
from footscan.coordinates import Floats, Ints
from footscan.errors import MeshError
from footscan.shoelast.chord import CHORD_LIMIT_MM, breaks_within
from footscan.shoelast.handed import DATUM, mirrored_mesh
from footscan.shoelast.model import Shoelast
from footscan.shoelast.skin import skin_of

Stub = Literal["without", "joined", "separate"]
_STL_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_PLY_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


@dataclass(frozen=True)
class OutMesh:
    """What leaves: `bodies` name -> closed mesh (real handedness, mm), and the bound of its chord error (mm)."""

    name: str
    bodies: dict[str, trimesh.Trimesh]
    chord_error_mm: float

    def whole(self) -> trimesh.Trimesh:
        """All bodies in one mesh, not joined."""
        meshes = list(self.bodies.values())
        starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
        faces = [np.asarray(mesh.faces) + start for mesh, start in zip(meshes, starts, strict=False)]
        return trimesh.Trimesh(np.vstack([mesh.vertices for mesh in meshes]), np.vstack(faces), process=False)


def mesh_of_last(shoelast: Shoelast, stub: Stub = "without", limit_mm: float = CHORD_LIMIT_MM) -> OutMesh:
    """Mesh a last within a chord error.

    Args:
        shoelast: Any last.
        stub: Left out, joined to the last (one closed body), or a body of its own.
        limit_mm: Largest chord error.

    Raises:
        QualityError: The chord error cannot be reached.
        MeshError: A stub was asked for and the last has none.
    """
    fine, error = breaks_within(shoelast, limit_mm)
    body = mirrored_mesh(skin_of(shoelast, fine).mesh(), shoelast.side)
    bodies = {"last": body}
    if stub != "without":
        stubs = [mirrored_mesh(each.mesh, shoelast.side) for each in shoelast.attachments if each.kind == "stub"]
        if not stubs:
            raise MeshError(f"{shoelast.name} has no stub to give back; export it without --stub.")
        if stub == "joined":
            bodies = {"last": _joined([body, *stubs])}
        else:
            bodies |= {"stub" if len(stubs) == 1 else f"stub_{k}": each for k, each in enumerate(stubs, 1)}
    return OutMesh(shoelast.name, bodies, error.bound_mm)


def _joined(bodies: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    solids = [solid_of(body) for body in bodies]
    joined = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)
    if len(joined.decompose()) > 1:
        raise MeshError("the stub does not touch the last, they cannot be joined; export it as a separate body.")
    return mesh_of_solid(joined)


def solid_of(mesh: trimesh.Trimesh) -> manifold3d.Manifold:
    """A closed mesh as a solid for boolean operations, in double precision.

    Raises:
        MeshError: It is not closed.
    """
    raw = manifold3d.Mesh64(
        vert_properties=np.array(mesh.vertices, dtype=np.float64, order="C"),
        tri_verts=np.array(mesh.faces, dtype=np.uint64, order="C"),
    )
    solid = manifold3d.Manifold(raw)
    if solid.status() != manifold3d.Error.NoError or solid.is_empty():
        raise MeshError(f"a body is not closed ({solid.status()}); import the last again, which closes it.")
    return solid


def mesh_of_solid(solid: manifold3d.Manifold) -> trimesh.Trimesh:
    """The triangles of a solid."""
    raw = solid.to_mesh64()
    xyz = np.asarray(raw.vert_properties, dtype=np.float64)[:, :3]
    return trimesh.Trimesh(xyz, np.asarray(raw.tri_verts, dtype=np.int64), process=False)


def save_last_mesh(out: OutMesh, path: Path, note: str) -> None:
    """Write STL (binary), OBJ or PLY (binary), in mm; which one says the ending of `path`.

    OBJ keeps the bodies apart as objects and states the datum; PLY states it as a comment; STL has no room for it.

    Args:
        out: From `mesh_of_last`.
        path: Where to.
        note: One line about the last, for the head of the file.

    Raises:
        StorageError: The place cannot be written.
    """
    writers = {".stl": _stl, ".obj": _obj, ".ply": _ply}
    write_whole(path, writers[path.suffix.lower()](out, _ascii(note)))


def _ascii(text: str) -> str:
    return " ".join(text.split()).encode("ascii", "replace").decode("ascii")


def _stl(out: OutMesh, note: str) -> bytes:
    mesh = out.whole()
    rows = np.zeros(len(mesh.faces), _STL_FACET)
    rows["corners"] = mesh.triangles
    rows["normal"] = _normals(mesh)
    head = f"footscan last, mm: {note}".encode()[:80].ljust(80)
    return head + struct.pack("<I", len(rows)) + rows.tobytes()


def _normals(mesh: trimesh.Trimesh) -> Floats:
    """Of every face; trimesh leaves faces without area out."""
    corner = np.asarray(mesh.triangles, dtype=np.float64)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)


def _obj(out: OutMesh, note: str) -> bytes:
    lines = [f"# footscan last, mm: {note}", f"# {DATUM}"]
    begin = 1
    for name, mesh in out.bodies.items():
        lines += [f"o {name}", _rows("v %.6f %.6f %.6f", np.asarray(mesh.vertices))]
        lines.append(_rows("f %d %d %d", np.asarray(mesh.faces) + begin))
        begin += len(mesh.vertices)
    return ("\n".join(lines) + "\n").encode()


def _rows(pattern: str, values: Floats | Ints) -> str:
    """One line a row; a single formatting of all numbers is many times as fast as a loop."""
    return "\n".join([pattern] * len(values)) % tuple(values.ravel().tolist())


def _ply(out: OutMesh, note: str) -> bytes:
    mesh = out.whole()
    faces = np.zeros(len(mesh.faces), _PLY_FACE)
    faces["count"], faces["corners"] = 3, mesh.faces
    head = [
        "ply",
        "format binary_little_endian 1.0",
        f"comment footscan last, mm: {note}",
        f"comment {DATUM}",
        f"element vertex {len(mesh.vertices)}",
        *(f"property double {name}" for name in "xyz"),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header",
        "",
    ]
    return "\n".join(head).encode() + np.asarray(mesh.vertices, dtype="<f8").tobytes() + faces.tobytes()
