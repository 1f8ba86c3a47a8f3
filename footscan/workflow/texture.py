"""`texture.ply`: the measured foot in the grey of its skin, where the recording has frames without laser."""

from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from footscan.config.toml_file import write_whole
from footscan.scanning.texture import texture_from_unlit
from footscan.workflow.process import ScanResult

_NEVER_SEEN = (40, 60, 110)  # dark blue: no picture shows this skin


def save_texture(result: ScanResult, mesh: trimesh.Trimesh, path: Path) -> dict[str, Any] | None:
    """Write the mesh with the grey of each vertex; what no unlit frame shows is dark blue.

    Returns:
        The share of vertices that have a grey, for the report; None if the recording has no unlit frame.

    Raises:
        StorageError: The place cannot be written.
    """
    vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    normals = np.asarray(mesh.vertex_normals, np.float64)
    texture = texture_from_unlit(result.recording, result.calibration, vertices, normals, faces)
    if texture is None:
        return None
    known = np.isfinite(texture.grey)
    colours = np.tile(np.array([*_NEVER_SEEN, 255], np.uint8), (len(vertices), 1))
    colours[known, :3] = np.rint(np.clip(texture.grey[known], 0, 255)).astype(np.uint8)[:, None]
    coloured = trimesh.Trimesh(vertices, faces, vertex_colors=colours, process=False)
    content = coloured.export(file_type="ply")
    assert isinstance(content, bytes)
    write_whole(path, content)
    return {"file": path.name, "share_of_vertices": round(float(known.mean()), 4)}
