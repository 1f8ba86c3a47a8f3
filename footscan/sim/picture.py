"""`Painter`: the frame a true machine takes of a surface on its footboard at a head angle.

The laser stands at (-distance, height) of its light system: 560 mm from the axis, the camera's g of Table I, and 375 mm
above the board. The paper does not give the height; this one makes shadows end on the board where those of recordings
made by an independent ray tracer of the same machine end. The light is a fan in the sheet, with no width at the
laser: half shadows are not drawn. Nor is the motion of the head during the exposure.
"""

from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Bytes, Floats, Floats32, Frame, LaserName
from footscan.geometry.rigid import inverse_rigid, turn_z
from footscan.optics import Calibration, Camera, LightPlane
from footscan.optics.calibration import camera_from_world
from footscan.optics.camera import ray_from_pixel
from footscan.optics.sheet import world_from_light
from footscan.sim import light
from footscan.sim.cut import Cut, cut_mesh
from footscan.sim.depth import draw_board, draw_mesh
from footscan.sim.exposure import expose, normal_quantiles
from footscan.sim.optics_loops import lens_numbers, project_points
from footscan.sim.shadow import SLOPES, find_nearest
from footscan.sim.surface import Surface


@dataclass(frozen=True)
class PictureSettings:
    """Light, surfaces and sensor.

    Attributes:
        laser_distance_mm: From the axis, along the sheet.
        laser_height_mm: Above the board.
        sheet_sigma_mm: Half width of the sheet (standard deviation) on a surface facing it.
        layers: Thin sheets the sheet is made of: 1, or at least 5.
        skin_grey: Grey value of laser light on skin that faces the laser at the axis, before the blur.
        board_grey: The same for the footboard.
        spread_share: Share of the light that comes back from inside the skin.
        spread_mm: How far (standard deviation).
        blur_px: Blur of the lens and of the pixels' own width (standard deviation).
        ambient_skin_grey: Ambient light on skin facing the lamps above; a third of it where turned away.
        ambient_board_grey: Ambient light on the board.
        board_radius_mm: Radius of the round footboard.
        speckle: Standard deviation of laser light relative to itself, per pixel.
        electrons_per_grey: For shot noise.
        read_noise_grey: Standard deviation.
        black_level: Smaller grey values are written as 0.
    """

    laser_distance_mm: float = 560.0
    laser_height_mm: float = 375.0
    sheet_sigma_mm: float = 0.35
    layers: int = 5
    skin_grey: float = 400.0
    board_grey: float = 175.0
    spread_share: float = 0.06
    spread_mm: float = 1.2
    blur_px: float = 0.7
    ambient_skin_grey: float = 17.0
    ambient_board_grey: float = 7.0
    board_radius_mm: float = 300.0
    speckle: float = 0.10
    electrons_per_grey: float = 60.0
    read_noise_grey: float = 1.2
    black_level: int = 16


DEFAULT_PICTURE = PictureSettings()


def without_noise(settings: PictureSettings = DEFAULT_PICTURE) -> PictureSettings:
    """The same light on a perfect sensor and without speckle, ambient light and spread: for checks of the geometry."""
    return replace(
        settings,
        spread_share=0.0,
        ambient_skin_grey=0.0,
        ambient_board_grey=0.0,
        speckle=0.0,
        electrons_per_grey=0.0,
        read_noise_grey=0.0,
        black_level=0,
    )


