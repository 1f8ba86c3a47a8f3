"""Removal of everything that is not the foot: the board, loose specks, other bodies, points off the surface."""

from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import Bools, Floats, Ints
from footscan.geometry.bodies import label_bodies
from footscan.geometry.nearest import PointTree
from footscan.geometry.plane import Plane
from footscan.scanning.cloud import Cloud
from footscan.scanning.footboard import BOARD_MARGIN_MM, height_above

_CELL_MM = 5.0
_SAME_BODY_GAP_MM = 15.0
_SPECK_SHARE = 0.002
_NEIGHBOURS = 24
_PARTS = 2
_REACH_MM = 5.0
_FEWEST_NEIGHBOURS = 6
_OFF_SURFACE_MM = 0.6
_OFF_SURFACE_SCALES = 5.0


def foot_body(cloud: Cloud, *boards: Plane) -> tuple[Cloud, Counter[str]]:
    """Take away the board, specks and other bodies; what is left is still in two layers where a foot moved.

    Args:
        cloud: All points of the scan.
        boards: The calibrated floor, and the visible board where it lies elsewhere: a point must be above all of them.

    Returns:
        The foot's (or the object's) points, and how many were removed for which reason.
    """
    removed: Counter[str] = Counter()
    for reason, test in (
        ("footboard", lambda c: _above(c.xyz_world, boards)),
        ("other body", lambda c: _main_body(c.xyz_world)),
    ):
        cloud = _where(cloud, test, reason, removed)
    return cloud, removed


def clean_cloud(cloud: Cloud, *boards: Plane) -> tuple[Cloud, Counter[str]]:
    """Keep the points of the foot (or of the object that stands on the board): `foot_body`, then `smooth_skin`."""
    body, removed = foot_body(cloud, *boards)
    skin, off = smooth_skin(body)
    return skin, removed + off


def smooth_skin(cloud: Cloud) -> tuple[Cloud, Counter[str]]:
    """Remove the points that lie off the smooth surface through their neighbours; their number is in the counter."""
    removed: Counter[str] = Counter()
    return _where(cloud, lambda c: _on_surface(c.xyz_world), "off the surface", removed), removed


def _where(cloud: Cloud, test: Callable[[Cloud], Bools], reason: str, removed: Counter[str]) -> Cloud:
    if not len(cloud):
        return cloud
    keep = test(cloud)
    removed[reason] += int(len(keep) - keep.sum())
    return cloud.where(keep)


def _above(xyz_world: Floats, boards: tuple[Plane, ...]) -> Bools:
    heights = [height_above(board, xyz_world) for board in boards]
    return np.min(heights, axis=0) > BOARD_MARGIN_MM


def _main_body(xyz_world: Floats) -> Bools:
    """The largest connected body, and what lies within 15 mm of it and is no speck."""
    body, gap_mm = label_bodies(xyz_world, _CELL_MM)
    size = np.bincount(body)
    return (body == 0) | ((gap_mm <= _SAME_BODY_GAP_MM) & (size[body] >= _SPECK_SHARE * len(body)))


def _on_surface(xyz_world: Floats) -> Bools:
    """Points with enough neighbours that lie on the quadratic through them, judged against the local scatter."""
    _, index = PointTree(xyz_world).nearest(xyz_world, _NEIGHBOURS, _REACH_MM)
    residual, members = np.empty(len(xyz_world)), np.empty(len(xyz_world), dtype=np.int64)
    parts = np.linspace(0, len(xyz_world), _PARTS + 1).astype(int)
    with ThreadPoolExecutor(_PARTS) as pool:
        for part in [
            pool.submit(_off_quadratic, xyz_world, a, index[a:b], residual[a:b], members[a:b])
            for a, b in pairwise(parts.tolist())
        ]:
            part.result()
    known = np.abs(residual[np.isfinite(residual)])
    scatter = float(np.median(known)) if len(known) else 0.0
    limit = max(_OFF_SURFACE_MM, _OFF_SURFACE_SCALES * 1.4826 * scatter)
    return (members >= _FEWEST_NEIGHBOURS) & ~(np.abs(residual) > limit)


@compiled
def _off_quadratic(xyz: Floats, begin: int, index: Ints, residual: Floats, members: Ints) -> None:
    """Distance of points (from `begin` on) from the quadratic over their neighbours' tangent plane, itself left out."""
    n = xyz.shape[0]
    for i in range(index.shape[0]):
        count = 0
        mean = np.zeros(3)
        for k in range(1, index.shape[1]):
            if index[i, k] < n:
                count += 1
                mean += xyz[index[i, k]]
        members[i] = count
        residual[i] = np.nan
        if count < 10:
            continue
        mean /= count
        covariance = np.zeros((3, 3))
        for k in range(1, count + 1):
            d = xyz[index[i, k]] - mean
            for a in range(3):
                for b in range(3):
                    covariance[a, b] += d[a] * d[b]
        _, axes = np.linalg.eigh(covariance)
        normal, s_axis, t_axis = axes[:, 0], axes[:, 2], axes[:, 1]
        matrix, right = np.zeros((6, 6)), np.zeros(6)
        for k in range(1, count + 1):
            d = xyz[index[i, k]] - xyz[begin + i]
            s, t = (d * s_axis).sum() / _REACH_MM, (d * t_axis).sum() / _REACH_MM
            row = np.array([1.0, s, t, s * s, s * t, t * t])
            height = (d * normal).sum()
            for a in range(6):
                right[a] += row[a] * height
                for b in range(6):
                    matrix[a, b] += row[a] * row[b]
        for a in range(6):
            matrix[a, a] += 1e-3 * count if a > 2 else 1e-6 * count
        residual[i] = -np.linalg.solve(matrix, right)[0]
