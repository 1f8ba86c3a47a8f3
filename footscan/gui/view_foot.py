"""The 3-D view: the board with its marks, where the foot stands, the cloud as it grows, the measured foot in colours.

The scene is in metres; everything else here is in millimetres.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import viser

from footscan.coordinates import WORKING_RADIUS_MM, Floats, LaserName, Side
from footscan.gui import texts
from footscan.gui.matte import matte_glb
from footscan.gui.placement import LitFrame, lit_points
from footscan.gui.state import Shown
from footscan.gui.station import Station
from footscan.scanning.session.states import Snapshot, State

if TYPE_CHECKING:
    import trimesh

LOOK_AT = (0.0, 0.0, 0.07)
_M = 0.001
_CLOUD_EVERY_S = 0.5
_MOST_POINTS = 2500  # of one batch
_CLOUD_RGB: dict[LaserName, tuple[int, int, int]] = {"right": (220, 70, 40), "left": (40, 110, 220)}
_SKIN_RGB = (224, 160, 128)
_BRIDGED_RGB = (232, 192, 32)
_UNSEEN_RGB = (128, 144, 160)
_RESIDUAL_MM = (0.0, 0.2, 0.4)
_RESIDUAL_RGB = ((32, 96, 255), (48, 192, 96), (255, 48, 32))
_BESIDE_MM = 130.0
_BOARD_MM = 2.0
"""Live points below it are the footboard's."""
_HELD_SINCE_S = 0.4
"""A picture taken before the laser went on must not be taken for one of it."""
Colours = npt.NDArray[np.uint8]


