"""The footboard: taken out of the cloud, and compared with the calibrated floor."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats
from footscan.geometry.plane import Plane, fit_plane
from footscan.scanning.cloud import Cloud

BOARD_MARGIN_MM = 2.0
"""Points lower than this above the floor are the board, or light that runs from the skin on to the board."""
_BARE_MM = 0.5
LARGEST_OFFSET_MM = 0.3
LARGEST_TILT_DEG = 0.1
_SEARCH_MM = 15.0
_LAYER_MM = 3.0
_FEWEST_POINTS = 500
_NARROWEST_MM = 20.0


@dataclass(frozen=True)
class BoardCheck:
    """The visible board against the calibrated floor.

    Attributes:
        points: Board points used; 0 when too little of the board was seen.
        offset_mm: Height of the visible board above the calibrated floor at the axis.
        tilt_deg: Angle between them.
        rms_mm: Residual of the board points to their own plane.
        plane: The visible board.
        remark: A sentence when a limit is exceeded or the check was impossible, else empty.
    """

    points: int
    offset_mm: float | None
    tilt_deg: float | None
    rms_mm: float | None
    plane: Plane | None
    remark: str


def height_above(floor: Plane, xyz_world: Floats) -> Floats:
    """Height `(n,)` in mm of `(n, 3)` points above the calibrated floor."""
    return floor.distance_mm(xyz_world)


def check_board(cloud: Cloud, floor: Plane) -> BoardCheck:
    """Find the board beside the foot, wherever it is within 15 mm of the calibrated floor, and compare them."""
    height = height_above(floor, cloud.xyz_world)
    board = cloud.xyz_world[np.abs(height) < _SEARCH_MM]
    away = board[_far_from_foot(board, cloud.xyz_world[height > _SEARCH_MM])]
    away = _densest_layer(away, floor)
    if len(away) < _FEWEST_POINTS or _narrow_extent_mm(away[:, :2]) < _NARROWEST_MM:
        return BoardCheck(len(away), None, None, None, None, "too little of the footboard was seen to check it")
    plane = fit_plane(away)
    residual = plane.distance_mm(away)
    plane = fit_plane(away[np.abs(residual) <= 3.0 * np.median(np.abs(residual)) + 0.02])
    # height of the plane over the axis, above the floor there
    n, f = plane.normal_array, floor.normal_array
    offset_mm = float(plane.offset_mm / n[2] - floor.offset_mm / f[2])
    tilt_deg = float(np.degrees(np.arccos(min(1.0, float(n @ f)))))
    rms_mm = float(np.sqrt(np.mean(plane.distance_mm(away) ** 2)))
    return BoardCheck(len(away), offset_mm, tilt_deg, rms_mm, plane, _remark(offset_mm, tilt_deg))


def bare_board(cloud: Cloud, board: Plane) -> Floats:
    """Places `(n, 2)`, world, where the bare board itself was lit and seen.

    Args:
        cloud: All points of a scan.
        board: The visible board, or the calibrated floor where it was not found.
    """
    return cloud.xyz_world[np.abs(height_above(board, cloud.xyz_world)) < _BARE_MM, :2]


def _densest_layer(board: Floats, floor: Plane) -> Floats:
    """The points within 3 mm of the height at which most of them lie."""
    if not len(board):
        return board
    height = height_above(floor, board)
    count, edges = np.histogram(height, bins=60, range=(-_SEARCH_MM, _SEARCH_MM))
    middle = 0.5 * float(edges[np.argmax(count)] + edges[np.argmax(count) + 1])
    return board[np.abs(height - middle) < _LAYER_MM]


def _narrow_extent_mm(xy: Floats) -> float:
    """Standard deviation of `(n, 2)` places across the direction in which they spread least."""
    return float(np.sqrt(np.linalg.eigvalsh(np.cov(xy.T))[0]))


def _far_from_foot(board: Floats, foot: Floats) -> Bools:
    """Board points at least 8 mm (in plan) from any cell that holds a foot point."""
    cell = 4.0
    taken = np.zeros((128, 128), dtype=bool)
    place = np.clip(np.floor(foot[:, :2] / cell).astype(int) + 64, 2, 125)
    for du in range(-2, 3):
        for dv in range(-2, 3):
            taken[place[:, 0] + du, place[:, 1] + dv] = True
    own = np.clip(np.floor(board[:, :2] / cell).astype(int) + 64, 0, 127)
    return ~taken[own[:, 0], own[:, 1]]


def _remark(offset_mm: float, tilt_deg: float) -> str:
    if abs(offset_mm) <= LARGEST_OFFSET_MM and tilt_deg <= LARGEST_TILT_DEG:
        return ""
    return (
        f"the footboard lies {offset_mm:+.2f} mm and {tilt_deg:.2f} degrees off the calibrated floor "
        f"(allowed {LARGEST_OFFSET_MM} mm and {LARGEST_TILT_DEG} degrees): check the board, "
        "and that the calibration is this machine's, then recalibrate"
    )
