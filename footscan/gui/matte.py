"""Meshes with a colour per vertex as the browser draws them well: matt, so that the shaded side stays visible.

A GLB without a material is drawn as bare metal (glTF 2.0, 3.9.2: metallicFactor defaults to 1), which is black where no
lamp shines; and its vertex colours are linear, not those of a screen (3.7.2.1).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import trimesh

_MATT = {"pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.85}}


def matte_glb(mesh: trimesh.Trimesh, rgb: npt.NDArray[np.uint8]) -> bytes:
    """A mesh as a GLB of a matt material.

    Args:
        mesh: Of n vertices, in the scene's metres.
        rgb: `(n, 3)` colours as a screen shows them.
    """
    import trimesh
    from trimesh.exchange.gltf import export_glb
    from trimesh.visual import ColorVisuals

    drawn = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    alpha = np.full((len(rgb), 1), 255, np.uint8)
    drawn.visual = ColorVisuals(drawn, vertex_colors=np.hstack([_linear(rgb), alpha]))
    return bytes(export_glb(trimesh.Scene(drawn), include_normals=True, tree_postprocessor=_matt))


def _linear(rgb: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Screen colours in linear light (IEC 61966-2-1, by its exponent 2.4)."""
    share = rgb / 255.0
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.round(255.0 * light).astype(np.uint8)


def _matt(tree: dict[str, Any]) -> None:
    tree["materials"] = [_MATT]
    for mesh in tree["meshes"]:
        for primitive in mesh["primitives"]:
            primitive["material"] = 0
