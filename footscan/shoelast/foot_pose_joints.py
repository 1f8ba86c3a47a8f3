"""How a foot bends on to the bottom of a last: four segments, three joints and the ankle, each free, limited or fused.

The segments are heel, shank, ball and toes; between them lie midfoot, MTP and hallux (`foot.sole_bend`).
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy import optimize

from footscan.coordinates import Floats
from footscan.foot.sole_bend import Bend

Freedom = Literal["free", "limited", "fused"]
JOINTS = ("midfoot", "mtp", "hallux")

_LIMITED_RAD = {"ankle": np.radians(8.0), "midfoot": np.radians(3.0), "mtp": np.radians(8.0), "hallux": np.radians(6.0)}
_FREE_RAD = {
    "ankle": np.radians(50.0),
    "midfoot": np.radians(12.0),
    "mtp": np.radians(40.0),
    "hallux": np.radians(30.0),
}
_HALF_STEP_SHARE = 0.08
"""A joint's bend is spread over this share of the foot length to either side (21 mm of 260)."""
_EXACT = 30.0
"""Weight of the heel's height beside the directions of the segments."""


@dataclass(frozen=True)
class Joints:
    """What each joint may do."""

    ankle: Freedom = "free"
    midfoot: Freedom = "free"
    mtp: Freedom = "free"
    hallux: Freedom = "free"

    def most_rad(self, name: str) -> float:
        """The largest angle of a joint."""
        freedom: Freedom = getattr(self, name)
        return 0.0 if freedom == "fused" else _LIMITED_RAD[name] if freedom == "limited" else _FREE_RAD[name]


def fit_bend(
    joints: Joints,
    place_mm: Floats,
    ends_mm: tuple[float, float],
    length_mm: float,
    wanted_rad: Floats,
    raise_mm: float,
) -> Bend:
    """Find the joints' angles that follow a last's bottom best, the heel's height first of all.

    Args:
        joints: What each joint may do.
        place_mm: `(3,)` midfoot, MTP and hallux along the foot.
        ends_mm: Middle of the heel and of the toes along the foot.
        length_mm: Foot length.
        wanted_rad: `(4,)` directions of the last's bottom (with the insole) under heel, shank, ball and toes.
        raise_mm: How much higher than the ball the middle of the heel is to lie.
    """
    size = np.diff(np.concatenate([[ends_mm[0]], place_mm, [ends_mm[1]]]))
    upto = np.tril(np.ones((4, 4)))  # directions of the segments from (heel, joints)
    lever = (size[:2, None] * upto[:2]).sum(axis=0) / size[:2].sum()
    rows = np.vstack([upto * np.sqrt(size / size.sum())[:, None], _EXACT * lever])
    right = np.append(
        wanted_rad * np.sqrt(size / size.sum()), -_EXACT * np.arcsin(np.clip(raise_mm / size[:2].sum(), -1, 1))
    )
    most = np.array([np.pi / 4.0, *(max(joints.most_rad(name), 1e-9) for name in JOINTS)])
    solver: Any = optimize
    found = solver.lsq_linear(rows, right, (-most, most)).x
    angles = np.where(most[1:] <= 1e-9, 0.0, found[1:])
    ankle = float(np.clip(found[0], -joints.most_rad("ankle"), joints.most_rad("ankle")))
    return Bend(float(found[0]), angles, place_mm, _HALF_STEP_SHARE * length_mm, ankle)
