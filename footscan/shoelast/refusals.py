"""When a last must not be customised for a foot: another one has to be taken, and it is said which way."""

import numpy as np

from footscan.coordinates import Floats
from footscan.errors import InputError, QualityError
from footscan.geometry.nearest import PointTree
from footscan.shoelast.foot_pose import PosedFoot
from footscan.shoelast.model import Shoelast
from footscan.shoelast.prepared_foot import PreparedFoot
from footscan.shoelast.registration import Registration

PARIS_POINT_MM = 20.0 / 3.0
SIZE_RULE_ROOM_MM = 2.0 * PARIS_POINT_MM
"""By the EU size rule a last is two Paris points longer than its foot."""
SHORTEST_ROOM_MM = SIZE_RULE_ROOM_MM - 1.5 * PARIS_POINT_MM
"""A last with less room than this in front of the toes is about two sizes short."""
_EVERYWHERE = 0.9
MOST_OVERSHOOT_MM = 6.0
_MOVED_MM, _LOOKED_AT, _NEIGHBOURS = 0.5, 8000, 48


def check_side(shoelast: Shoelast, foot: PreparedFoot) -> None:
    """Refuse the wrong side.

    Raises:
        InputError: A left foot and a right last, or the other way round.
    """
    if foot.side != shoelast.side:
        raise InputError(
            f"the foot is a {foot.side} one and {shoelast.name} is a {shoelast.side} last; take the {foot.side} last "
            "(`footscan lasts rank` lists both sides)."
        )


def check_size(shoelast: Shoelast, posed: PosedFoot, registration: Registration) -> None:
    """Refuse a last that is about two sizes short, however its toes are shaped.

    Raises:
        QualityError: Grade first.
    """
    stick = float(shoelast.points["toe_point"][0] - shoelast.points["rear_point"][0])
    length = float(posed.points["foremost_point"][0] - posed.points["pternion"][0])
    if stick - length < SHORTEST_ROOM_MM or registration.toe_mm < 0.0:
        longer = stick - length
        by = f"{abs(longer):.1f} mm {'longer' if longer >= 0.0 else 'shorter'} than it"
        short = (SIZE_RULE_ROOM_MM - (stick - length)) / PARIS_POINT_MM
        raise QualityError(
            f"{shoelast.name} is {short:.1f} sizes too short for this foot ({by}, at least "
            f" {SHORTEST_ROOM_MM:.1f} mm are needed; {registration.toe_mm:.1f} mm left in front of the toes): "
            "grade first, or take a longer last; widening cannot make it fit."
        )


def check_not_everywhere(shoelast: Shoelast, signed_mm: Floats) -> None:
    """Refuse a last that is smaller than the foot everywhere, given distances `(n,)` of seen skin (positive outside).

    Raises:
        QualityError: Grade first.
    """
    outside = float(np.mean(signed_mm > 0.0))
    if outside > _EVERYWHERE:
        raise QualityError(
            f"{shoelast.name} is smaller than the foot everywhere ({outside:.0%} of the seen skin stands out): "
            "grade first, or check the unit of the last and of the foot."
        )


def overshoot_mm(places: Floats, need_mm: Floats, xyz: Floats, displacement_mm: Floats, reach_mm: float) -> float:
    """How far a displacement goes beyond what is asked for anywhere near, at most.

    Args:
        places: `(n, 3)` of the standard last that ask for room.
        need_mm: `(n,)` how much.
        xyz: `(m, 3)` places of the standard last.
        displacement_mm: `(m,)` how far they moved.
        reach_mm: What is near.
    """
    moved = np.flatnonzero(displacement_mm > _MOVED_MM)
    if len(moved) == 0:
        return 0.0
    moved = moved[:: 1 + len(moved) // _LOOKED_AT]
    if len(places) == 0:
        return float(displacement_mm.max())
    _, which = PointTree(places).nearest(np.ascontiguousarray(xyz[moved]), _NEIGHBOURS, reach_mm)
    asked = np.append(need_mm, 0.0)[np.minimum(which, len(need_mm))].max(axis=1)
    return float((displacement_mm[moved] - asked).max())


def check_no_spike(shoelast: Shoelast, beyond_mm: float) -> None:
    """Refuse a displacement that swings far beyond what the foot asks for, as patchy skin can make it do.

    Raises:
        QualityError: Scan again, or take another last.
    """
    if beyond_mm > MOST_OVERSHOOT_MM:
        raise QualityError(
            f"customising {shoelast.name} would move it {beyond_mm:.1f} mm further than any skin near asks for (at most"
            f" {MOST_OVERSHOOT_MM:g} mm): no last to mill. Take a wider last, a longer transition, or a fuller scan."
        )
