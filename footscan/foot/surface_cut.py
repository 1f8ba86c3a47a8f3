"""Where the leg is cut: as high as it was seen nearly all around, never below ankle bones that were seen."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.errors import MeshError
from footscan.foot.surface_chart import box_middle

_AZIMUTHS = 24
_REACHED = 3  # points needed above a height before an azimuth counts as seen there
_MARGIN_MM = 1.0
_ANKLE_SHARE = 0.36  # of the foot's length: both ankle bones lie below (METROLOGY: 15-110 mm for 270 mm)


@dataclass(frozen=True)
class LegCut:
    """The flat cut through the leg.

    Attributes:
        z_mm: Its height above the board.
        seen_share: Share of the azimuths whose skin was seen up to it.
        reason: Why it lies there, for the report.
    """

    z_mm: float
    seen_share: float
    reason: str


def find_leg_cut(xyz_world: Floats, needed_share: float) -> LegCut:
    """Choose the height of the cut.

    Args:
        xyz_world: `(n, 3)` points of one foot.
        needed_share: Share of the azimuths around the leg whose skin must reach the cut.

    Raises:
        MeshError: Nothing of the leg or the upper foot was seen.
    """
    low_mm, length = box_middle(xyz_world[xyz_world[:, 2] < np.percentile(xyz_world[:, 2], 40)][:, :2])
    ankle = _ANKLE_SHARE * length
    tops = azimuth_tops(xyz_world, ankle, low_mm)
    covered = float(np.quantile(tops, 1.0 - needed_share, method="lower")) - _MARGIN_MM
    if covered >= ankle:
        return _cut(tops, covered, f"skin seen up to here in {needed_share:.0%} of the directions around the leg")
    half_seen = float(np.quantile(tops, 0.5)) - _MARGIN_MM
    z = min(max(half_seen, covered), ankle)
    if z < 0.1 * length:
        raise MeshError(
            f"the skin is seen only up to {z:.0f} mm above the board, a foot of {length:.0f} mm needs its instep "
            f"({0.25 * length:.0f} mm at least): this looks like a plantar scan or no foot at all; scan again"
        )
    return _cut(tops, z, "kept above the ankle bones, although less of the leg was seen than wanted")


def _cut(tops: Floats, z_mm: float, reason: str) -> LegCut:
    return LegCut(z_mm, float((tops >= z_mm).mean()), reason)


def azimuth_tops(xyz_world: Floats, ankle_mm: float, low_mm: tuple[float, float]) -> Floats:
    """Height `(24,)` up to which the skin was seen in each direction around the leg (0 where never).

    Args:
        xyz_world: `(n, 3)` points.
        ankle_mm: A height at which there is leg.
        low_mm: Middle of the foot; directions count from leg to there, so that they turn with the foot.
    """
    z = xyz_world[:, 2]
    top = min(float(np.percentile(z, 99.8)), 1.2 * ankle_mm)
    leg_mm, _ = box_middle(xyz_world[(z > 0.8 * top) & (z < 1.3 * top)][:, :2])
    away = xyz_world[:, :2] - np.array(leg_mm)
    heading = np.arctan2(low_mm[1] - leg_mm[1], low_mm[0] - leg_mm[0])
    turn = (np.arctan2(away[:, 1], away[:, 0]) - heading) / (2.0 * np.pi)
    which = np.floor(np.mod(turn, 1.0) * _AZIMUTHS).astype(np.int64) % _AZIMUTHS
    tops = np.zeros(_AZIMUTHS)
    for k in range(_AZIMUTHS):
        column = z[which == k]
        tops[k] = np.partition(column, -_REACHED)[-_REACHED] if len(column) >= _REACHED else 0.0
    return tops