class Painter:
    """Takes frames of one surface by one machine, with buffers that are allocated once; one per thread."""

    def __init__(
        self, machine: Calibration, surface: Surface, settings: PictureSettings = DEFAULT_PICTURE, seed: int = 0
    ) -> None:
        self.machine = machine
        self.surface = surface
        self.settings = settings
        self.seed = seed
        camera = machine.camera
        shape = (camera.height_px, camera.width_px)
        self._lens = lens_numbers(camera)
        self._rays = _slopes_of_pixels(camera)
        self._shade = _ambient_shade(surface, settings)
        self._quantiles = normal_quantiles()
        self._image = np.empty((len(surface.xyz_world), 3))
        self._nearest_to_laser = np.empty(SLOPES)
        self._nearest_to_camera: Floats32 = np.empty(shape, dtype=np.float32)
        self._ambient: Floats32 = np.empty(shape, dtype=np.float32)
        self._light: Floats32 = np.empty(shape, dtype=np.float32)

    def paint(self, theta_rad: float, laser: LaserName | None, number: int = 0) -> Frame:
        """The frame `(height, width)` uint8 at a head angle; `number` selects this frame's noise."""
        self.paint_light(theta_rad, laser)
        frame: Bytes = np.empty(self._light.shape, dtype=np.uint8)
        settings = self.settings
        expose(
            self._ambient,
            self._light,
            settings.speckle,
            settings.electrons_per_grey,
            settings.read_noise_grey,
            settings.black_level,
            (self.seed * 1_000_003 + number) & 0x7FFFFFFFFFFFFFFF,
            self._quantiles,
            frame,
        )
        return frame

    def paint_light(self, theta_rad: float, laser: LaserName | None) -> Floats32:
        """Laser light `(height, width)` before noise and saturation; a view that the next call changes."""
        camera_from = camera_from_world(self.machine, theta_rad)
        project_points(self.surface.xyz_world, camera_from, self._lens, self._image)
        draw_mesh(self._image, self.surface.faces, self._shade, self._nearest_to_camera, self._ambient)
        self._draw_board(camera_from)
        self._light[:] = 0.0
        if laser is not None:
            self._draw_sheet(self.machine.laser(laser), theta_rad, camera_from)
        return self._light

    def _draw_board(self, camera_from: Floats) -> None:
        floor, settings = self.machine.floor, self.settings
        if settings.ambient_board_grey <= 0.0:
            return
        eye = inverse_rigid(camera_from) @ np.array([self.machine.camera.focal_length_mm, 0.0, 0.0, 1.0])
        normal = camera_from[:3, :3] @ floor.normal_array
        offset = floor.offset_mm - float(floor.normal_array @ eye[:3])
        centre = camera_from[:3, :3] @ (floor.offset_mm * floor.normal_array - eye[:3])
        board = np.array([*normal, offset, *centre, settings.board_radius_mm])
        draw_board(self._rays, board, settings.ambient_board_grey, self._nearest_to_camera, self._ambient)

    def _draw_sheet(self, sheet: LightPlane, theta_rad: float, camera_from: Floats) -> None:
        settings = self.settings
        world_from = turn_z(theta_rad) @ world_from_light(sheet)
        light_from = inverse_rigid(world_from)
        xyz_light = self.surface.xyz_world @ light_from[:3, :3].T + light_from[:3, 3]
        layers_mm, weights, sigma_mm = split_sheet(settings.sheet_sigma_mm, settings.layers)
        skin = cut_mesh(xyz_light, self.surface.faces, layers_mm)
        floor = _floor_in_light(self.machine, light_from)
        board = _cut_board(floor, light_from[:3, 3], layers_mm, settings.board_radius_mm)
        camera_from_sheet = camera_from @ world_from
        laser_y = settings.laser_height_mm - world_from[2, 3]
        for k, (z_light, weight) in enumerate(zip(layers_mm, weights, strict=True)):
            numbers = np.zeros(light.NUMBERS)
            numbers[light.LASER_X], numbers[light.LASER_Y] = -settings.laser_distance_mm, laser_y
            numbers[light.LAYER_SIGMA], numbers[light.BLUR_PX] = sigma_mm, settings.blur_px
            self._draw_layer(skin, board, k, float(z_light), float(weight), numbers, floor, camera_from_sheet)

    def _draw_layer(
        self,
        skin: Cut,
        board: Cut,
        layer: int,
        z_light: float,
        weight: float,
        numbers: Floats,
        floor: Floats,
        camera_from_sheet: Floats,
    ) -> None:
        settings = self.settings
        eye = (inverse_rigid(camera_from_sheet) @ np.array([self._lens[6], 0.0, 0.0, 1.0]))[:3]
        x, y = numbers[light.LASER_X], numbers[light.LASER_Y]
        find_nearest(skin.pieces, skin.start[layer], skin.start[layer + 1], x, y, self._nearest_to_laser)
        below = floor - np.array([0.0, 0.0, 0.0, 0.01])
        for cut, grey, spread, open_surface in (
            (skin, settings.skin_grey, settings.spread_share, not self.surface.closed),
            (board, settings.board_grey, 0.0, False),
        ):
            numbers[light.GREY], numbers[light.TWO_SIDED] = weight * grey, float(open_surface)
            numbers[light.SPREAD_SHARE], numbers[light.SPREAD_MM] = spread, settings.spread_mm
            light.draw_light(
                cut.pieces,
                cut.start[layer],
                cut.start[layer + 1],
                z_light,
                numbers,
                eye,
                below,
                camera_from_sheet,
                self._lens,
                self._nearest_to_laser,
                self._nearest_to_camera,
                self._light,
            )


