"""From the fitted foot to a closed mesh that says per vertex where its skin comes from."""

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from footscan.coordinates import Bools, Floats, Ints
from footscan.errors import MeshError
from footscan.foot.skin_mesh import SkinMesh, build_skin_mesh
from footscan.foot.skin_origin import Origin, classify, closing_radius_mm, find_covered, find_stripe_spacing
from footscan.foot.surface import FootSurface

FACET_MM = 2.0
_NEAR_POINTS = 4


def mesh_from_surface(surface: FootSurface, facet_mm: float = FACET_MM) -> trimesh.Trimesh:
    """Build the closed mesh of a foot.

    Args:
        surface: The fitted foot.
        facet_mm: Wanted length of facet edges.

    Returns:
        A watertight mesh with outward normals and `vertex_attributes`: `origin` (see `Origin`), `sheets` (0..2 lasers
        that measured the skin there) and `residual_mm` (RMS distance of the nearest points; NaN where not seen).

    Raises:
        MeshError: The surface encloses nothing.
    """
    skin = build_skin_mesh(surface.tube, facet_mm)
    mesh = trimesh.Trimesh(skin.xyz_mm, skin.facets, process=False, validate=False)
    if not mesh.is_watertight or mesh.volume <= 0.0:
        raise MeshError("the fitted surface does not enclose a foot; scan again or filter the cloud more strongly")
    origin, sheets = _origin_and_sheets(surface, skin)
    mesh.vertex_attributes["origin"] = origin.astype(np.uint8)
    mesh.vertex_attributes["sheets"] = sheets.astype(np.uint8)
    mesh.vertex_attributes["residual_mm"] = _residuals(surface, skin.xyz_mm, origin == Origin.SEEN).astype(np.float32)
    return mesh


def _origin_and_sheets(surface: FootSurface, skin: SkinMesh) -> tuple[Ints, Ints]:
    used = surface.weight > 0.0
    points, laser = surface.xyz_world[used], surface.laser[used]
    places = skin.xyz_mm[: len(skin.u)]
    tree = cKDTree(points, balanced_tree=False)
    radius = closing_radius_mm(find_stripe_spacing(points, tree), places)
    covered = find_covered(places, tree, radius)
    by_laser = [_covered_by(points[laser == k], places, radius) for k in (0, 1)]
    sheets = np.where(covered, np.maximum(by_laser[0].astype(np.int64) + by_laser[1], 1), 0)
    lowest = np.interp(skin.u, surface.lowest_u, surface.lowest_v, period=1.0)
    origin = classify(covered, skin.v, lowest)
    origin[: skin.count_around] = Origin.ASSUMED_SOLE
    origin[-skin.count_around :] = Origin.CUT
    flat = np.full(len(skin.xyz_mm) - len(skin.u), int(Origin.CUT))
    flat[: skin.count_sole] = Origin.ASSUMED_SOLE
    return np.concatenate([origin, flat]), np.concatenate([sheets * (origin == Origin.SEEN), np.zeros(len(flat), np.int64)])


def _covered_by(points: Floats, places: Floats, radius_mm: Floats) -> Bools:
    """Coverage by one laser alone, whose stripes lie twice as far apart."""
    if len(points) < 2:
        return np.zeros(len(places), bool)
    return find_covered(places, cKDTree(points, balanced_tree=False), 1.5 * radius_mm)


def _residuals(surface: FootSurface, xyz_mm: Floats, seen: Bools) -> Floats:
    """RMS residual of the nearest points at seen vertices, NaN elsewhere."""
    used = surface.weight > 0.0
    result = np.full(len(xyz_mm), np.nan)
    if seen.any():
        count = min(_NEAR_POINTS, int(used.sum()))
        _, near = cKDTree(surface.xyz_world[used], balanced_tree=False).query(xyz_mm[seen], k=count, workers=-1)
        squares = surface.residual_mm[used][near.reshape(int(seen.sum()), -1)] ** 2
        result[seen] = np.sqrt(squares.mean(axis=1))
    return result
