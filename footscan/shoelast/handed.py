"""From the last in memory (y medial for both sides) to the real last, as files hold it, and back."""

import numpy as np
import trimesh

from footscan.coordinates import Floats, Side

DATUM = (
    "Datum: x from the rearmost point of the back (without stub) to the toe along the axis of the bottom, z up from "
    "the ground, the last standing on its tread point at its heel height; y to the left seen from above (medial of a "
    "right last, lateral of a left one); mm"
)


def mirrored(xyz: Floats, side: Side) -> Floats:
    """Points `(..., 3)` of a left last with y turned round, of a right one as they are; its own inverse."""
    return xyz * np.array([1.0, -1.0, 1.0]) if side == "left" else np.array(xyz, dtype=np.float64)


def mirrored_mesh(mesh: trimesh.Trimesh, side: Side) -> trimesh.Trimesh:
    """A mesh turned like `mirrored`, its faces still counter-clockwise seen from outside."""
    faces = np.asarray(mesh.faces)
    faces = faces[:, ::-1] if side == "left" else faces
    return trimesh.Trimesh(mirrored(np.asarray(mesh.vertices), side), faces.copy(), process=False)
