"""Room of a last at every vertex of the foot's skin, for maps; what was never seen has none."""

import numpy as np

from footscan.coordinates import Floats
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.shoelast.foot_pose import PosedFoot
from footscan.shoelast.skin import LastSkin
from footscan.shoelast.top_line import FeatherLine, TopLine


def skin_clearance(skin: LastSkin, posed: PosedFoot, top_line: TopLine, feather: FeatherLine) -> Floats:
    """Signed clearance (mm) at the vertices of a posed foot.

    Args:
        skin: Mesh of the last.
        posed: The foot in the last's frame.
        top_line: Up to where skin counts.
        feather: Above which it counts.

    Returns:
        `(n,)`, positive where the last stands away from the skin; NaN for skin that was never seen or does not count.
    """
    xyz, shell = posed.shell.xyz, posed.foot.shell
    seen = np.zeros(len(xyz), dtype=np.bool_)
    seen[shell.faces[posed.foot.face_seen]] = True
    counts = seen & top_line.below(xyz) & feather.has_below(xyz)
    clearance = np.full(len(xyz), np.nan)
    clearance[counts] = -DistanceMesh(skin.xyz_shoelast, skin.faces).nearest(xyz[counts]).signed
    return clearance
