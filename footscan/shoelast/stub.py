"""The chuck stub by which a copying machine holds a last: a block behind the heel back."""

import numpy as np
import trimesh

from footscan.shoelast.model import Attachment, Shoelast

WIDTH_MM, REACH_MM, HEIGHT_MM = 14.0, 19.0, 24.0
"""Real stubs were 13-15 mm wide and reached 16-23 mm behind the heel."""
_INTO_HEEL_MM = 6.0
_LEVEL_SHARE = 0.45


def chuck_stub(shoelast: Shoelast) -> Attachment:
    """A stub for a built-in last, at some height of its back, in the frame of the last."""
    back = shoelast.upper.grid(np.array([0.0]), np.linspace(0.0, 1.0, 101))[:, 0]
    level = back[0, 2] + _LEVEL_SHARE * (back[-1, 2] - back[0, 2])
    at = back[np.abs(back[:, 2] - level).argmin()]
    size = np.array([REACH_MM + _INTO_HEEL_MM, WIDTH_MM, HEIGHT_MM])
    box = trimesh.creation.box(extents=size)
    box.apply_translation(at + np.array([-0.5 * (REACH_MM - _INTO_HEEL_MM), 0.0, 0.0]))
    return Attachment("stub", box)
