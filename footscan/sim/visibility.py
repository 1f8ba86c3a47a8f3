"""Which skin the machine can see at all: every face against both sheets, all the way round."""

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import LASER_NAMES, Bools, Bytes, Floats, Floats32, Ints, LaserName
from footscan.geometry.rigid import inverse_rigid, turn_z
from footscan.optics import Calibration
from footscan.optics.calibration import camera_from_world
from footscan.optics.sheet import world_from_light
from footscan.sim.cut import cut_mesh
from footscan.sim.depth import draw_mesh, is_seen
from footscan.sim.optics_loops import lens_numbers, project, project_points
from footscan.sim.picture import DEFAULT_PICTURE, PictureSettings
from footscan.sim.shadow import SLOPES, find_nearest, is_lit
from footscan.sim.surface import Surface

SHALLOWEST = 0.05
"""Cosine of the most slanting light or view that still counts."""


def count_sheets(
    machine: Calibration, surface: Surface, picture: PictureSettings = DEFAULT_PICTURE, angles: int = 720
) -> Bytes:
    """How many of the two sheets can light and show each face.

    Args:
        machine: The true machine.
        surface: In world millimetres.
        picture: Where the lasers stand.
        angles: Head angles tried; the sheet must meet every face at one of them.

    Returns:
        `(m,)` 0, 1 or 2 per face.
    """
    seen = np.zeros((2, len(surface.faces)), dtype=np.bool_)
    for theta in np.arange(angles) * (2.0 * np.pi / angles):
        nearest = _depth_picture(machine, surface, float(theta))
        for row, laser in enumerate(LASER_NAMES):
            _mark_sheet(machine, surface, picture, laser, float(theta), nearest, seen[row])
    return seen.sum(axis=0).astype(np.uint8)


def _depth_picture(machine: Calibration, surface: Surface, theta_rad: float) -> Floats32:
    camera = machine.camera
    image = np.empty((len(surface.xyz_world), 3))
    project_points(surface.xyz_world, camera_from_world(machine, theta_rad), lens_numbers(camera), image)
    nearest = np.empty((camera.height_px, camera.width_px), dtype=np.float32)
    no_shade = np.zeros(len(surface.faces), dtype=np.float32)
    draw_mesh(image, surface.faces, no_shade, nearest, np.empty_like(nearest))
    return nearest


def _mark_sheet(
    machine: Calibration,
    surface: Surface,
    picture: PictureSettings,
    laser: LaserName,
    theta_rad: float,
    nearest: Floats32,
    seen: Bools,
) -> None:
    world_from = turn_z(theta_rad) @ world_from_light(machine.laser(laser))
    light_from = inverse_rigid(world_from)
    xyz_light = surface.xyz_world @ light_from[:3, :3].T + light_from[:3, 3]
    cut = cut_mesh(xyz_light, surface.faces, np.zeros(1))
    camera_from = camera_from_world(machine, theta_rad) @ world_from
    eye = (inverse_rigid(camera_from) @ np.array([machine.camera.focal_length_mm, 0.0, 0.0, 1.0]))[:3]
    place = np.array([-picture.laser_distance_mm, picture.laser_height_mm - world_from[2, 3]])
    lit = np.empty(SLOPES)
    find_nearest(cut.pieces, 0, len(cut.pieces), place[0], place[1], lit)
    _mark_pieces(cut.pieces, cut.face, place, eye, camera_from, lens_numbers(machine.camera), lit, nearest, seen)


@compiled
def _mark_pieces(
    pieces: Floats,
    face: Ints,
    laser: Floats,
    eye: Floats,
    camera_from_light: Floats,
    lens: Floats,
    nearest_to_laser: Floats,
    nearest_to_camera: Floats32,
    seen: Bools,
) -> None:
    height, width = nearest_to_camera.shape
    for i in range(pieces.shape[0]):
        x, y = 0.5 * (pieces[i, 0] + pieces[i, 2]), 0.5 * (pieces[i, 1] + pieces[i, 3])
        nx, ny, nz = pieces[i, 4], pieces[i, 5], pieces[i, 6]
        light_x, light_y = laser[0] - x, laser[1] - y
        view_x, view_y = eye[0] - x, eye[1] - y
        light = (nx * light_x + ny * light_y) / np.hypot(light_x, light_y)
        view = (nx * view_x + ny * view_y + nz * eye[2]) / np.sqrt(view_x * view_x + view_y * view_y + eye[2] * eye[2])
        if light < SHALLOWEST or view < SHALLOWEST or not is_lit(x, y, laser[0], laser[1], nearest_to_laser):
            continue
        u, v, inverse = project(x, y, 0.0, camera_from_light, lens)
        inside = 0.0 <= u <= width - 1 and 0.0 <= v <= height - 1
        if inside and inverse > 0.0 and is_seen(u, v, inverse, nearest_to_camera):
            seen[face[i]] = True
