"""Compiled loops of the distance to a mesh: a box tree over triangles in Morton order, and the nearest of them.

Places within a triangle are counted 0 inside; 1, 2, 3 on the sides 01, 12, 20; 4, 5, 6 at the corners 0, 1, 2.
"""

import numpy as np

from footscan.compiled import compiled, compiled_inline
from footscan.coordinates import Floats, Ints

LEAF = 4
_DEPTH = 64


@compiled_inline
def _spread(value: int) -> int:
    """The 16 lowest bits of a number, two zeros between each of them."""
    x = value & 0xFFFF
    x = (x | (x << 32)) & 0x1F00000000FFFF
    x = (x | (x << 16)) & 0x1F0000FF0000FF
    x = (x | (x << 8)) & 0x100F00F00F00F00F
    x = (x | (x << 4)) & 0x10C30C30C30C30C3
    return (x | (x << 2)) & 0x1249249249249249


@compiled
def morton_codes(xyz: Floats, low: Floats, cell: float) -> Ints:
    """Places `(n,)` of points along a Morton curve over cells of a size, from a corner `low` `(3,)`."""
    codes = np.empty(len(xyz), np.int64)
    for i in range(len(xyz)):
        code = 0
        for axis in range(3):
            place = min(max(int((xyz[i, axis] - low[axis]) / cell), 0), 0xFFFF)
            code |= _spread(place) << axis
        codes[i] = code
    return codes


@compiled
def split_by_halves(middle: Floats, order: Ints, leaves: int) -> None:
    """Put faces in the order of a balanced tree: every box is halved at the median of its longest side.

    Args:
        middle: `(m, 3)` middles of the faces.
        order: `(m,)` the faces, reordered in place.
        leaves: Leaves of the tree, a power of two; leaf k gets the faces from k * LEAF on.
    """
    width = leaves * LEAF
    while width > LEAF:
        for begin in range(0, len(order), width):
            end = min(begin + width, len(order))
            cut = begin + width // 2
            if cut < end:
                _halve(middle, order, begin, end, cut)
        width //= 2


