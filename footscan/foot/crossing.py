"""Where a plane crosses triangles: oriented segments, their chains, and convex hulls, as compiled loops."""

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import Floats, Ints


@compiled
def find_crossings(distance: Floats, faces: Ints) -> Ints:
    """The edges through which a plane enters and leaves each face it crosses.

    Args:
        distance: `(n,)` signed distance of every vertex; zero counts as positive, so nothing lies in the plane.
        faces: `(m, 3)` counter-clockwise seen from outside.

    Returns:
        `(k, 4)` vertices (a, b, c, d): each segment runs from edge ab to edge cd, with the inside of the body on the
        left when seen from where the plane's normal points.
    """
    count = 0
    for f in range(faces.shape[0]):
        i, j, k = distance[faces[f, 0]] >= 0.0, distance[faces[f, 1]] >= 0.0, distance[faces[f, 2]] >= 0.0
        if i != j or j != k:
            count += 1
    result = np.empty((count, 4), dtype=np.int64)
    row = 0
    for f in range(faces.shape[0]):
        i, j, k = distance[faces[f, 0]] >= 0.0, distance[faces[f, 1]] >= 0.0, distance[faces[f, 2]] >= 0.0
        if i == j and j == k:
            continue
        alone = 2 if i == j else (1 if i == k else 0)
        a, b, c = faces[f, alone], faces[f, (alone + 1) % 3], faces[f, (alone + 2) % 3]
        if distance[a] >= 0.0:
            result[row] = (a, b, c, a)
        else:
            result[row] = (c, a, a, b)
        row += 1
    return result


@compiled
def chain_segments(start: Ints, end: Ints) -> tuple[Ints, Ints]:
    """Put oriented segments one after the other.

    Args:
        start: `(k,)` key of the edge where a segment begins.
        end: `(k,)` key of the edge where it ends.

    Returns:
        `(k,)` segments in order, and `(loops + 1,)` where each chain begins. Open chains come first; an edge
        shared by more than two faces is used once per pair.
    """
    count = len(start)
    order = np.argsort(start, kind="mergesort")
    keys = start[order]
    known_ends = np.sort(end)
    used = np.zeros(count, dtype=np.bool_)
    chained = np.empty(count, dtype=np.int64)
    begins = np.empty(count + 1, dtype=np.int64)
    filled, chains = 0, 0
    for only_open in (True, False):
        for first in range(count):
            if used[first]:
                continue
            if only_open:
                place = np.searchsorted(known_ends, start[first])
                if place < count and known_ends[place] == start[first]:
                    continue
            begins[chains] = filled
            chains += 1
            segment = first
            while segment >= 0:
                used[segment] = True
                chained[filled] = segment
                filled += 1
                place = np.searchsorted(keys, end[segment])
                segment = -1
                while place < count and keys[place] == end[chained[filled - 1]]:
                    if not used[order[place]]:
                        segment = order[place]
                        break
                    place += 1
    begins[chains] = filled
    return chained, begins[: chains + 1].copy()


@compiled
def _hull_of_sorted(points: Floats) -> Ints:
    """Andrew's monotone chain over `(n, 2)` points sorted by x, then y; counter-clockwise places, n >= 1."""
    count = len(points)
    hull = np.empty(2 * count + 1, dtype=np.int64)
    size = 0
    for turn in range(2):
        floor = size if turn else 1
        for step in range(count):
            if turn and step == 0:
                continue
            i = count - 1 - step if turn else step
            while size > floor:
                a, b = hull[size - 2], hull[size - 1]
                cross = (points[b, 0] - points[a, 0]) * (points[i, 1] - points[a, 1]) - (
                    points[b, 1] - points[a, 1]
                ) * (points[i, 0] - points[a, 0])
                if cross > 0.0:
                    break
                size -= 1
            hull[size] = i
            size += 1
    return hull[: max(size - 1, 1)].copy()


def convex_hull(points: Floats) -> Ints:
    """Places `(k,)` of the convex hull of `(n, 2)` points, counter-clockwise; degenerate sets give their ends."""
    if len(points) == 0:
        return np.zeros(0, dtype=np.int64)
    order = np.lexsort((points[:, 1], points[:, 0]))
    return order[_hull_of_sorted(np.ascontiguousarray(points[order]))]


def hull_perimeter_mm(points: Floats) -> float:
    """Length of a tape round `(n, 2)` points."""
    corner = points[convex_hull(points)]
    return float(np.linalg.norm(np.diff(corner, axis=0, append=corner[:1]), axis=1).sum())


@compiled
def find_silhouette(xy: Floats, faces: Ints, first_x: float, step_x: float, count: int) -> Floats:
    """Lowest and highest y of some triangles at evenly spaced x.

    Args:
        xy: `(n, 2)` corners.
        faces: `(m, 3)` triangles.
        first_x: The first place.
        step_x: Distance between places.
        count: How many.

    Returns:
        `(count, 2)` lowest and highest y; infinite where no triangle is.
    """
    result = np.empty((count, 2))
    result[:, 0] = np.inf
    result[:, 1] = -np.inf
    for f in range(faces.shape[0]):
        for side in range(3):
            a, b = faces[f, side], faces[f, (side + 1) % 3]
            if xy[a, 0] > xy[b, 0]:
                a, b = b, a
            low = max(int(np.ceil((xy[a, 0] - first_x) / step_x)), 0)
            high = min(int(np.floor((xy[b, 0] - first_x) / step_x)), count - 1)
            for k in range(low, high + 1):
                width = xy[b, 0] - xy[a, 0]
                share = (first_x + k * step_x - xy[a, 0]) / width if width > 0.0 else 0.0
                y = xy[a, 1] + share * (xy[b, 1] - xy[a, 1])
                result[k, 0] = min(result[k, 0], y)
                result[k, 1] = max(result[k, 1], y)
    return result
