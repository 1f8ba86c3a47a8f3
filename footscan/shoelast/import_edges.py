"""Feather edge and cone edge of a mesh: the shortest closed lines along its sharpest edges, as minimal cuts.

Faces that surely are bottom, cone top or upper are seeds. Between them the dual graph of the mesh is cut where it costs
least: an edge costs its length, less the sharper it is. A clean sharp edge is followed exactly; where it is rounded the
cut runs along the strongest bend.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, maximum_flow

from footscan.coordinates import Bools, Floats, Ints
from footscan.errors import MeshError
from footscan.shoelast.import_curves import off_curve
from footscan.shoelast.mesh_topology import Edges, edges_of, face_normals, loops, usual_direction

SHARP_RAD = np.radians(40.0)
_SOFT_RAD = np.radians(18.0)
_LEAST_SHARE = 0.002
_CAPACITY = 1e5
"""Units of cost per mm: whole numbers are wanted, and the cheapest tenth of a millimetre must still be many."""
_BOTTOM, _UPPER = 0.62, 0.25
_CONE_UP, _CONE_TURN = 0.78, 0.93
"""Cosines: how far a cone top may lean (a high heel leans it), and how far its faces from one another."""
_CONE_BAND_MM = 6.0
_FLAT_MM = 0.8
_WIDEST_CONE_MM = 52.0
_SMOOTHED, _ERODED = 3, 5


@dataclass(frozen=True)
class Regions:
    """Which faces are bottom, cone top and upper, and the edges between.

    Attributes:
        bottom: `(m,)`.
        cone_top: `(m,)`.
        feather_loop: Vertices in order, the upper on the left of the walk seen from outside.
        cone_loop: The same, for the cone edge.
        feather_turn_rad: `(k,)` how sharp the feather edge is, edge by edge.
        cone_turn_rad: The same for the cone edge.
    """

    bottom: Bools
    cone_top: Bools
    feather_loop: Ints
    cone_loop: Ints
    feather_turn_rad: Floats
    cone_turn_rad: Floats

    @property
    def upper(self) -> Bools:
        """`(m,)` faces of the upper."""
        return ~(self.bottom | self.cone_top)


def find_regions(
    xyz: Floats, faces: Ints, *, edge_seen: bool = True, curves: Mapping[str, Floats] | None = None
) -> Regions:
    """Part a closed last in its rough frame.

    Args:
        xyz: `(n, 3)`.
        faces: `(m, 3)`.
        edge_seen: False for a last scanned on the board, whose feather edge is assumed and may be blunt.
        curves: Dense curves `(k, 3)` of `feather_edge` and `cone_edge`, where the file brought them.

    Raises:
        MeshError: No feather edge or no cone edge, as on a foot.
    """
    edges = edges_of(faces)
    normal, area = face_normals(xyz, faces)
    smooth = _smoothed(normal, area, edges)
    turn = _turn(normal, xyz, faces, edges)
    given = curves or {}
    middle = xyz[faces].mean(axis=1)
    cone_seed, rest_seed = _cone_seeds(smooth, area, middle, edges)
    cone = _cut(edges, _cost(xyz, edges, turn, given.get("cone_edge")), cone_seed, rest_seed)
    cone = _filled(cone, area, edges)
    down = (-smooth[:, 2] > _BOTTOM) & (np.abs(smooth[:, 1]) < 0.5)
    bottom_seed = _largest(_eroded(down & ~_at_sharp(edges, turn), edges), area, edges)
    cost = _cost(xyz, edges, turn, given.get("feather_edge"))
    bottom = _filled(_cut(edges, cost, bottom_seed, _eroded(-smooth[:, 2] < _UPPER, edges) | cone), area, edges)
    feather, feather_turn = _border(edges, bottom, turn)
    rim, cone_turn = _border(edges, cone, turn)
    _check(xyz, feather, rim, feather_turn if edge_seen else np.full(1, np.pi))
    return Regions(bottom, cone, feather, rim, feather_turn, cone_turn)


def _smoothed(normal: Floats, area: Floats, edges: Edges) -> Floats:
    """Normals averaged with their neighbours' a few times: enough to quieten noise, not to round an edge away."""
    size = len(normal)
    a, b = edges.faces[edges.faces[:, 1] >= 0].T
    graph = coo_array((np.ones(2 * len(a)), (np.r_[a, b], np.r_[b, a])), shape=(size, size)).tocsr()
    weighted = normal * area[:, None]
    for _ in range(_SMOOTHED):
        weighted = weighted + graph @ weighted
    return weighted / np.maximum(np.linalg.norm(weighted, axis=1, keepdims=True), 1e-12)


