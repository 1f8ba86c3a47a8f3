"""A measured foot made ready for lasts: its skin in the foot frame, what of it was seen, and its landmarks."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import trimesh

from footscan.coordinates import Bools, Floats, Side
from footscan.errors import MeshError, QualityError
from footscan.foot.measurements import Measurements, measure
from footscan.foot.repair import repair_shell
from footscan.foot.shell import Shell, area_mm2, moved, shell_from_mesh
from footscan.foot.skin_origin import Origin

_CAP_MM, _LEVEL = 1.0, 0.9
"""A face this near to the highest skin whose normal points up more than this is the lid of a cut, not skin."""
_FLAT_MM = 2.0
"""The heel may stand higher than the ball by this much in a scan that counts as flat."""
NEEDED = ("foot_length", "ball_length", "ball_girth", "foot_breadth")


@dataclass(frozen=True)
class PreparedFoot:
    """A foot that lasts can be compared with.

    Attributes:
        side: Of the real foot; in memory y is medial for both.
        shell: Skin in the foot frame, closed.
        face_seen: `(m,)` faces whose three corners were seen; without a known origin, those above 8 mm.
        points: Landmarks in the foot frame, name -> `(3,)`.
        measurements: All of them.
        foot_from_input: 4x4 from the coordinates of the mesh that was given.
    """

    side: Side
    shell: Shell
    face_seen: Bools
    points: Mapping[str, Floats]
    measurements: Measurements
    foot_from_input: Floats

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
    wedge_mm: float | None = None,
) -> PreparedFoot:
    """Measure a foot and bring its skin into the foot frame.

    Args:
        mesh: In mm, standing on z = 0, any heading; the vertex attribute `origin` says which skin was seen.
        side: The operator's word; None takes the side of the shape.
        load: How it was loaded, as somebody said.
        absent: Missing parts.
        wedge_mm: Height of a wedge under the heel during the scan; None or 0 for the flat board. Scans on a wedge are
            refused.

    Raises:
        MeshError: The mesh is no foot.
        QualityError: It was scanned on a wedge: its landmarks would be sought at the wrong heights.
    """
    _check_flat(wedge_mm or 0.0)
    measured = measure(mesh, side, load=load, absent=absent)
    repaired = repair_shell(shell_from_mesh(mesh))
    shell = moved(repaired.shell, measured.foot_from_input)
    seen = shell.seen.copy()
    seen[repaired.bridged] = False
    points = {name: _in_frame(mark.xyz, measured.foot_from_input) for name, mark in measured.landmarks.items()}
    face_seen = seen[shell.faces].all(axis=1) & ~_is_lid(shell)
    return PreparedFoot(measured.side, shell, face_seen, points, measured, measured.foot_from_input)


def _check_flat(wedge_mm: float) -> None:
    """Refuse what cannot be measured: with a raised heel, landmarks are not at the heights where they are sought."""
    if wedge_mm > _FLAT_MM:
        raise QualityError(
            f"the foot was scanned with its heel on a wedge of {wedge_mm:g} mm: feet on a wedge cannot be measured or "
            f"laid into a last yet, at most {_FLAT_MM:g} mm. Scan it on the flat board and take a last with a lower "
            "pitch."
        )


def _in_frame(xyz: Floats, foot_from_input: Floats) -> Floats:
    return foot_from_input[:3, :3] @ xyz + foot_from_input[:3, 3]


def _is_lid(shell: Shell) -> Bools:
    """`(m,)` faces of the flat top where the leg was cut."""
    corner = shell.xyz[shell.faces]
    twice = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 2]
    level = twice > _LEVEL * 2.0 * area_mm2(shell)
    lid = level & (corner[:, :, 2].min(axis=1) > shell.xyz[:, 2].max() - _CAP_MM)
    return lid if shell.origin is None else lid | (shell.origin[shell.faces] == Origin.CUT).any(axis=1)
