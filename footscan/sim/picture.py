"""`Painter`: the frame a true machine takes of a surface on its footboard at a head angle.

The laser stands at (-distance, height) of its light system: 560 mm from the axis, the camera's g of Table I, and 375 mm
above the board. The paper does not give the height; this one makes shadows end on the board where those of recordings
made by an independent ray tracer of the same machine end. The light is a fan in the sheet, with no width at the
laser: half shadows are not drawn. Nor is the motion of the head during the exposure.
"""

from dataclasses import replace

import numpy as np

from footscan.coordinates import Bytes, Floats, Floats32, Frame, LaserName
from footscan.geometry.rigid import inverse_rigid, turn_z
from footscan.optics import Calibration, Camera, LightPlane
from footscan.optics.calibration import camera_from_world
from footscan.optics.camera import ray_from_pixel
from footscan.optics.sheet import world_from_light
from footscan.sim import light
from footscan.sim.board import PrintedBoard
from footscan.sim.board_picture import draw_print
from footscan.sim.board_print import Print, no_print
from footscan.sim.cut import Cut, cut_mesh
from footscan.sim.depth import draw_board, draw_mesh, shade_faces
from footscan.sim.exposure import expose, normal_quantiles
from footscan.sim.optics_loops import lens_numbers, project_points
from footscan.sim.picture_settings import DEFAULT_PICTURE, PictureSettings, without_noise
from footscan.sim.shadow import SLOPES, find_nearest
from footscan.sim.sheet_light import cut_footboard, floor_in_light, split_sheet
from footscan.sim.surface import Surface

__all__ = ["DEFAULT_PICTURE", "Lit", "Painter", "PictureSettings", "split_sheet", "without_noise"]

Lit = LaserName | tuple[LaserName, ...] | None
"""The lasers that are on: one, some, or none (None or an empty tuple)."""

_LAMP = np.array([0.25, 0.15, 0.96]) / np.sqrt(0.25**2 + 0.15**2 + 0.96**2)


