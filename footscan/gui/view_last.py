"""Lasts in the 3-D view: round the foot, as a clearance map, with changed areas. The scene is in metres."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import viser

from footscan.coordinates import Bytes, Floats, Ints, Side
from footscan.gui.last_choice import LastChoice
from footscan.gui.matte import matte_glb
from footscan.gui.view_foot import FootView

if TYPE_CHECKING:
    from footscan.shoelast.foot_pose import PosedFoot
    from footscan.shoelast.skin import LastSkin

_M = 0.001
_SKIN = (224, 160, 128)
_SEE_THROUGH = 0.35
_PLACE_M = (-0.14, 0.0, 0.0)
"""Of the last's frame: a last of 280 mm stands over the middle of the board."""


class LastView:
    """The last's own things in the scene; the foot of the scan is hidden meanwhile."""

    def __init__(self, server: viser.ViserServer, feet: FootView) -> None:
        self._scene, self._feet = server.scene, feet
        self._handles: list[viser.GlbHandle | viser.MeshHandle] = []

    def show(self, choice: LastChoice, target_mm: float = 0.0) -> None:
        """What was chosen: the last round the foot, the clearance map, or what was changed."""
        from footscan.gui.fitting import custom_clearance
        from footscan.workflow.lasts_colours import change_colours

        for handle in self._handles:
            handle.remove()
        self._handles = []
        fitted, custom = (None, None) if choice.hidden else (choice.fitted, choice.custom)
        if custom is not None and choice.shown == "Changed areas":
            skin = custom.skin
            self._add(
                "changed", skin.xyz_shoelast, skin.faces, change_colours(custom.displacement_mm), custom.shoelast.side
            )
        elif custom is not None:
            clearance = custom_clearance(custom) if choice.shown == "Clearance map" else None
            self._round_the_foot(custom.posed, custom.skin, custom.shoelast.side, clearance, target_mm)
        elif fitted is not None and fitted.comparison.posed is not None:
            clearance = fitted.clearance_mm if choice.shown == "Clearance map" else None
            self._round_the_foot(fitted.comparison.posed, fitted.skin, fitted.shoelast.side, clearance, target_mm)
        self._feet.show_or_hide(not self._handles)

    def _round_the_foot(
        self, foot: PosedFoot, skin: LastSkin, side: Side, clearance_mm: Floats | None, target_mm: float
    ) -> None:
        """The posed foot coloured by its room in the last, or, without clearance, the last see-through round it."""
        from footscan.workflow.lasts_colours import UNSEEN, clearance_colours

        xyz, faces = foot.shell.xyz, np.asarray(foot.shell.faces)
        if clearance_mm is not None:
            self._add("clearance", xyz, faces, clearance_colours(clearance_mm, target_mm), side)
            return
        seen = np.zeros(len(xyz), dtype=np.bool_)
        seen[faces[foot.foot.face_seen]] = True
        self._add("foot", xyz, faces, np.where(seen[:, None], _SKIN, UNSEEN).astype(np.uint8), side)
        self._add_clear(skin.xyz_shoelast, skin.faces, side)

    def _add(self, name: str, xyz: Floats, faces: Ints, rgb: Bytes, side: Side) -> None:
        import trimesh

        from footscan.shoelast.handed import mirrored_mesh

        drawn = mirrored_mesh(trimesh.Trimesh(xyz, faces, process=False), side)
        drawn.apply_scale(_M)
        glb = matte_glb(drawn, rgb)
        handle = self._scene.add_glb(f"/last/{name}", glb, position=_PLACE_M, cast_shadow=False, receive_shadow=False)
        self._handles.append(handle)

    def _add_clear(self, xyz: Floats, faces: Ints, side: Side) -> None:
        from footscan.shoelast.handed import mirrored
        from footscan.workflow.lasts_colours import UNCHANGED

        corner = faces[:, ::-1] if side == "left" else faces
        handle = self._scene.add_mesh_simple(
            "/last/last",
            (mirrored(xyz, side) * _M).astype(np.float32),
            corner.astype(np.uint32),
            color=UNCHANGED,
            opacity=_SEE_THROUGH,
            position=_PLACE_M,
            cast_shadow=False,
            receive_shadow=False,
        )
        self._handles.append(handle)
