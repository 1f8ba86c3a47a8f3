"""Whether a scan saw the whole foot: points that end at the border of the working volume belong to skin beyond it."""

import numpy as np

from footscan.coordinates import WORKING_RADIUS_MM, Floats
from footscan.errors import MeshError

_BORDER_MM = 3.0
_FEWEST_POINTS = 20
_EDGE_Z_MM = 5.0
"""Points lower than this may be the board's."""


def check_inside_view(xyz_world: Floats, radius_mm: float = WORKING_RADIUS_MM) -> None:
    """Refuse a cloud that reaches the border of the working volume, saying where.

    Args:
        xyz_world: `(n, 3)` points of the skin.
        radius_mm: How far from the axis of rotation the machine measures.

    Raises:
        MeshError: More than a few points lie within some millimetres of the border.
    """
    distance = np.hypot(xyz_world[:, 0], xyz_world[:, 1])
    at_border = xyz_world[(distance > radius_mm - _BORDER_MM) & (xyz_world[:, 2] > _EDGE_Z_MM)]
    if len(at_border) < _FEWEST_POINTS:
        return
    x, y, _ = np.median(at_border, axis=0)
    azimuth = np.degrees(np.arctan2(y, x)) % 360.0
    raise MeshError(
        f"the foot reaches the border of the view, {radius_mm:.0f} mm from the axis, at x = {x:.0f} mm, y = {y:.0f} mm "
        f"({azimuth:.0f} degrees): place it so that all of it is nearer to the middle, and scan again"
    )