class Painter:
    """Takes frames of one surface by one machine, with buffers that are allocated once; one per thread.

    Args:
        machine: The true machine.
        surface: What stands on its board, in world millimetres.
        settings: Light, surfaces and sensor.
        seed: Of speckle and noise.
        tone: `(m,)` brightness of each face relative to skin, under any light; all skin if not given.
    """

    def __init__(
        self,
        machine: Calibration,
        surface: Surface,
        settings: PictureSettings = DEFAULT_PICTURE,
        seed: int = 0,
        tone: Floats | None = None,
    ) -> None:
        self.machine = machine
        self.surface = surface
        self.settings = settings
        self.seed = seed
        camera = machine.camera
        shape = (camera.height_px, camera.width_px)
        self._lens = lens_numbers(camera)
        self._rays = _slopes_of_pixels(camera)
        self._tone = np.ones(len(surface.faces)) if tone is None else np.ascontiguousarray(tone, dtype=np.float64)
        self._quantiles = normal_quantiles()
        self._printed: PrintedBoard | None = None
        self._shade: Floats32 = np.empty(len(surface.faces), dtype=np.float32)
        self._image = np.empty((len(surface.xyz_world), 3))
        self._nearest_to_laser = np.empty(SLOPES)
        self._nearest_to_camera: Floats32 = np.empty(shape, dtype=np.float32)
        self._ambient: Floats32 = np.empty(shape, dtype=np.float32)
        self._light: Floats32 = np.empty(shape, dtype=np.float32)
        self.set_vertices(surface.xyz_world)

    @classmethod
    def of_board(
        cls, machine: Calibration, board: PrintedBoard, settings: PictureSettings = DEFAULT_PICTURE, seed: int = 0
    ) -> "Painter":
        """A painter of a printed board: its print, black and white, is drawn on the plate; paper spreads no light."""
        painter = cls(machine, board.surface, replace(settings, spread_share=0.0), seed)
        painter._printed = board
        return painter

    def set_vertices(self, xyz_world: Floats) -> None:
        """Move the surface: `(n, 3)` new places of its vertices, the faces stay.

        The array is used as it is until the next call. For another board pose make another painter.

        Raises:
            ValueError: Another number of vertices.
        """
        if xyz_world.shape != self._image.shape:
            raise ValueError(f"the surface has {len(self._image)} vertices, found an array of {xyz_world.shape}")
        self._drawn_at_rad: float | None = None
        self._xyz_world = np.ascontiguousarray(xyz_world, dtype=np.float64)
        ambient, closed = self.settings.ambient_skin_grey, self.surface.closed
        shade_faces(self._xyz_world, self.surface.faces, self._tone, ambient, _LAMP, closed, self._shade)

    def set_exposure(self, exposure: float, gain: float = 1.0) -> None:
        """Change the camera's exposure and gain for the frames to come; see `PictureSettings`.

        Raises:
            ValueError: Not positive.
        """
        self.settings = replace(self.settings, exposure=exposure, gain=gain)

    def paint(self, theta_rad: float, laser: Lit, number: int = 0) -> Frame:
        """The frame `(height, width)` uint8 at a head angle; `number` selects this frame's noise."""
        self.paint_light(theta_rad, laser)
        frame: Bytes = np.empty(self._light.shape, dtype=np.uint8)
        settings = self.settings
        expose(
            self._ambient,
            self._light,
            settings.exposure * settings.gain,
            settings.speckle,
            settings.electrons_per_grey / settings.gain,
            settings.read_noise_grey * settings.gain,
            settings.black_level,
            (self.seed * 1_000_003 + number) & 0x7FFFFFFFFFFFFFFF,
            self._quantiles,
            frame,
        )
        return frame

    def paint_light(self, theta_rad: float, laser: Lit) -> Floats32:
        """Laser light `(height, width)` before exposure, noise and saturation; a view that the next call changes."""
        camera_from = camera_from_world(self.machine, theta_rad)
        if theta_rad != self._drawn_at_rad:
            project_points(self._xyz_world, camera_from, self._lens, self._image)
            draw_mesh(self._image, self.surface.faces, self._shade, self._nearest_to_camera, self._ambient)
            self._draw_ambient(camera_from)
            self._drawn_at_rad = theta_rad
        self._light[:] = 0.0
        for name in (laser,) if isinstance(laser, str) else laser or ():
            self._draw_sheet(self.machine.laser(name), theta_rad, camera_from)
        return self._light

    def _draw_ambient(self, camera_from: Floats) -> None:
        eye_world = self._eye(inverse_rigid(camera_from))
        if self._printed is None:
            self._draw_footboard(camera_from, eye_world, self._nearest_to_camera)
            return
        self._ambient[:] = 0.0
        self._draw_footboard(camera_from, eye_world, np.zeros_like(self._nearest_to_camera))
        board_from_world = inverse_rigid(self._printed.world_from_board)
        eye = board_from_world[:3, :3] @ eye_world + board_from_world[:3, 3]
        printed = self._printed.for_loops(board_from_world @ inverse_rigid(camera_from))
        draw_print(self._rays, self._image, eye, printed, self.settings.blur_px, self._ambient)

    def _eye(self, from_camera: Floats) -> Floats:
        """The optical centre `(3,)` in another system."""
        return (from_camera @ np.array([self._lens[6], 0.0, 0.0, 1.0]))[:3]

    def _draw_footboard(self, camera_from: Floats, eye_world: Floats, nearest: Floats32) -> None:
        floor, settings = self.machine.floor, self.settings
        if settings.ambient_board_grey <= 0.0:
            return
        normal = camera_from[:3, :3] @ floor.normal_array
        offset = floor.offset_mm - float(floor.normal_array @ eye_world)
        centre = camera_from[:3, :3] @ (floor.offset_mm * floor.normal_array - eye_world)
        board = np.array([*normal, offset, *centre, settings.board_radius_mm])
        draw_board(self._rays, board, settings.ambient_board_grey, nearest, self._ambient)

    def _draw_sheet(self, sheet: LightPlane, theta_rad: float, camera_from: Floats) -> None:
        settings = self.settings
        world_from = turn_z(theta_rad) @ world_from_light(sheet)
        light_from = inverse_rigid(world_from)
        xyz_light = self._xyz_world @ light_from[:3, :3].T + light_from[:3, 3]
        layers_mm, weights, sigma_mm = split_sheet(settings.sheet_sigma_mm, settings.layers)
        skin = cut_mesh(xyz_light, self.surface.faces, layers_mm)
        floor = floor_in_light(self.machine, light_from)
        board = cut_footboard(floor, light_from[:3, 3], layers_mm, settings.board_radius_mm)
        camera_from_sheet = camera_from @ world_from
        numbers = np.zeros(light.NUMBERS)
        numbers[light.LASER_X], numbers[light.LASER_Y] = (
            -settings.laser_distance_mm,
            settings.laser_height_mm - world_from[2, 3],
        )
        numbers[light.LAYER_SIGMA], numbers[light.BLUR_PX] = sigma_mm, settings.blur_px
        printed = no_print()
        if self._printed is not None:
            printed = self._printed.for_loops(inverse_rigid(self._printed.world_from_board) @ world_from)
        tone = self._tone[skin.face]
        for k, (z_light, weight) in enumerate(zip(layers_mm, weights, strict=True)):
            x, y = numbers[light.LASER_X], numbers[light.LASER_Y]
            find_nearest(skin.pieces, skin.start[k], skin.start[k + 1], x, y, self._nearest_to_laser)
            numbers[light.GREY], numbers[light.TWO_SIDED] = weight * settings.skin_grey, float(not self.surface.closed)
            numbers[light.SPREAD_SHARE], numbers[light.SPREAD_MM] = settings.spread_share, settings.spread_mm
            self._draw_cut(skin, tone, k, float(z_light), numbers, floor, camera_from_sheet, printed)
            numbers[light.GREY], numbers[light.TWO_SIDED] = weight * settings.board_grey, 0.0
            numbers[light.SPREAD_SHARE] = 0.0
            bright = np.ones(len(board.pieces))
            self._draw_cut(board, bright, k, float(z_light), numbers, floor, camera_from_sheet, no_print())

    def _draw_cut(
        self,
        cut: Cut,
        tone: Floats,
        layer: int,
        z_light: float,
        numbers: Floats,
        floor: Floats,
        camera_from_sheet: Floats,
        printed: Print,
    ) -> None:
        light.draw_light(
            cut.pieces,
            tone,
            cut.start[layer],
            cut.start[layer + 1],
            z_light,
            numbers,
            self._eye(inverse_rigid(camera_from_sheet)),
            floor - np.array([0.0, 0.0, 0.0, 0.01]),
            camera_from_sheet,
            self._lens,
            self._nearest_to_laser,
            self._nearest_to_camera,
            printed,
            self._light,
        )


def _slopes_of_pixels(camera: Camera) -> Floats32:
    """`(height, width, 2)`: y / x and z / x of each pixel's ray in C, rows of the upright frame."""
    u, row_f = np.meshgrid(np.arange(camera.width_px), camera.height_px - 1 - np.arange(camera.height_px))
    ray = ray_from_pixel(np.stack([u, row_f], axis=-1).astype(np.float64), camera)
    return (ray[..., 1:] / ray[..., :1]).astype(np.float32)
