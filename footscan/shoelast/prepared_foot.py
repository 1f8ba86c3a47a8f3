"""A measured foot made ready for lasts: its skin in the foot frame, what of it was seen, and its landmarks."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import trimesh

from footscan.coordinates import Bools, Floats, Side
from footscan.errors import MeshError
from footscan.foot.foot_frame import FootFrame
from footscan.foot.measurements import Measurements, measure
from footscan.foot.repair import repair_shell
from footscan.foot.shell import Shell, area_mm2, moved, shell_from_mesh
from footscan.foot.skin_origin import Origin
from footscan.foot.wedge import Wedge
from footscan.foot.wedge_fit import flat_shell

_CAP_MM, _LEVEL = 1.0, 0.9
"""A face this near to the highest skin whose normal points up more than this is the lid of a cut, not skin."""
NEEDED = ("foot_length", "ball_length", "ball_girth", "foot_breadth")


@dataclass(frozen=True)
class PreparedFoot:
    """A foot that lasts can be compared with.

    Attributes:
        side: Of the real foot; in memory y is medial for both.
        shell: Skin in the foot frame, closed; of a foot scanned on a wedge with its rearfoot turned back.
        face_seen: `(m,)` faces whose three corners were seen; without a known origin, those above 8 mm.
        points: Landmarks in the foot frame, name -> `(3,)`.
        measurements: All of them.
    """

    side: Side
    shell: Shell
    face_seen: Bools
    points: Mapping[str, Floats]
    measurements: Measurements

    @property
    def frame(self) -> FootFrame:
        """From the coordinates of the mesh that was given to the foot frame and back."""
        return self.measurements.frame

    @property
    def wedge(self) -> Wedge | None:
        """On which it was scanned; None for the flat board."""
        return self.measurements.wedge

    def value(self, name: str) -> float:
        """A measurement that fitting cannot do without (`NEEDED`), in its unit.

        Raises:
            MeshError: The foot does not give it.
        """
        found = self.measurements[name]
        if found.value is None:
            raise MeshError(f"{name} could not be measured ({found.reason}); a last cannot be chosen for this foot.")
        return found.value


def prepare_foot(
    mesh: trimesh.Trimesh,
    side: Side | None = None,
    load: str = "unknown",
    absent: tuple[str, ...] = (),
    wedge: Wedge | float | None = None,
) -> PreparedFoot:
    """Measure a foot and bring its skin into the foot frame.

    Args:
        mesh: In mm, standing on z = 0, any heading; the vertex attribute `origin` says which skin was seen.
        side: The operator's word; None takes the side of the shape.
        load: How it was loaded, as somebody said.
        absent: Missing parts.
        wedge: The wedge under the heel during the scan: where it lies, or its height in mm under the middle of the
            heel; None or up to 2 mm for the flat board.

    Raises:
        MeshError: The mesh is no foot, or its heel stands raised without a wedge.
    """
    measured = measure(mesh, side, load=load, absent=absent, wedge=wedge)
    repaired = repair_shell(shell_from_mesh(mesh))
    flat = repaired.shell if measured.wedge is None else flat_shell(repaired.shell, measured.wedge)
    shell = moved(flat, measured.foot_from_input)
    seen = shell.seen.copy()
    seen[repaired.bridged] = False
    points = {name: measured.frame.to_foot(mark.xyz[None])[0] for name, mark in measured.landmarks.items()}
    face_seen = seen[shell.faces].all(axis=1) & ~_is_lid(shell)
    return PreparedFoot(measured.side, shell, face_seen, points, measured)


def _is_lid(shell: Shell) -> Bools:
    """`(m,)` faces of the flat top where the leg was cut."""
    corner = shell.xyz[shell.faces]
    twice = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 2]
    level = twice > _LEVEL * 2.0 * area_mm2(shell)
    lid = level & (corner[:, :, 2].min(axis=1) > shell.xyz[:, 2].max() - _CAP_MM)
    return lid if shell.origin is None else lid | (shell.origin[shell.faces] == Origin.CUT).any(axis=1)
