"""Where every place of the flat foot goes when it is bent and laid into a last."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.foot.sole_bend import BentFoot, turned


@dataclass(frozen=True)
class PlacedFoot:
    """The bent foot turned about y (rad, +x lifted) and shifted `(3,)` into the last's frame."""

    bent: BentFoot
    turn_rad: float
    shift: Floats

    def __call__(self, xyz: Floats) -> Floats:
        """Places `(n, 3)` in the last's frame of places of the flat foot."""
        bent = self.bent(xyz)
        x, z = turned(bent[:, 0], bent[:, 2], self.turn_rad)
        return np.column_stack([x, bent[:, 1], z]) + self.shift