@compiled
def _halve(middle: Floats, order: Ints, begin: int, end: int, cut: int) -> None:
    """Quickselect along the longest side: no face before `cut` lies further along than one after it."""
    axis, longest = 0, -1.0
    for k in range(3):
        low, high = np.inf, -np.inf
        for i in range(begin, end):
            low, high = min(low, middle[order[i], k]), max(high, middle[order[i], k])
        if high - low > longest:
            axis, longest = k, high - low
    low, high = begin, end - 1
    while low < high:
        a, b, c = middle[order[low], axis], middle[order[(low + high) // 2], axis], middle[order[high], axis]
        pivot = max(min(a, b), min(max(a, b), c))
        i, j = low, high
        while i <= j:
            while middle[order[i], axis] < pivot:
                i += 1
            while middle[order[j], axis] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if cut <= j:
            high = j
        elif cut >= i:
            low = i
        else:
            return


@compiled
def build_boxes(xyz: Floats, faces: Ints, leaves: int) -> Floats:
    """Boxes `(2 * leaves - 1, 6)` (low, high) of an implicit binary tree; leaf k holds LEAF faces from k * LEAF on."""
    boxes = np.empty((2 * leaves - 1, 6))
    boxes[:, :3] = np.inf
    boxes[:, 3:] = -np.inf
    first = leaves - 1
    for f in range(len(faces)):
        box = boxes[first + f // LEAF]
        for corner in range(3):
            for axis in range(3):
                x = xyz[faces[f, corner], axis]
                box[axis] = min(box[axis], x)
                box[axis + 3] = max(box[axis + 3], x)
    for node in range(first - 1, -1, -1):
        for axis in range(3):
            boxes[node, axis] = min(boxes[2 * node + 1, axis], boxes[2 * node + 2, axis])
            boxes[node, axis + 3] = max(boxes[2 * node + 1, axis + 3], boxes[2 * node + 2, axis + 3])
    return boxes


@compiled_inline
def _box_distance2(boxes: Floats, node: int, x: float, y: float, z: float) -> float:
    dx = max(boxes[node, 0] - x, x - boxes[node, 3], 0.0)
    dy = max(boxes[node, 1] - y, y - boxes[node, 4], 0.0)
    dz = max(boxes[node, 2] - z, z - boxes[node, 5], 0.0)
    return dx * dx + dy * dy + dz * dz


@compiled
def _nearest_in_triangle(x: float, y: float, z: float, corners: Floats, f: int) -> tuple[float, float, float, int]:
    """Squared distance, weights of corners 1 and 2, and place (Ericson, Real-Time Collision Detection, 5.1.5)."""
    ax, ay, az = corners[f, 0], corners[f, 1], corners[f, 2]
    abx, aby, abz = corners[f, 3] - ax, corners[f, 4] - ay, corners[f, 5] - az
    acx, acy, acz = corners[f, 6] - ax, corners[f, 7] - ay, corners[f, 8] - az
    apx, apy, apz = x - ax, y - ay, z - az
    d1, d2 = abx * apx + aby * apy + abz * apz, acx * apx + acy * apy + acz * apz
    bb, bc, cc = abx * abx + aby * aby + abz * abz, abx * acx + aby * acy + abz * acz, acx * acx + acy * acy + acz * acz
    d3, d4, d5, d6 = d1 - bb, d2 - bc, d1 - bc, d2 - cc
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0.0 and d2 <= 0.0:
        v, w, place = 0.0, 0.0, 4
    elif d3 >= 0.0 and d4 <= d3:
        v, w, place = 1.0, 0.0, 5
    elif d6 >= 0.0 and d5 <= d6:
        v, w, place = 0.0, 1.0, 6
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v, w, place = d1 / (d1 - d3), 0.0, 1
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        v, w, place = 0.0, d2 / (d2 - d6), 3
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v, place = 1.0 - w, 2
    else:
        whole = va + vb + vc
        v, w, place = vb / whole, vc / whole, 0
    gx, gy, gz = apx - v * abx - w * acx, apy - v * aby - w * acy, apz - v * abz - w * acz
    return gx * gx + gy * gy + gz * gz, v, w, place


@compiled
def find_nearest(points: Floats, corners: Floats, boxes: Floats, face: Ints, weight: Floats, place: Ints) -> None:
    """Nearest place on the triangles of a box tree, for each of `(n, 3)` points; neighbours in the list should be near.

    Args:
        points: Where to search from.
        corners: `(m, 9)` the triangles in the tree's order.
        boxes: Of the tree.
        face: `(n,)` result: place in the tree's order.
        weight: `(n, 3)` result: barycentric weights.
        place: `(n,)` result: see the module's text.
    """
    leaves = (len(boxes) + 1) // 2
    stack, gaps = np.empty(_DEPTH, np.int64), np.empty(_DEPTH)
    at = 0
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        best, best_v, best_w, best_place = _nearest_in_triangle(x, y, z, corners, at)  # bounds the search
        stack[0], gaps[0] = 0, 0.0
        size = 1
        while size > 0:
            size -= 1
            if gaps[size] >= best:
                continue
            node = stack[size]
            while node < leaves - 1:
                node = 2 * node + 1
                left = _box_distance2(boxes, node, x, y, z)
                right = _box_distance2(boxes, node + 1, x, y, z)
                far, gap = node + 1, right
                if right < left:
                    node, far, gap = node + 1, node, left
                    left = right
                if gap < best:
                    stack[size], gaps[size] = far, gap
                    size += 1
                if left >= best:
                    node = -1
                    break
            if node < 0:
                continue
            begin = (node - leaves + 1) * LEAF
            for f in range(begin, min(begin + LEAF, len(corners))):
                distance2, v, w, where = _nearest_in_triangle(x, y, z, corners, f)
                if distance2 < best:
                    best, best_v, best_w, best_place, at = distance2, v, w, where, f
        face[i], place[i] = at, best_place
        weight[i, 0], weight[i, 1], weight[i, 2] = 1.0 - best_v - best_w, best_v, best_w


@compiled
def corner_normals(xyz: Floats, faces: Ints, unit: Floats) -> Floats:
    """Normals `(n, 3)` of the corners: the faces' unit normals `(m, 3)` weighted by their angles; not of length 1."""
    result = np.zeros((len(xyz), 3))
    for f in range(len(faces)):
        for k in range(3):
            a, b, c = faces[f, k], faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
            ab = ac = bc = 0.0
            for axis in range(3):
                u, v = xyz[b, axis] - xyz[a, axis], xyz[c, axis] - xyz[a, axis]
                ab += u * u
                ac += v * v
                bc += u * v
            size = np.sqrt(ab * ac)
            angle = np.arccos(min(max(bc / size, -1.0), 1.0)) if size > 0.0 else 0.0
            for axis in range(3):
                result[a, axis] += angle * unit[f, axis]
    return result
