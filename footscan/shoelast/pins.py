"""Spot allowances: more or less room round a place of the foot, such as a bunion, a hammer toe or an ulcer."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.errors import InputError
from footscan.foot.sole_bend import smooth_step
from footscan.shoelast.foot_pose import PosedFoot
from footscan.shoelast.foot_samples import FootSamples

RADIUS_MM, EXTRA_MM = (3.0, 60.0), (-6.0, 15.0)
FAR_MM = 25.0


@dataclass(frozen=True)
class Pin:
    """A spot allowance.

    Attributes:
        xyz: `(3,)` on the foot, in the coordinates of the mesh that was given (mm).
        radius_mm: Full within half of it, gone at it.
        extra_mm: Added to the least clearance; negative where the last may press.
        why: For people.
    """

    xyz: tuple[float, float, float]
    radius_mm: float
    extra_mm: float
    why: str = ""

    def __post_init__(self) -> None:
        """Refuse numbers outside what is allowed.

        Raises:
            InputError: Radius or extra room.
        """
        for name, value, (low, high) in (
            ("radius", self.radius_mm, RADIUS_MM),
            ("extra room", self.extra_mm, EXTRA_MM),
        ):
            if not low <= value <= high:
                raise InputError(f"a pin's {name} of {value:g} mm was asked for, allowed are {low:g} to {high:g} mm.")


def pinned_mm(pins: tuple[Pin, ...], posed: PosedFoot, samples: FootSamples) -> Floats:
    """Extra room `(n,)` of samples; overlapping pins do not add up, the largest counts (of negative ones the least).

    Raises:
        InputError: A pin far from the foot.
    """
    if not pins:
        return np.zeros(len(samples.xyz))
    foot = posed.foot
    corner = foot.shell.xyz[foot.shell.faces[samples.face]]
    xyz_foot = np.einsum("nk,nkc->nc", samples.weight, corner)
    more, less = np.zeros(len(xyz_foot)), np.zeros(len(xyz_foot))
    for pin in pins:
        at = foot.frame.to_foot(np.array([pin.xyz], dtype=np.float64))[0]
        gap = np.linalg.norm(xyz_foot - at, axis=1)
        if gap.min() > FAR_MM:
            raise InputError(
                f"the pin at {pin.xyz} lies {gap.min():.0f} mm from the foot; give its place in the coordinates of the "
                "foot's own file, in mm."
            )
        extra = pin.extra_mm * (1.0 - smooth_step((gap / pin.radius_mm - 0.5) / 0.5))
        more, less = np.maximum(more, extra), np.minimum(less, extra)
    return more + less