def _turn(normal: Floats, xyz: Floats, faces: Ints, edges: Edges) -> Floats:
    """Angle by which the surface turns at each edge, positive where it is convex; 0 at a rim."""
    a, b = edges.faces.T
    inner = b >= 0
    cosine = np.clip((normal[a] * normal[b]).sum(axis=1), -1.0, 1.0)
    across = xyz[faces[b]].mean(axis=1) - xyz[faces[a]].mean(axis=1)
    convex = (across * (normal[a] - normal[b])).sum(axis=1) < 0
    return np.where(inner, np.arccos(cosine) * np.where(convex, 1.0, -1.0), 0.0)


def _cost(xyz: Floats, edges: Edges, turn: Floats, curve: Floats | None) -> Ints:
    """What it costs to run along each edge: its length, less where it is sharp, and less along a curve of the file.

    Near the curve the sharpest edge is still the cheapest, so that the cut does not stray beside it.
    """
    length = np.linalg.norm(xyz[edges.ends[:, 1]] - xyz[edges.ends[:, 0]], axis=1)
    share = np.exp(-((np.maximum(turn, 0.0) / _SOFT_RAD) ** 2)) * off_curve(xyz, edges.ends, curve)
    return np.maximum((_CAPACITY * length * (share + _LEAST_SHARE)).astype(np.int64), 1)


def _cone_seeds(smooth: Floats, area: Floats, middle: Floats, edges: Edges) -> tuple[Bools, Bools]:
    """Faces in the cone's plane, and faces that are surely not: well below it, or far in front."""
    back = middle[:, 0] < middle[:, 0].min() + 0.62 * np.ptp(middle[:, 0])
    high = (smooth[:, 2] > _CONE_UP) & back & (middle[:, 2] > np.percentile(middle[:, 2], 70))
    if not high.any():
        raise MeshError("no cone top found: the file holds no last, or its cone is cut off or open.")
    flat = _largest(high & (smooth @ usual_direction(smooth[high], area[high]) > _CONE_TURN), area, edges)
    normal, origin = _plane(middle[flat], area[flat])
    away = np.abs((middle - origin) @ normal)
    seed = _eroded(flat & (away < _FLAT_MM), edges)
    if seed.sum() < 5:
        raise MeshError("the cone top is not flat: the file holds no last, or a cut through the leg of a foot.")
    below = (middle - origin) @ normal < -_CONE_BAND_MM
    return _largest(seed, area, edges), below


def _plane(xyz: Floats, weight: Floats) -> tuple[Floats, Floats]:
    keep = np.ones(len(xyz), dtype=np.bool_)
    normal, origin = np.array([0.0, 0.0, 1.0]), xyz.mean(axis=0)
    for _ in range(4):
        origin = np.average(xyz[keep], axis=0, weights=weight[keep])
        spread = (xyz[keep] - origin) * np.sqrt(weight[keep])[:, None]
        normal = np.linalg.eigh(spread.T @ spread)[1][:, 0]
        away = np.abs((xyz - origin) @ normal)
        keep = away <= max(float(np.percentile(away, 70)), 0.05)
    return (normal if normal[2] > 0 else -normal), origin


def _at_sharp(edges: Edges, turn: Floats) -> Bools:
    """Faces on a sharp edge: seen from below, the back of a high heel joins the bottom there."""
    found = np.zeros(int(edges.faces.max()) + 1, dtype=np.bool_)
    found[edges.faces[turn > SHARP_RAD].reshape(-1)] = True
    return found


