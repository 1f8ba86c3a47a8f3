"""Seams of a mesh closed: rims that lie on each other are joined, vertex on vertex and vertex on edge.

Only rims are touched. Joining whatever is near would also fold the fine facets of a sound surface on to each other.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from footscan.coordinates import Floats, Ints
from footscan.geometry.nearest import PointTree
from footscan.shoelast.mesh_topology import edges_of

_STEP_MM = 0.1
_NEAR = 12
_ROUNDS = 4


def with_closed_seams(xyz: Floats, faces: Ints, weld_mm: float, seam_mm: float) -> tuple[Floats, Ints]:
    """Join the rims of a mesh.

    Patches of one body seldom have the same vertices along their common edge. A vertex on the inside of another rim's
    edge parts that edge and its face.

    Args:
        xyz: `(n, 3)` mm.
        faces: `(m, 3)`.
        weld_mm: Rim vertices nearer to one another become one.
        seam_mm: Rim vertices nearer to a rim edge part it.

    Returns:
        Vertices and faces; some vertices are used no more.
    """
    xyz, faces = _rims_welded(xyz, faces, weld_mm)
    for _ in range(_ROUNDS):
        found = _on_edges(xyz, faces, seam_mm)
        if len(found[0]) == 0:
            break
        faces = _parted(faces, *found)
    return xyz, faces


def _rim_ends(faces: Ints) -> tuple[Ints, Ints]:
    """Rim edges `(k, 2)` as their face runs along them, and the face of each."""
    edges = edges_of(faces)
    rim = edges.faces[:, 1] < 0
    return edges.ends[rim], edges.faces[rim, 0]


def _rims_welded(xyz: Floats, faces: Ints, weld_mm: float) -> tuple[Floats, Ints]:
    vertex = np.unique(_rim_ends(faces)[0])
    if len(vertex) == 0:
        return xyz, faces
    pairs = PointTree(xyz[vertex]).pairs(weld_mm)
    graph = coo_array((np.ones(len(pairs), np.bool_), (pairs[:, 0], pairs[:, 1])), shape=(len(vertex), len(vertex)))
    count, label = connected_components(graph, directed=False)
    number = np.bincount(label, minlength=count)
    total = np.stack([np.bincount(label, weights=xyz[vertex, k], minlength=count) for k in range(3)], axis=1)
    first = np.full(count, len(xyz))
    np.minimum.at(first, label, vertex)
    place = np.arange(len(xyz))
    place[vertex] = first[label]
    xyz = xyz.copy()
    xyz[first] = total / number[:, None]
    faces = place[faces]
    return xyz, faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]


def _on_edges(xyz: Floats, faces: Ints, seam_mm: float) -> tuple[Ints, Ints, Ints, Floats]:
    """Rim vertices on the inside of rim edges: face, its corner where the edge begins, vertex, and share of the edge.

    One edge of a face at a time, so that its other rim edges wait for the next round.
    """
    ends, owner = _rim_ends(faces)
    edge, places = _sampled(xyz, ends)
    vertex = np.unique(ends)
    if len(vertex) == 0:
        empty = np.zeros(0, dtype=np.int64)
        return empty, empty, empty, np.zeros(0)
    distance, index = PointTree(places).nearest(xyz[vertex], _NEAR, float(np.hypot(seam_mm, 0.5 * _STEP_MM)))
    row, column = np.nonzero(np.isfinite(distance))
    pair = np.unique(np.stack([edge[index[row, column]], vertex[row]], axis=1), axis=0)
    pair = pair[(ends[pair[:, 0]] != pair[:, 1:]).all(axis=1)]
    begin, along = xyz[ends[pair[:, 0], 0]], xyz[ends[pair[:, 0], 1]] - xyz[ends[pair[:, 0], 0]]
    off = xyz[pair[:, 1]] - begin
    share = (off * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-12)
    beside = np.linalg.norm(off - share[:, None] * along, axis=1)
    from_end = np.minimum(share, 1.0 - share) * np.linalg.norm(along, axis=1)
    on_it = (beside <= seam_mm) & (from_end > beside) & (faces[owner[pair[:, 0]]] != pair[:, 1:]).all(axis=1)
    pair, share = pair[on_it], share[on_it]
    one = _one_edge_a_face(owner[pair[:, 0]], pair[:, 0])
    pair, share = pair[one], share[one]
    face = owner[pair[:, 0]]
    corner = (faces[face] == ends[pair[:, 0], :1]).argmax(axis=1)
    return face, corner, pair[:, 1], share


def _sampled(xyz: Floats, ends: Ints) -> tuple[Ints, Floats]:
    """Places every tenth of a millimetre inside some edges, and the edge of each."""
    along = xyz[ends[:, 1]] - xyz[ends[:, 0]]
    count = np.ceil(np.linalg.norm(along, axis=1) / _STEP_MM).astype(np.int64)
    edge = np.repeat(np.arange(len(ends)), count)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[edge]
    return edge, xyz[ends[edge, 0]] + share[:, None] * along[edge]


def _one_edge_a_face(face: Ints, edge: Ints) -> Ints:
    """Which entries `(k,)` to keep: those of the first edge that each face has among them."""
    first = np.full(int(face.max(initial=0)) + 1, np.iinfo(np.int64).max)
    np.minimum.at(first, face, edge)
    return np.flatnonzero(first[face] == edge)


def _parted(faces: Ints, face: Ints, corner: Ints, vertex: Ints, share: Floats) -> Ints:
    """Faces cut into fans from the corner opposite of the edge on which the vertices lie."""
    order = np.lexsort((share, face))
    face, corner, vertex = face[order], corner[order], vertex[order]
    first = np.concatenate([[True], face[1:] != face[:-1]])
    last = np.concatenate([face[1:] != face[:-1], [True]])
    begin, end, top = (faces[face, (corner + k) % 3] for k in range(3))
    before = np.where(first, begin, np.roll(vertex, 1))
    fans = np.stack([before, vertex, top], axis=1)
    ends = np.stack([vertex, end, top], axis=1)[last]
    kept = np.ones(len(faces), dtype=np.bool_)
    kept[face] = False
    return np.ascontiguousarray(np.vstack([faces[kept], fans, ends]))