class FootView:
    """What stands in the middle of the page."""

    def __init__(self, server: viser.ViserServer, station: Station) -> None:
        self._scene, self._station = server.scene, station
        self._shown_frames, self._batches = 0, 0
        self._next_s = 0.0
        self._held: tuple[LaserName, float] | None = None
        self._placed: set[LaserName] = set()
        self._feet: list[viser.GlbHandle | viser.LabelHandle] = []
        self._section: list[viser.LineSegmentsHandle] = []
        self._visible = True
        scene = server.scene
        scene.set_up_direction("+z")
        scene.configure_environment_map(None)  # with it and shadows a browser without a graphics card stalls for 15 s
        scene.configure_default_lights(True, cast_shadow=False)
        scene.add_light_ambient("/light", intensity=1.3)
        scene.add_grid("/board", 0.4, 0.4, cell_size=0.02, section_size=0.1, plane="xy", shadow_opacity=0.0)
        _draw_marks(scene)
        camera = server.initial_camera
        camera.position, camera.look_at, camera.near = texts.LOOK_FROM["Start"], LOOK_AT, 0.01

    def tick(self, snapshot: Snapshot) -> None:
        """Add the points that have come since the last time, and the line of a laser held on."""
        self._show_held(snapshot)
        live, now_s = self._station.session.live, time.monotonic()
        if live is None or now_s < self._next_s:
            return
        self._next_s = now_s + _CLOUD_EVERY_S
        if snapshot.state is State.SCANNING:
            self.clear_placement()
        if live.count().shown < self._shown_frames:
            self.clear_cloud()
        new = live.points_since(self._shown_frames)
        self._shown_frames += len(new)
        for laser, rgb in _CLOUD_RGB.items():
            xyz = [_above_board(part.xyz_world) for part in new if part.laser == laser]
            if any(len(part) for part in xyz):
                self._add_points(np.concatenate(xyz), rgb)

    def _show_held(self, snapshot: Snapshot) -> None:
        laser = snapshot.lasers[0] if snapshot.state is State.HOLDING and len(snapshot.lasers) == 1 else None
        if laser is None or snapshot.theta_deg is None:
            self._held = None
            return
        name: LaserName = "right" if laser == "right" else "left"
        if self._held is None or self._held[0] != name:
            self._held = (name, time.monotonic())
        newest = self._station.session.grabber.latest
        if newest is not None and time.monotonic() - self._held[1] > _HELD_SINCE_S:
            self.show_placement(LitFrame(name, float(np.deg2rad(snapshot.theta_deg)), newest.frame))

    def show_placement(self, lit: LitFrame) -> None:
        """Draw the line a laser draws on foot and board, in the place of its earlier one."""
        tables = self._station.session.setup.tables
        if tables is None:
            return
        xyz, name = lit_points(lit, tables).astype(np.float32) * np.float32(_M), f"/placement/{lit.laser}"
        self._placed.add(lit.laser)
        rgb = _CLOUD_RGB[lit.laser]
        self._scene.add_point_cloud(name, xyz, rgb, point_size=0.0016, precision="float32")

    def clear_placement(self) -> None:
        """The foot is scanned, or another one steps on."""
        for laser in self._placed:
            self._scene.remove_by_name(f"/placement/{laser}")
        self._placed.clear()

    def clear_cloud(self) -> None:
        """A new scan begins, or the foot is shown instead."""
        for number in range(self._batches):
            self._scene.remove_by_name(f"/cloud/{number}")
        self._shown_frames = self._batches = 0

    def hide_cloud(self) -> None:
        """Take the cloud away without showing the same points again."""
        shown = self._shown_frames
        self.clear_cloud()
        self._shown_frames = shown

    def _add_points(self, xyz_world: npt.NDArray[np.float32], rgb: tuple[int, int, int]) -> None:
        thinned = xyz_world[:: 1 + len(xyz_world) // _MOST_POINTS]
        self._scene.add_point_cloud(
            f"/cloud/{self._batches}", thinned * np.float32(_M), rgb, point_size=0.0008, precision="float32"
        )
        self._batches += 1

    def show_feet(self, feet: Mapping[Side, trimesh.Trimesh], shown: Shown) -> None:
        """Show one foot, or both side by side as they stand, with their names; none clears the place."""
        for handle in self._feet:
            handle.remove()
        self._feet = []
        for side, mesh in feet.items():
            y_mm = aside_mm(side) if len(feet) > 1 else 0.0
            self._feet.append(self._add_mesh(f"/foot/{side}", mesh, shown, y_mm))
            if len(feet) > 1:
                place_m = (-0.16, y_mm * _M, 0.0)
                self._feet.append(self._scene.add_label(f"/foot-label/{side}", texts.SIDES[side], position=place_m))
        self.show_or_hide(self._visible)

    def show_or_hide(self, visible: bool) -> None:
        """Hide the feet and the cut while a last is shown in their place."""
        self._visible = visible
        for handle in (*self._feet, *self._section):
            handle.visible = visible

    def _add_mesh(self, name: str, mesh: trimesh.Trimesh, shown: Shown, y_mm: float) -> viser.GlbHandle:
        import trimesh

        drawn = trimesh.Trimesh(mesh.vertices * _M, mesh.faces, process=False)
        glb = matte_glb(drawn, colours(mesh, shown))
        return self._scene.add_glb(name, glb, position=(0.0, y_mm * _M, 0.0), cast_shadow=False, receive_shadow=False)

    def show_section(self, polylines: Sequence[Floats]) -> None:
        """Draw a cut around the foot, `(k, 3)` world mm each; none removes it."""
        for handle in self._section:
            handle.remove()
        self._section = []
        pieces = [np.stack([line[:-1], line[1:]], axis=1) for line in polylines if len(line) > 1]
        if not pieces:
            return
        segments, rgb = np.concatenate(pieces) * _M, (200, 0, 120)
        drawn = self._scene.add_line_segments("/section", segments, rgb, thickness=4.0, thickness_units="screen")
        drawn.visible = self._visible
        self._section = [drawn]


def aside_mm(side: Side) -> float:
    """Where a foot stands beside the other one: x points to the toes, so the left foot has the larger y."""
    return _BESIDE_MM / 2 if side == "left" else -_BESIDE_MM / 2


def _above_board(xyz_world: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    return xyz_world[xyz_world[:, 2] > _BOARD_MM]


def colours(mesh: trimesh.Trimesh, shown: Shown) -> Colours:
    """`(n, 3)` per vertex: skin, where the skin comes from, or how far the points lie from it."""
    from footscan.foot.skin_origin import Origin

    rgb = np.tile(np.array(_SKIN_RGB, np.uint8), (len(mesh.vertices), 1))
    origin = np.asarray(mesh.vertex_attributes["origin"])
    if shown == "Seen / assumed":
        rgb[:] = _UNSEEN_RGB
        rgb[origin == Origin.SEEN] = _SKIN_RGB
        rgb[origin == Origin.BRIDGED] = _BRIDGED_RGB
    if shown == "Distance to points":
        residual = np.abs(np.asarray(mesh.vertex_attributes["residual_mm"], dtype=np.float64))
        known = np.isfinite(residual)
        rgb[~known] = _UNSEEN_RGB
        for channel in range(3):
            levels = [colour[channel] for colour in _RESIDUAL_RGB]
            rgb[known, channel] = np.interp(residual[known], _RESIDUAL_MM, levels).astype(np.uint8)
    return rgb


def _draw_marks(scene: viser.SceneApi) -> None:
    """The cross where the axis meets the board, an arrow where the toes point, and how far is measured."""
    cross = np.array([[[-15, 0, 0], [15, 0, 0]], [[0, -15, 0], [0, 15, 0]]], np.float32)
    arrow = np.array([[[150, 0, 0], [190, 0, 0]], [[190, 0, 0], [176, 8, 0]], [[190, 0, 0], [176, -8, 0]]], np.float32)
    turn = np.linspace(0.0, 2.0 * np.pi, 97)
    rim = WORKING_RADIUS_MM * np.stack([np.cos(turn), np.sin(turn), np.zeros(97)], axis=1).astype(np.float32)
    circle = np.stack([rim[:-1], rim[1:]], axis=1)[::2]
    marks = (("/axis-mark", cross, (200, 30, 30)), ("/toes", arrow, (30, 30, 30)), ("/measured", circle, (0, 96, 128)))
    for name, lines, rgb in marks:
        scene.add_line_segments(name, lines * np.float32(_M), rgb, thickness=3.0, thickness_units="screen")
    scene.add_label("/toes-label", texts.TOES, position=(0.205, 0.0, 0.0))
    scene.add_label("/measured-label", texts.MEASURED_RIM, position=(-0.165, -0.165, 0.0))