def _eroded(chosen: Bools, edges: Edges) -> Bools:
    """Some faces without those that are near to others: smoothed normals are mixed across an edge."""
    a, b = edges.faces[edges.faces[:, 1] >= 0].T
    for _ in range(_ERODED):
        chosen = chosen.copy()
        split = chosen[a] != chosen[b]
        chosen[a[split]] = False
        chosen[b[split]] = False
    return chosen


def _largest(chosen: Bools, area: Floats, edges: Edges) -> Bools:
    """The largest piece of some faces."""
    inner = edges.faces[:, 1] >= 0
    a, b = edges.faces[inner].T
    both = chosen[a] & chosen[b]
    size = len(chosen)
    graph = coo_array((np.ones(int(both.sum()), np.bool_), (a[both], b[both])), shape=(size, size))
    count, label = connected_components(graph, directed=False)
    total = np.bincount(label, weights=area * chosen, minlength=count)
    return (label == total.argmax()) & chosen


def _filled(region: Bools, area: Floats, edges: Edges) -> Bools:
    """A region together with what it encloses, so that it has one border."""
    return ~_largest(~region, area, edges)


def _cut(edges: Edges, cost: Ints, inside: Bools, outside: Bools) -> Bools:
    """The faces on the inner side of the cheapest cut between two sets of faces."""
    outside = outside & ~inside
    inner = edges.faces[:, 1] >= 0
    node = np.full(len(inside), -1, dtype=np.int64)
    free = ~(inside | outside)
    node[free] = np.arange(int(free.sum())) + 2
    node[inside], node[outside] = 0, 1
    a, b = node[edges.faces[inner, 0]], node[edges.faces[inner, 1]]
    keep = (a != b) & ~((a < 2) & (b < 2))
    size, weight = int(free.sum()) + 2, cost[inner][keep]
    rows, columns = np.r_[a[keep], b[keep]], np.r_[b[keep], a[keep]]
    graph = coo_array((np.r_[weight, weight], (rows, columns)), shape=(size, size)).tocsr()
    graph = csr_array((np.minimum(graph.data, 2**30).astype(np.int32), graph.indices, graph.indptr), shape=graph.shape)
    flow = maximum_flow(graph, 0, 1, method="dinic").flow
    left = (graph - flow).tocoo()
    usable = left.data > 0
    reach = csr_array((np.ones(int(usable.sum()), np.int8), (left.row[usable], left.col[usable])), shape=graph.shape)
    return _reached(reach, size)[np.maximum(node, 0)] & (node != 1)


def _reached(graph: csr_array, size: int) -> Bools:
    """Nodes that node 0 leads to."""
    found = np.zeros(size, dtype=np.bool_)
    found[breadth_first_order(graph, 0, return_predecessors=False)] = True
    return found


def _border(edges: Edges, region: Bools, turn: Floats) -> tuple[Ints, Floats]:
    """The longest closed line round a region as vertices, the region on the right, and how sharp its edges are."""
    first = region[edges.faces[:, 0]]
    second = np.where(edges.faces[:, 1] >= 0, region[edges.faces[:, 1]], first)
    at = first != second
    ends = np.where(first[at][:, None], edges.ends[at][:, ::-1], edges.ends[at])
    found = loops(ends)
    if not found:
        raise MeshError("no closed edge between upper and bottom or cone top: the file holds no last.")
    return found[0], np.abs(turn[at])


def _check(xyz: Floats, feather: Ints, rim: Ints, feather_turn: Floats) -> None:
    cone = np.ptp(xyz[rim], axis=0)
    if cone[1] > _WIDEST_CONE_MM:
        raise MeshError(
            f"the flat top is {cone[1]:.0f} mm wide; a last's cone top has at most {_WIDEST_CONE_MM:.0f} mm: "
            "this looks like a foot cut off above the ankle (`footscan measure` reads feet), or a last sawn off below "
            "its cone; export the whole last."
        )
    length = np.ptp(xyz[feather], axis=0)
    if length[0] < 0.8 * np.ptp(xyz[:, 0]) or np.degrees(np.median(feather_turn)) < 15.0:
        raise MeshError(
            f"no feather edge: the line between upper and bottom is {length[0]:.0f} mm long and bends by "
            f"{np.degrees(np.median(feather_turn)):.0f} degrees; a foot, or a last without its sole edge."
        )
