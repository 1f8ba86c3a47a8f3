"""A foot set with its heel on a wedge: the foot bent on to it, and the wedge as a body beside it."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats, Side
from footscan.foot.align import align_foot
from footscan.foot.shell import Shell
from footscan.foot.wedge import Wedge, check_wedge_height
from footscan.foot.wedge_fit import placed_under
from footscan.sim.obstacles import Part
from footscan.sim.surface import Surface, surface_from_trimesh

WIDTH_MM = 130.0
BEHIND_MM = 12.0
"""The wedge stands out behind the heel by this much."""
_TONE = 0.5
_EDGE_MM = 12.0


@dataclass(frozen=True)
class RaisedFoot:
    """A foot on a wedge, the wedge's body, and where it lies."""

    surface: Surface
    body: Part
    wedge: Wedge


def raise_heel(surface: Surface, side: Side, height_mm: float) -> RaisedFoot:
    """Set a foot that stands flat on a wedge that ends under its ball.

    Args:
        surface: The foot on z = 0.
        side: Of it.
        height_mm: Of the wedge under the middle of the heel.

    Raises:
        MeshError: It is no foot, or the wedge is too high for it.
    """
    shell = Shell(surface.xyz_world, surface.faces)
    wedge = placed_under(shell, align_foot(shell, side), check_wedge_height(height_mm))
    bent = Surface(np.ascontiguousarray(wedge.bent(surface.xyz_world)), surface.faces, surface.closed)
    return RaisedFoot(bent, Part(_ramp(bent, wedge), _TONE), wedge)


def _ramp(bent: Surface, wedge: Wedge) -> Surface:
    """The wedge's body: from its thin edge to behind the heel, as broad as a foot with room to either side."""
    import trimesh

    forward = np.array([*wedge.forward_xy, 0.0])
    across = np.array([-forward[1], forward[0], 0.0])
    heel = np.array([*wedge.heel_xy, 0.0])
    rear = bent.xyz_world[bent.xyz_world[:, 2] < wedge.height_mm + 0.2 * wedge.length_mm]
    long = wedge.edge_mm - float(((rear - heel) @ forward).min()) + BEHIND_MM
    edge = heel + wedge.edge_mm * forward
    back = edge - long * forward
    top = back + np.array([0.0, 0.0, long * float(np.tan(wedge.slope_rad))])
    half = 0.5 * WIDTH_MM * across
    corners: Floats = np.stack([place + sign * half for place in (edge, back, top) for sign in (-1.0, 1.0)])
    return surface_from_trimesh(trimesh.convex.convex_hull(corners), _EDGE_MM)
