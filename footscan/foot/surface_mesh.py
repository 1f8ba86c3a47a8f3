"""From the fitted foot to a closed mesh that says per vertex where its skin comes from."""

import numpy as np
import trimesh
from scipy.spatial import KDTree

from footscan.coordinates import Bools, Floats, Ints
from footscan.errors import MeshError
from footscan.foot.shell import Shell, volume_mm3
from footscan.foot.skin_mesh import SkinMesh, build_skin_mesh
from footscan.foot.skin_origin import Origin, classify, closing_radius_mm, find_covered, find_stripe_spacing
from footscan.foot.surface import FootSurface

FACET_MM = 2.0
_NEAR_POINTS = 4
_ONE_LASER = 1.5  # of the closing radius: one laser's stripes lie twice as far apart as both lasers'


def mesh_from_surface(surface: FootSurface, facet_mm: float = FACET_MM) -> trimesh.Trimesh:
    """Build the closed mesh of a foot.

    Args:
        surface: The fitted foot.
        facet_mm: Longest wanted edge of facets; they are shorter where the skin bends.

    Returns:
        A watertight mesh with outward normals and `vertex_attributes`: `origin` (see `Origin`), `sheets` (0..2 lasers
        that measured the skin there) and `residual_mm` (RMS distance of the nearest points; NaN where not seen).

    Raises:
        MeshError: The surface encloses nothing.
    """
    skin = build_skin_mesh(surface.tube, facet_mm)
    mesh = trimesh.Trimesh(skin.xyz_mm, skin.facets, process=False, validate=False)
    if volume_mm3(Shell(skin.xyz_mm, skin.facets), skin.xyz_mm[0]) <= 0.0:
        raise MeshError("the fitted surface does not enclose a foot; scan again or filter the cloud more strongly")
    used = surface.weight > 0.0
    tree = KDTree(surface.xyz_world[used], balanced_tree=False)
    origin, sheets = _origin_and_sheets(surface, skin, used, tree, facet_mm)
    residual = _residuals(surface.residual_mm[used], tree, skin.xyz_mm, origin == Origin.SEEN)
    mesh.vertex_attributes["origin"] = origin.astype(np.uint8)
    mesh.vertex_attributes["sheets"] = sheets.astype(np.uint8)
    mesh.vertex_attributes["residual_mm"] = residual.astype(np.float32)
    return mesh


def mirrored_mesh(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """The mesh mirrored in the plane y = 0, with outward normals and the same attributes."""
    xyz = np.asarray(mesh.vertices) * np.array([1.0, -1.0, 1.0])
    result = trimesh.Trimesh(xyz, np.asarray(mesh.faces)[:, ::-1], process=False, validate=False)
    for name, values in mesh.vertex_attributes.items():
        result.vertex_attributes[name] = values
    return result


def _origin_and_sheets(
    surface: FootSurface, skin: SkinMesh, used: Bools, tree: KDTree, facet_mm: float
) -> tuple[Ints, Ints]:
    points, laser = surface.xyz_world[used], surface.laser[used]
    places = skin.xyz_mm[: len(skin.u)]
    radius = closing_radius_mm(find_stripe_spacing(points, tree), places)
    covered = find_covered(places, tree, radius, facet_mm)
    lowest = np.interp(skin.u, surface.lowest_u, surface.lowest_v, period=1.0)
    origin = classify(covered, skin.v, lowest)
    origin[: skin.count_around] = Origin.ASSUMED_SOLE
    origin[-skin.count_around :] = Origin.CUT
    seen = origin == Origin.SEEN
    sheets = np.zeros(len(places), np.int64)
    sheets[seen] = np.maximum(count_sheets(places[seen], points, laser, _ONE_LASER * radius[seen]), 1)
    flat = np.full(len(skin.xyz_mm) - len(places), int(Origin.CUT))
    flat[: skin.count_sole] = Origin.ASSUMED_SOLE
    return np.concatenate([origin, flat]), np.concatenate([sheets, np.zeros(len(flat), np.int64)])


def count_sheets(places_mm: Floats, points_mm: Floats, laser: Ints, radius_mm: Floats) -> Ints:
    """How many of the two lasers `(n,)` measured a point within a radius of each place."""
    count = np.zeros(len(places_mm), np.int64)
    for name in (0, 1):
        own = points_mm[laser == name]
        if len(own):
            bound = float(radius_mm.max(initial=0.1))
            gap, _ = KDTree(own, balanced_tree=False).query(places_mm, distance_upper_bound=bound, workers=-1)
            count += gap <= radius_mm
    return count


def _residuals(residual_mm: Floats, tree: KDTree, xyz_mm: Floats, seen: Bools) -> Floats:
    """RMS residual of the nearest points at seen vertices, NaN elsewhere."""
    result = np.full(len(xyz_mm), np.nan)
    if seen.any():
        _, near = tree.query(xyz_mm[seen], k=min(_NEAR_POINTS, len(residual_mm)), workers=-1)
        result[seen] = np.sqrt((residual_mm[near.reshape(int(seen.sum()), -1)] ** 2).mean(axis=1))
    return result
