"""The top of a wedge under the heel: an inclined plane that a scan shows beside the foot."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from footscan.coordinates import Bools, Floats
from footscan.geometry.plane import Plane, fit_plane

_LOW_MM, _HIGH_MM = 3.0, 160.0
_CELL_MM = 4.0
_NEIGHBOURS, _REACH_MM = 12, 16.0
_FLAT_MM, _TURN_COSINE = 0.6, float(np.cos(np.radians(6.0)))
_SLOPES_RAD = (np.radians(3.0), np.radians(45.0))
_TRIES = 400
_LEAST_CELLS, _LEAST_SPREAD_MM = 60, (12.0, 26.0)
"""A plane counts from so many cells on, spread (standard deviations) by so much along and across its slope. A wedge of
130 mm has 212 cells or more, 25 and 50 mm; the flattest skin of scanned feet at most 137 cells, 18 and 19 mm."""
_UPRIGHT = float(np.sin(np.radians(5.0)))
_WALL_CELLS, _WALL_FROM_MM, _WALL_HEIGHT_MM = 110, 8.0, 15.0
"""An upright plane counts from so many cells on (a wedge of 50 mm: 166 and more; the skin of scanned feet: at most 74)
when it begins on the board and is so high (that of feet begins at 17 mm)."""


@dataclass(frozen=True)
class Ramp:
    """The top of a wedge.

    Attributes:
        plane: Its plane, normal upwards.
        slope_rad: Angle to the board.
        forward_xy: Unit direction down the slope.
        edge_xy: A place of the line in which it meets the board.
        cells: Cells of 4 mm in which it was seen.
    """

    plane: Plane
    slope_rad: float
    forward_xy: tuple[float, float]
    edge_xy: tuple[float, float]
    cells: int


@dataclass(frozen=True)
class Cells:
    """The mean place in each cell of a cloud above the board, `(n, 3)`, unit normals, and where it is locally flat."""

    xyz: Floats
    normal: Floats
    plain: Bools


def find_cells(xyz_world: Floats, floor: Plane) -> Cells:
    """Cells of `(n, 3)` points above the board."""
    height = floor.distance_mm(xyz_world)
    xyz = _cells(xyz_world[(height > _LOW_MM) & (height < _HIGH_MM)])
    if len(xyz) < _LEAST_CELLS:
        return Cells(np.empty((0, 3)), np.empty((0, 3)), np.zeros(0, dtype=np.bool_))
    return Cells(xyz, *_normals(xyz))


def find_ramp(cells: Cells, floor: Plane) -> Ramp | None:
    """The largest inclined plane in a cloud, None when there is none that skin could not be."""
    cosine = cells.normal @ floor.normal_array
    inclined = cells.plain & (cosine < np.cos(_SLOPES_RAD[0])) & (cosine > np.cos(_SLOPES_RAD[1]))
    xyz = cells.xyz[inclined]
    best = _best_plane(xyz, cells.normal[inclined])
    if best is None:
        return None
    members = xyz[best]
    found = _ramp(fit_plane(members), floor, len(members))
    along = members[:, :2] @ np.array(found.forward_xy)
    across = members[:, :2] @ np.array([-found.forward_xy[1], found.forward_xy[0]])
    enough = len(members) >= _LEAST_CELLS and along.std() >= _LEAST_SPREAD_MM[0] and across.std() >= _LEAST_SPREAD_MM[1]
    return found if enough else None


def find_wall(cells: Cells, floor: Plane) -> float | None:
    """Height (mm) of an upright plane that stands on the board, such as the side of a wedge; None without one."""
    cosine = cells.normal @ floor.normal_array
    upright = cells.plain & (np.abs(cosine) < _UPRIGHT)
    xyz, normal = cells.xyz[upright], cells.normal[upright]
    best = _best_plane(xyz, normal)
    if best is None or best.sum() < _WALL_CELLS:
        return None
    height = floor.distance_mm(xyz[best])
    return float(height.max()) if height.min() < _WALL_FROM_MM and np.ptp(height) > _WALL_HEIGHT_MM else None


def _cells(xyz: Floats) -> Floats:
    """The mean place in each cell that holds a point."""
    if not len(xyz):
        return xyz
    cell = np.floor((xyz - xyz.min(axis=0)) / _CELL_MM).astype(np.int64)
    size = cell.max(axis=0) + 1
    _, which = np.unique((cell[:, 0] * size[1] + cell[:, 1]) * size[2] + cell[:, 2], return_inverse=True)
    count = np.bincount(which)
    return np.column_stack([np.bincount(which, xyz[:, k]) / count for k in range(3)])


def _normals(xyz: Floats) -> tuple[Floats, Bools]:
    """Upward unit normals `(n, 3)` through the neighbours, and where these lie in a plane."""
    distance, index = KDTree(xyz).query(xyz, _NEIGHBOURS, distance_upper_bound=_REACH_MM)
    index = np.where(np.isfinite(distance), index, np.arange(len(xyz))[:, None])
    near = xyz[index]
    off = near - near.mean(axis=1, keepdims=True)
    values, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", off, off) / _NEIGHBOURS)
    normal = axes[:, :, 0]
    normal = np.where(normal[:, 2:] < 0.0, -normal, normal)
    return normal, (np.sqrt(np.maximum(values[:, 0], 0.0)) < _FLAT_MM) & np.isfinite(distance).all(axis=1)


def _best_plane(xyz: Floats, normal: Floats) -> Bools | None:
    """Members `(n,)` of the plane through one of the cells that holds most others."""
    if not len(xyz):
        return None
    tries = np.linspace(0, len(xyz) - 1, min(_TRIES, len(xyz))).astype(np.int64)
    off = np.abs(xyz @ normal[tries].T - np.einsum("ij,ij->i", xyz[tries], normal[tries]))
    alike = np.abs(normal @ normal[tries].T) > _TURN_COSINE
    best = int((alike & (off < 2.0 * _FLAT_MM)).sum(axis=0).argmax())
    members = alike[:, best] & (off[:, best] < 2.0 * _FLAT_MM)
    for _ in range(5):
        if members.sum() < 3:
            return None
        plane = fit_plane(xyz[members])
        members = (np.abs(plane.distance_mm(xyz)) < _FLAT_MM) & (np.abs(normal @ plane.normal_array) > _TURN_COSINE)
    return members


def _ramp(plane: Plane, floor: Plane, cells: int) -> Ramp:
    n, f = plane.normal_array, floor.normal_array
    down = n - float(n @ f) * f
    forward = down[:2] / np.linalg.norm(down[:2])
    place = np.linalg.lstsq(np.stack([n, f]), np.array([plane.offset_mm, floor.offset_mm]), rcond=None)[0]
    slope = float(np.arccos(np.clip(n @ f, -1.0, 1.0)))
    return Ramp(plane, slope, (float(forward[0]), float(forward[1])), (float(place[0]), float(place[1])), cells)
