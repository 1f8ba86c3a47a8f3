"""Edges, neighbours, windings and rims of triangle meshes, as arrays."""

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from footscan.coordinates import Floats, Ints
from footscan.foot.crossing import chain_segments
from footscan.shoelast.winding_loop import spread_turns

_CELL, _NEAR_COSINE = 0.1, float(np.cos(np.radians(5.0)))
_MIXED = np.array([np.sqrt(2.0), np.sqrt(3.0), np.sqrt(5.0)])


@dataclass(frozen=True)
class Edges:
    """Undirected edges of a mesh with at most two faces each.

    Attributes:
        ends: `(k, 2)` vertices, as the first face runs along them.
        faces: `(k, 2)` faces; the second is -1 at a rim.
    """

    ends: Ints
    faces: Ints


def edge_names(faces: Ints) -> tuple[Ints, Ints]:
    """Directed edges `(3m, 2)`, face after face, and the number `(3m,)` of the undirected edge each runs along."""
    ends = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    low, high = ends.min(axis=1), ends.max(axis=1)
    _, name = np.unique(low * (int(faces.max()) + 1) + high, return_inverse=True)
    return ends, name.reshape(-1)


def edges_of(faces: Ints) -> Edges:
    """All edges; of one with more than two faces only two are told."""
    ends, name = edge_names(faces)
    order = np.argsort(name, kind="stable")
    first = np.concatenate([[True], name[order][1:] != name[order][:-1]])
    begin = np.flatnonzero(first)
    count = np.diff(np.append(begin, len(order)))
    second = np.where(count > 1, order[np.minimum(begin + 1, len(order) - 1)] // 3, -1)
    return Edges(ends[order[begin]], np.stack([order[begin] // 3, second], axis=1))


def unique_rows(rows: Floats | Ints) -> tuple[Floats | Ints, Ints, Ints]:
    """Different rows of `(n, 3)`, where each comes first, and which of them each row is.

    Rows are told apart by one number each, which is a hundred times quicker to sort; should two rows share it, the
    slow way is taken.
    """
    _, first, place = np.unique(rows @ _MIXED, return_index=True, return_inverse=True)
    place = place.reshape(-1)
    if not np.array_equal(rows[first][place], rows):
        _, first, place = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return rows[first], first, place.reshape(-1)


def pieces(faces: Ints) -> tuple[int, Ints]:
    """How many pieces hang together over edges, and the piece of every face `(m,)`."""
    edges = edges_of(faces)
    inner = edges.faces[edges.faces[:, 1] >= 0]
    size = len(faces)
    graph = coo_array((np.ones(len(inner), np.bool_), (inner[:, 0], inner[:, 1])), shape=(size, size))
    count, label = connected_components(graph, directed=False)
    return int(count), label.astype(np.int64)


def consistent(faces: Ints) -> tuple[Ints, int]:
    """Faces turned like their neighbours, piece by piece, and how many were turned."""
    ends, name = edge_names(faces)
    order = np.argsort(name, kind="stable")
    same = name[order][1:] == name[order][:-1]
    a, b = order[:-1][same], order[1:][same]
    against = ends[a, 0] == ends[b, 0]
    pair, sign = np.stack([a // 3, b // 3], axis=1), against
    both = np.concatenate([pair, pair[:, ::-1]])
    rank = np.argsort(both[:, 0], kind="stable")
    begin = np.searchsorted(both[rank, 0], np.arange(len(faces) + 1))
    turned = spread_turns(begin, both[rank, 1], np.concatenate([sign, sign])[rank])
    return np.ascontiguousarray(np.where(turned[:, None], faces[:, ::-1], faces)), int(turned.sum())


def rims(faces: Ints) -> list[Ints]:
    """Closed rims as vertices in order, the hole on the right of the walk, the longest first."""
    edges = edges_of(faces)
    rim = np.ascontiguousarray(edges.ends[edges.faces[:, 1] < 0][:, ::-1])
    return loops(rim)


def loops(ends: Ints) -> list[Ints]:
    """Chains of directed edges `(k, 2)` as vertices in order, the longest first."""
    if len(ends) == 0:
        return []
    order, begins = chain_segments(np.ascontiguousarray(ends[:, 0]), np.ascontiguousarray(ends[:, 1]))
    found = [ends[order[a:b], 0] for a, b in itertools.pairwise(begins)]
    return sorted(found, key=len, reverse=True)


def face_normals(xyz: Floats, faces: Ints) -> tuple[Floats, Floats]:
    """Unit normals `(m, 3)` and areas `(m,)`; of a face without area the normal is zero."""
    a, b, c = (xyz[faces[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    size = np.linalg.norm(cross, axis=1)
    return cross / np.maximum(size, 1e-12)[:, None], 0.5 * size


def usual_direction(normal: Floats, area: Floats) -> Floats:
    """Where the largest part of some skin looks to `(3,)`, from unit normals `(k, 3)` and areas `(k,)`."""
    cell = np.floor(normal / _CELL).astype(np.int64)
    _, name = np.unique((cell[:, 0] * 1000 + cell[:, 1]) * 1000 + cell[:, 2], return_inverse=True)
    fullest = name == np.bincount(name, weights=area).argmax()
    middle = (normal[fullest] * area[fullest, None]).sum(axis=0)
    near = normal @ (middle / np.linalg.norm(middle)) > _NEAR_COSINE
    mean = (normal[near] * area[near, None]).sum(axis=0)
    return mean / np.linalg.norm(mean)