def split_sheet(sigma_mm: float, layers: int) -> tuple[Floats, Floats, float]:
    """Make a Gaussian sheet of several thin Gaussian ones.

    Returns:
        Distances `(layers,)` of the thin sheets from the middle (mm), their peaks `(layers,)` relative to the whole
        sheet's, and their common sigma (mm). Light and variance of the sum are those of the whole sheet.
    """
    if layers == 1:
        return np.zeros(1), np.ones(1), sigma_mm
    step = 3.2 / (layers - 1)  # the outermost stand at 1.6 sigma
    place: Floats = step * (np.arange(layers, dtype=np.float64) - (layers - 1) / 2.0)
    share = np.exp(-(place**2) / (2.0 * 0.8**2))
    share /= share.sum()
    thin = float(np.sqrt(1.0 - share @ place**2))
    return sigma_mm * place, share / thin, sigma_mm * thin


def _slopes_of_pixels(camera: Camera) -> Floats32:
    """`(height, width, 2)`: y / x and z / x of each pixel's ray in C, rows of the upright frame."""
    u, row_f = np.meshgrid(np.arange(camera.width_px), camera.height_px - 1 - np.arange(camera.height_px))
    ray = ray_from_pixel(np.stack([u, row_f], axis=-1).astype(np.float64), camera)
    return (ray[..., 1:] / ray[..., :1]).astype(np.float32)


def _ambient_shade(surface: Surface, settings: PictureSettings) -> Floats32:
    """Ambient grey value of each face: lamps above and a little aside, and a third from everywhere."""
    lamp = np.array([0.25, 0.15, 0.96])
    towards = surface.normal_world @ (lamp / np.linalg.norm(lamp))
    towards = np.abs(towards) if not surface.closed else np.maximum(towards, 0.0)
    return (settings.ambient_skin_grey * (1.0 + 2.0 * towards) / 3.0).astype(np.float32)


def _floor_in_light(machine: Calibration, light_from_world: Floats) -> Floats:
    """The board's plane `(4,)` (normal, offset) in the light system."""
    normal = light_from_world[:3, :3] @ machine.floor.normal_array
    return np.array([*normal, machine.floor.offset_mm + float(normal @ light_from_world[:3, 3])])


def _cut_board(floor: Floats, axis_light: Floats, layers_mm: Floats, radius_mm: float) -> Cut:
    """The light curves on the round board: a straight line per layer, in pieces of at most 4 mm."""
    normal, offset = floor[:3], floor[3]
    pieces, start = [np.empty((0, 7))], [0]
    for z_light in layers_mm:
        inside = radius_mm**2 - (z_light - axis_light[2]) ** 2
        half = np.sqrt(max(inside, 0.0))
        x = np.linspace(axis_light[0] - half, axis_light[0] + half, max(int(np.ceil(half / 2.0)), 1) + 1)
        y = (offset - normal[0] * x - normal[2] * z_light) / normal[1]
        ends = np.column_stack([x[:-1], y[:-1], x[1:], y[1:]])
        pieces.append(np.column_stack([ends, np.broadcast_to(normal, (len(ends), 3))]))
        start.append(start[-1] + len(ends))
    joined = np.ascontiguousarray(np.concatenate(pieces))
    return Cut(joined, np.full(len(joined), -1), np.array(start, dtype=np.int64))
