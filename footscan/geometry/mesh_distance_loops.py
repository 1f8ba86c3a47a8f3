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
def split_by_halves(middle: Floats, order: Ints, width: int) -> None:
    """Put faces in the order of a balanced tree: every box is halved at the median of its longest side.

    Args:
        middle: `(m, 3)` middles of the faces, reordered in place.
        order: `(m,)` the faces, reordered likewise.
        width: Faces that a whole box of the first level holds, LEAF times a power of two.
    """
    while width > LEAF:
        for begin in range(0, len(order), width):
            halve(middle, order, begin, min(begin + width, len(order)), begin + width // 2)
        width //= 2


@compiled
def halve(middle: Floats, order: Ints, begin: int, end: int, cut: int) -> None:
    """Quickselect along the longest side: no face before `cut` lies further along than one after it."""
    if cut >= end:
        return
    axis = _longest_side(middle, begin, end)
    low, high = begin, end - 1
    while low < high:
        a, b, c = middle[low, axis], middle[(low + high) // 2, axis], middle[high, axis]
        pivot = max(min(a, b), min(max(a, b), c))
        i, j = low, high
        while i <= j:
            while middle[i, axis] < pivot:
                i += 1
            while middle[j, axis] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                for k in range(3):
                    middle[i, k], middle[j, k] = middle[j, k], middle[i, k]
                i += 1
                j -= 1
        if cut <= j:
            high = j
        elif cut >= i:
            low = i
        else:
            return


@compiled
def _longest_side(middle: Floats, begin: int, end: int) -> int:
    axis, longest = 0, -1.0
    for k in range(3):
        low, high = np.inf, -np.inf
        for i in range(begin, end):
            low, high = min(low, middle[i, k]), max(high, middle[i, k])
        if high - low > longest:
            axis, longest = k, high - low
    return axis


@compiled
def faces_across(faces: Ints, corners: int) -> Ints:
    """The face `(m, 3)` across each side (01, 12, 20) of each face; a side without one has the face itself."""
    begin = np.zeros(corners + 2, np.int64)
    for f in range(len(faces)):
        for k in range(3):
            begin[min(faces[f, k], faces[f, (k + 1) % 3]) + 2] += 1
    for c in range(corners):
        begin[c + 2] += begin[c + 1]
    side = np.empty(3 * len(faces), np.int64)  # sides in the order of their lower corner
    for f in range(len(faces)):
        for k in range(3):
            low = min(faces[f, k], faces[f, (k + 1) % 3]) + 1
            side[begin[low]] = 3 * f + k
            begin[low] += 1
    across = np.empty((len(faces), 3), np.int64)
    for c in range(corners):
        for p in range(begin[c], begin[c + 1]):
            f, k = side[p] // 3, side[p] % 3
            across[f, k] = f
            high = max(faces[f, k], faces[f, (k + 1) % 3])
            for q in range(begin[c], begin[c + 1]):
                g, m = side[q] // 3, side[q] % 3
                if q != p and max(faces[g, m], faces[g, (m + 1) % 3]) == high:
                    across[f, k] = g
    return across


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
def face_corners(xyz: Floats, faces: Ints, corners: Floats, unit: Floats) -> None:
    """Write the corners `(m, 9)` and the outward unit normals `(m, 3)` of faces."""
    for f in range(len(faces)):
        for k in range(3):
            for axis in range(3):
                corners[f, 3 * k + axis] = xyz[faces[f, k], axis]
        c = corners[f]
        ux, uy, uz, vx, vy, vz = c[3] - c[0], c[4] - c[1], c[5] - c[2], c[6] - c[0], c[7] - c[1], c[8] - c[2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        size = max(np.sqrt(x * x + y * y + z * z), 1e-300)
        unit[f, 0], unit[f, 1], unit[f, 2] = x / size, y / size, z / size


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


@compiled
def find_places(
    points: Floats,
    mesh: tuple[Floats, Ints, Ints, Floats, Floats],
    face: Ints,
    weight: Floats,
    place: Ints,
    xyz: Floats,
    normal: Floats,
    signed: Floats,
) -> None:
    """What `find_nearest` found, as places, unit pseudo-normals `(n, 3)` and signed distances `(n,)`.

    Args:
        points: Where it searched from.
        mesh: Corners `(n, 3)`; faces, the faces across their sides and unit normals `(m, 3)` in the tree's order; and
            the normals of the corners.
        face: What it found.
        weight: Likewise.
        place: Likewise.
        xyz: Result.
        normal: Result.
        signed: Result.
    """
    corner_xyz, faces, across, unit, at_corner = mesh
    for i in range(len(points)):
        f, where = face[i], place[i]
        size = along = distance2 = 0.0
        for axis in range(3):
            xyz[i, axis] = (
                weight[i, 0] * corner_xyz[faces[f, 0], axis]
                + weight[i, 1] * corner_xyz[faces[f, 1], axis]
                + weight[i, 2] * corner_xyz[faces[f, 2], axis]
            )
            n = unit[f, axis]
            if where > 3:
                n = at_corner[faces[f, where - 4], axis]
            elif where > 0:
                n += unit[across[f, where - 1], axis]
            normal[i, axis] = n
            away = points[i, axis] - xyz[i, axis]
            size += n * n
            along += n * away
            distance2 += away * away
        size = max(np.sqrt(size), 1e-300)
        for axis in range(3):
            normal[i, axis] /= size
        signed[i] = np.sqrt(distance2) if along >= 0.0 else -np.sqrt(distance2)
