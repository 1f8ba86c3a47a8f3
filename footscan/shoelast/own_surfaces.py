"""A file that footscan wrote holds the very surfaces of a last: they are taken as they are, nothing is fitted."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import trimesh

from footscan.coordinates import Floats, Side
from footscan.shoelast.dimensions import with_points_and_lines
from footscan.shoelast.handed import mirrored_mesh
from footscan.shoelast.model import Attachment, Shoelast
from footscan.shoelast.nurbs_out import PATCHES, NurbsPatch, clamped_patches, shoelast_of_patches
from footscan.shoelast.patches import LATERAL, MEDIAL
from footscan.shoelast.source import LastSource

TAKEN = "upper, bottom and cone top were taken as they are, standing as the file's datum says"
_APART_MM, _OFF_DATUM_MM = 0.001, 5.0
_KINDS = ("stub", "toe_centre")


def shoelast_of_surfaces(source: LastSource, side: Side, name: str) -> Shoelast | None:
    """The last whose surfaces and datum a file holds, in its frame, with its points and lines found again.

    Args:
        source: Its `patches` lie in the file's own coordinates, its `frame` says where the last stands.
        side: As said.
        name: For people.

    Returns:
        None without a datum, when the last does not stand in it, or when the surfaces do not share their edges any
        more: then it is imported as everybody's.
    """
    if source.frame is None or set(PATCHES) - set(source.patches):
        return None
    frame = source.frame
    laid = {each: replace(patch, net_mm=_moved(frame, patch.net_mm)) for each, patch in source.patches.items()}
    try:
        shoelast = shoelast_of_patches(laid, name, side)
    except ValueError:
        return None
    if not (_same_upper(shoelast, laid) and _closed(shoelast)):
        return None
    found = with_points_and_lines(shoelast)
    if max(abs(found.points["rear_point"][0]), abs(found.points["tread_point"][2])) > _OFF_DATUM_MM:
        return None
    return replace(found, attachments=_attachments(source.bodies, frame, side), remarks=(*source.remarks, TAKEN))


def _moved(frame: Floats, xyz: Floats) -> Floats:
    return xyz @ frame[:3, :3].T + frame[:3, 3]


def _same_upper(shoelast: Shoelast, laid: Mapping[str, NurbsPatch]) -> bool:
    """Whether the upper still closes smoothly where its ends meet."""
    again = clamped_patches(shoelast)[0].net_mm
    return bool(np.abs(again - laid["upper"].net_mm).max() <= _APART_MM)


def _closed(shoelast: Shoelast) -> bool:
    """Whether both discs end on the edges of the upper."""
    share = np.linspace(0.0, 1.0, 201)
    for disc, level in ((shoelast.bottom, 0.0), (shoelast.cone_top, 1.0)):
        for half, t in ((LATERAL, 0.0), (MEDIAL, 1.0)):
            u = half[0] + (half[1] - half[0]) * share
            edge = shoelast.upper.grid(np.mod(u, 1.0), np.array([level]))[0]
            if np.abs(edge - disc.grid(share, np.array([t]))[:, 0]).max() > _APART_MM:
                return False
    return True


def _attachments(bodies: Sequence[tuple[str, trimesh.Trimesh]], frame: Floats, side: Side) -> tuple[Attachment, ...]:
    named = [(next((kind for kind in _KINDS if each.startswith(kind)), None), mesh) for each, mesh in bodies]
    return tuple(
        Attachment(kind, mirrored_mesh(mesh.copy().apply_transform(frame), side))
        for kind, mesh in named
        if kind is not None
    )
