"""Closed, oriented, manifold mesh of a spline tube: skin on a regular grid, flat sole and flat cut filled within."""

from dataclasses import dataclass

import manifold3d
import numpy as np
from scipy.spatial import Delaunay, KDTree

from footscan.coordinates import Bools, Floats, Ints
from footscan.errors import MeshError
from footscan.foot.nurbs import SplineTube
from footscan.foot.skin_grid import grid_places

_OVERLAP = 1.01  # area of all facets over the outline's own: more is an outline that crosses itself
_CLEAR = 0.6  # of a facet: how far points within a flat part keep from its outline


@dataclass(frozen=True)
class SkinMesh:
    """Vertices, facets and where on the skin each vertex lies.

    Attributes:
        xyz_mm: `(n, 3)`; first the skin row by row, then the sole's and the cut's inner points.
        facets: `(m, 3)` outward.
        u: `(k,)` parameters of the skin vertices, k <= n.
        v: Same.
        count_around: Vertices in each row of the skin.
        count_sole: Inner vertices of the sole; the cut's follow.
    """

    xyz_mm: Floats
    facets: Ints
    u: Floats
    v: Floats
    count_around: int
    count_sole: int


def build_skin_mesh(tube: SplineTube, facet_mm: float) -> SkinMesh:
    """Mesh a tube whose first row lies on the board and whose last lies in the cut.

    Args:
        tube: The fitted surface.
        facet_mm: Longest wanted edge of facets; they are shorter where the skin bends (`skin_grid`).

    Raises:
        MeshError: The outline of the sole or of the cut crosses itself.
    """
    u, v = grid_places(tube, facet_mm)
    around, up = len(u), len(v)
    skin = tube.grid(u, v)
    ring = np.arange(around)
    sole_xy, sole_facets = fill_outline(skin[0, :, :2], facet_mm, "sole")
    cut_xy, cut_facets = fill_outline(skin[-1, :, :2], facet_mm, "cut")
    first_cut = around * up + len(sole_xy)
    sole_ids = np.concatenate([ring, around * up + np.arange(len(sole_xy))])
    cut_ids = np.concatenate([around * (up - 1) + ring, first_cut + np.arange(len(cut_xy))])
    facets = np.concatenate([skin_facets(around, up), sole_ids[sole_facets][:, ::-1], cut_ids[cut_facets]])
    xyz = np.concatenate([skin.reshape(-1, 3), _at_height(sole_xy, skin[0, 0, 2]), _at_height(cut_xy, skin[-1, 0, 2])])
    return SkinMesh(xyz, facets, np.tile(u, up), np.repeat(v, around), around, len(sole_xy))


def skin_facets(around: int, up: int) -> Ints:
    """Facets `(m, 3)` of a closed band of rows; outward when rows run counter-clockwise and upwards."""
    row, column = np.meshgrid(np.arange(up - 1), np.arange(around), indexing="ij")
    here, beside = (row * around + column).ravel(), (row * around + (column + 1) % around).ravel()
    return np.concatenate(
        [np.stack([here, beside, beside + around], 1), np.stack([here, beside + around, here + around], 1)]
    )


def fill_outline(xy: Floats, facet_mm: float, what: str) -> tuple[Floats, Ints]:
    """Triangulate a flat closed outline, counter-clockwise, with points of its own within.

    Args:
        xy: `(k, 2)` outline, counter-clockwise.
        facet_mm: Spacing of the inner points.
        what: Name used in the message.

    Returns:
        Inner points `(m, 2)` and facets into outline followed by inner points.

    Raises:
        MeshError: The outline crosses itself.
    """
    inner = _inner_points(xy, facet_mm)
    facets = _delaunay_facets(xy, inner)
    if _fills(facets, xy, inner):
        return inner, facets
    plain, nothing = np.asarray(manifold3d.triangulate([xy.copy()]), dtype=np.int64), np.empty((0, 2))
    if _fills(plain, xy, nothing):
        return nothing, plain
    raise MeshError(f"the outline of the {what} crosses itself; scan again or filter the cloud more strongly")


def _inner_points(xy: Floats, facet_mm: float) -> Floats:
    low, high = xy.min(axis=0), xy.max(axis=0)
    x, y = np.meshgrid(np.arange(low[0], high[0], facet_mm), np.arange(low[1], high[1], facet_mm * np.sqrt(0.75)))
    x[1::2] += 0.5 * facet_mm
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    points = points[inside_outline(points, xy)]
    if not len(points):
        return np.empty((0, 2))
    return points[KDTree(_along(xy, 0.5 * facet_mm)).query(points)[0] > _CLEAR * facet_mm]


def _along(xy: Floats, step_mm: float) -> Floats:
    """The outline with points on its long edges too: an inner point near the middle of one would break it."""
    way = np.roll(xy, -1, axis=0) - xy
    pieces = np.maximum(np.ceil(np.linalg.norm(way, axis=1) / step_mm), 1.0).astype(np.int64)
    edge = np.repeat(np.arange(len(xy)), pieces)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[edge]
    return xy[edge] + share[:, None] * way[edge]


def _delaunay_facets(xy: Floats, inner: Floats) -> Ints:
    points = np.concatenate([xy, inner])
    facets = Delaunay(points).simplices.astype(np.int64)
    facets = facets[inside_outline(points[facets].mean(axis=1), xy)]
    left = _areas(facets, points) > 0.0
    return np.where(left[:, None], facets, facets[:, ::-1])


def _fills(facets: Ints, xy: Floats, inner: Floats) -> bool:
    """Whether the border of a triangulation is exactly the outline and its facets hardly overlap."""
    ring, size = len(xy), len(xy) + len(inner)
    edges = facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    keys, twins = edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0]
    border = np.sort(keys[~np.isin(keys, twins)])
    wanted = np.arange(ring) * size + (np.arange(ring) + 1) % ring
    if len(np.unique(keys)) < len(keys) or not np.array_equal(border, np.sort(wanted)):
        return False
    areas = _areas(facets, np.concatenate([xy, inner]))
    return float(np.abs(areas).sum()) <= _OVERLAP * float(areas.sum())


def _areas(facets: Ints, points: Floats) -> Floats:
    """Signed areas, positive counter-clockwise."""
    a, b, c = (points[facets[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def inside_outline(points: Floats, xy: Floats) -> Bools:
    """Whether `(n, 2)` points lie within a closed outline `(k, 2)` (even-odd rule)."""
    ahead = np.roll(xy, -1, axis=0)
    inside = np.zeros(len(points), bool)
    for a, b in zip(xy, ahead, strict=True):
        between = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
        if not between.any():
            continue
        cross = a[0] + (points[between, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        inside[between] ^= points[between, 0] < cross
    return inside


def _at_height(xy: Floats, z_mm: float) -> Floats:
    return np.column_stack([xy, np.full(len(xy), z_mm)])
