"""The simulated picture against exact curves projected through `footscan.optics`, which draws nothing."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from footscan.coordinates import Floats, LaserName, uv_from_pixel
from footscan.geometry.rigid import inverse_rigid, transform_points, turn_z
from footscan.optics import Calibration
from footscan.optics.calibration import camera_from_world, optical_centre_world
from footscan.optics.camera import pixel_from_camera
from footscan.optics.sheet import world_from_light
from footscan.scanning.stripe import find_stripe
from footscan.sim.machine import TrueMachine
from footscan.sim.objects import build_plate, build_sphere
from footscan.sim.optics_loops import lens_numbers, project_points
from footscan.sim.picture import DEFAULT_PICTURE, Painter, split_sheet, without_noise

CLEAN = replace(without_noise(), skin_grey=250.0)
THETAS = (0.3, 2.0, 4.4)


def seen_in_frame(xyz_world: Floats, calibration: Calibration, theta_rad: float) -> Floats:
    xyz_camera = transform_points(camera_from_world(calibration, theta_rad), xyz_world)
    return uv_from_pixel(pixel_from_camera(xyz_camera, calibration.camera), calibration.camera.height_px)


def sheet_at(calibration: Calibration, laser: LaserName, theta_rad: float) -> Floats:
    return turn_z(theta_rad) @ world_from_light(calibration.laser(laser))


def distance_px(uv: Floats, curve_uv: Floats) -> Floats:
    return cKDTree(curve_uv).query(uv)[0]


def circle_in_sheet(centre: Floats, radius: float, world_from: Floats) -> Floats:
    middle = transform_points(inverse_rigid(world_from), centre[None])[0]
    angle = np.linspace(0.0, 2.0 * np.pi, 40_000)
    r = np.sqrt(radius**2 - middle[2] ** 2)
    ring = np.stack([middle[0] + r * np.cos(angle), middle[1] + r * np.sin(angle), 0.0 * angle], axis=1)
    return transform_points(world_from, ring)


@pytest.mark.parametrize("theta", THETAS)
@pytest.mark.parametrize("laser", ["right", "left"])
def test_stripe_on_a_sphere_lies_on_the_exact_projected_circle(machine: TrueMachine, theta: float, laser: LaserName):
    calibration, centre = machine.calibration, np.array([4.0, -3.0, 70.0])
    frame = Painter(calibration, build_sphere(45.0, centre), CLEAN).paint(theta, laser)
    uv = find_stripe(frame, 20).uv
    curve = seen_in_frame(circle_in_sheet(centre, 45.0, sheet_at(calibration, laser, theta)), calibration, theta)
    off = distance_px(uv, curve)
    on_ball = off[off < 2.0]

    assert len(on_ball) > 60
    assert np.sqrt(np.mean(on_ball**2)) < 0.05


def cut_of_plate(centre: Floats, normal: Floats, world_from: Floats, half: float) -> Floats:
    """The straight cut of a plate by the sheet, `half` to either side of the place nearest to the plate's middle."""
    along = np.cross(normal, world_from[:3, 2])
    two = np.stack([normal, world_from[:3, 2], along])
    foot = np.linalg.solve(two, [normal @ centre, world_from[:3, 2] @ world_from[:3, 3], along @ centre])
    return foot + np.linspace(-half, half, 60_000)[:, None] * along / np.linalg.norm(along)


@pytest.mark.parametrize("theta", [0.0, 0.35])
@pytest.mark.parametrize("laser", ["right", "left"])
def test_stripe_on_a_plane_lies_on_the_exact_projected_line(machine: TrueMachine, theta: float, laser: LaserName):
    calibration, centre = machine.calibration, np.array([0.0, 0.0, 90.0])
    normal = np.array([0.8, 0.1, 0.5]) / np.linalg.norm([0.8, 0.1, 0.5])
    frame = Painter(calibration, build_plate(centre, normal, 60.0), CLEAN).paint(theta, laser)
    uv = find_stripe(frame, 20).uv
    line = cut_of_plate(centre, normal, sheet_at(calibration, laser, theta), 50.0)
    off, nearest = cKDTree(seen_in_frame(line, calibration, theta)).query(uv)
    on_plate = off[(nearest > 0) & (nearest < len(line) - 1) & (off < 2.0)]

    assert len(on_plate) > 60
    assert np.sqrt(np.mean(on_plate**2)) < 0.05


def board_line(calibration: Calibration, laser: LaserName, theta: float, x_light: Floats) -> Floats:
    world_from = sheet_at(calibration, laser, theta)
    level = inverse_rigid(world_from)
    normal = level[:3, :3] @ calibration.floor.normal_array
    offset = calibration.floor.offset_mm + normal @ level[:3, 3]
    y = (offset - normal[0] * x_light) / normal[1]
    return transform_points(world_from, np.stack([x_light, y, 0.0 * y], axis=1))


def brightness(picture: Floats, uv: Floats) -> Floats:
    column, row = np.rint(uv).astype(int).T
    inside = (row >= 0) & (row < picture.shape[0]) & (column >= 0) & (column < picture.shape[1])
    return picture[row[inside], column[inside]]


def test_board_is_lit_but_for_the_shadow_of_the_ball(machine: TrueMachine):
    calibration, theta, radius, height = machine.calibration, 0.0, 20.0, 80.0
    ball = build_sphere(radius, np.array([28.3, 28.3, height]))  # its shadow falls beside what it hides
    picture = Painter(calibration, ball, CLEAN).paint_light(theta, "right").copy()
    laser_xy, centre = np.array([-560.0, CLEAN.laser_height_mm]), np.array([-40.0, height])
    reach = np.linalg.norm(centre - laser_xy)
    middle, half = np.arctan2(*(centre - laser_xy)[::-1]), np.arcsin(radius / reach)
    x_shadow = laser_xy[0] - laser_xy[1] / np.tan(np.array([middle - half, middle + half]))
    inside = np.linspace(x_shadow[0] + 4.0, x_shadow[1] - 4.0, 60)
    before = np.linspace(x_shadow[0] - 40.0, x_shadow[0] - 4.0, 60)
    dark = brightness(picture, seen_in_frame(board_line(calibration, "right", theta, inside), calibration, theta))
    lit = brightness(picture, seen_in_frame(board_line(calibration, "right", theta, before), calibration, theta))

    assert x_shadow[1] < 195.0
    assert len(dark) > 30
    assert len(lit) > 30
    assert dark.max() < 0.5
    assert lit.min() > 10.0


def test_light_behind_the_ball_is_hidden_from_the_camera(machine: TrueMachine):
    calibration, centre, radius = machine.calibration, np.array([120.0, 0.0, 60.0]), 30.0
    picture = Painter(calibration, build_sphere(radius, centre), replace(CLEAN, skin_grey=0.0)).paint_light(
        0.0, "right"
    )
    eye = optical_centre_world(calibration)
    line = board_line(calibration, "right", 0.0, np.linspace(-180.0, 180.0, 3000))
    ray = line - eye
    nearest = eye + np.clip((centre - eye) @ ray.T / np.sum(ray**2, axis=1), 0.0, 1.0)[:, None] * ray
    miss = np.linalg.norm(nearest - centre, axis=1)
    hidden = seen_in_frame(line[miss < radius - 4.0], calibration, 0.0)

    assert len(hidden) > 100
    assert brightness(picture, hidden).max() < 0.5


def test_unlit_frame_holds_no_laser_light(machine: TrueMachine):
    light = Painter(machine.calibration, build_sphere(40.0, np.array([0.0, 0.0, 60.0]))).paint_light(1.0, None)

    assert not light.any()


def test_same_seed_gives_the_same_frame_and_another_one_does_not(machine: TrueMachine):
    ball = build_sphere(40.0, np.array([0.0, 0.0, 60.0]), subdivisions=3)
    first = Painter(machine.calibration, ball, seed=3)
    again, other = Painter(machine.calibration, ball, seed=3), Painter(machine.calibration, ball, seed=4)
    frame = first.paint(1.0, "right", number=7)

    assert np.array_equal(frame, again.paint(1.0, "right", number=7))
    assert not np.array_equal(frame, other.paint(1.0, "right", number=7))
    assert not np.array_equal(frame, first.paint(1.0, "right", number=8))


def test_grey_values_below_the_black_level_never_occur(machine: TrueMachine):
    frame = Painter(machine.calibration, build_sphere(40.0, np.array([0.0, 0.0, 60.0]))).paint(1.0, "right")

    assert frame.max() > 100
    assert not np.isin(frame, np.arange(1, 16)).any()


def test_noise_has_the_variance_of_shot_and_read_noise(machine: TrueMachine):
    settings = replace(DEFAULT_PICTURE, black_level=0, ambient_board_grey=120.0)
    ball = build_sphere(5.0, np.array([0.0, 0.0, 30.0]), subdivisions=2)
    frame = Painter(machine.calibration, ball, settings).paint(0.0, None)
    board = frame[380:460, 200:380].astype(float)
    expected = settings.read_noise_grey**2 + 120.0 / settings.electrons_per_grey + 1.0 / 12.0

    assert abs(board.mean() - 120.0) < 0.1
    assert abs(board.var() / expected - 1.0) < 0.05


@pytest.mark.parametrize("layers", [1, 5, 7, 9])
def test_thin_sheets_add_up_to_the_gaussian_sheet(layers: int):
    places, peaks, thin = split_sheet(0.35, layers)
    d = np.linspace(-1.5, 1.5, 301)
    total = (peaks * np.exp(-((d[:, None] - places) ** 2) / (2.0 * thin**2))).sum(axis=1)

    assert np.max(np.abs(total - np.exp(-(d**2) / (2.0 * 0.35**2)))) < 0.03
    assert np.trapezoid(total, d) == pytest.approx(0.35 * np.sqrt(2.0 * np.pi), rel=1e-3)
    assert np.trapezoid(total * d**2, d) / np.trapezoid(total, d) == pytest.approx(0.35**2, rel=5e-3)


def test_loops_project_as_the_optics_do(machine: TrueMachine):
    random = np.random.default_rng(1)
    xyz_world = random.uniform([-150, -150, -5], [150, 150, 240], (2000, 3))
    calibration = machine.calibration
    image = np.empty((2000, 3))
    project_points(xyz_world, camera_from_world(calibration, 0.7), lens_numbers(calibration.camera), image)
    depth = transform_points(camera_from_world(calibration, 0.7), xyz_world)[:, 0] - calibration.camera.focal_length_mm

    assert np.max(np.abs(image[:, :2] - seen_in_frame(xyz_world, calibration, 0.7))) < 1e-7
    assert np.allclose(image[:, 2], 1.0 / depth, rtol=1e-12)


def test_two_lasers_at_once_are_the_sum_of_either(machine: TrueMachine):
    painter = Painter(machine.calibration, build_sphere(40.0, np.array([0.0, 0.0, 60.0]), subdivisions=3))
    right, left = painter.paint_light(0.4, "right").copy(), painter.paint_light(0.4, "left").copy()
    both = painter.paint_light(0.4, ("right", "left"))

    assert right.max() > 100.0
    assert np.allclose(both, right + left, rtol=1e-4, atol=1e-3)
    assert not painter.paint_light(0.4, ()).any()


def test_moved_vertices_give_the_frame_of_the_moved_surface(machine: TrueMachine):
    ball = build_sphere(40.0, np.array([0.0, 0.0, 60.0]), subdivisions=3)
    tilt = np.eye(4)
    tilt[:3, :3] = [[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]]
    tilt[:3, 3] = [10.0, -5.0, 20.0]
    moved = ball.moved(tilt)
    painter = Painter(machine.calibration, ball, seed=2)
    before = painter.paint(0.7, "left", 3)
    painter.set_vertices(moved.xyz_world)
    after = painter.paint(0.7, "left", 3)

    assert not np.array_equal(before, after)
    assert np.array_equal(after, Painter(machine.calibration, moved, seed=2).paint(0.7, "left", 3))
    with pytest.raises(ValueError, match="vertices"):
        painter.set_vertices(np.zeros((3, 3)))


def test_exposure_and_gain_brighten_alike_and_saturate_at_255(machine: TrueMachine):
    settings = replace(CLEAN, ambient_board_grey=20.0, skin_grey=80.0)
    painter = Painter(machine.calibration, build_sphere(40.0, np.array([0.0, 0.0, 60.0]), subdivisions=3), settings)
    usual = painter.paint(0.4, "right").astype(int)
    painter.set_exposure(2.0)
    longer = painter.paint(0.4, "right").astype(int)
    painter.set_exposure(1.0, gain=2.0)
    amplified = painter.paint(0.4, "right").astype(int)
    painter.set_exposure(20.0)

    assert np.abs(longer - 2 * usual).max() <= 1
    assert np.array_equal(longer, amplified)
    assert painter.paint(0.4, "right").max() == 255
    with pytest.raises(ValueError, match="positive"):
        painter.set_exposure(0.0)


def test_exposure_gathers_electrons_and_gain_amplifies_noise(machine: TrueMachine):
    settings = replace(DEFAULT_PICTURE, black_level=0, ambient_board_grey=50.0)
    painter = Painter(machine.calibration, build_sphere(5.0, np.array([0.0, 0.0, 30.0]), subdivisions=2), settings)
    painter.set_exposure(2.0)
    longer = painter.paint(0.0, None)[380:460, 200:380].astype(float).var()
    painter.set_exposure(1.0, gain=2.0)
    amplified = painter.paint(0.0, None)[380:460, 200:380].astype(float).var()

    assert longer == pytest.approx(1.2**2 + 100.0 / 60.0 + 1.0 / 12.0, rel=0.05)
    assert amplified == pytest.approx((2.0 * 1.2) ** 2 + 2.0 * 100.0 / 60.0 + 1.0 / 12.0, rel=0.05)


def test_a_darker_part_sends_back_less_light(machine: TrueMachine):
    ball = build_sphere(40.0, np.array([0.0, 0.0, 60.0]), subdivisions=3)
    full = Painter(machine.calibration, ball, replace(CLEAN, board_grey=0.0)).paint_light(0.4, "right").copy()
    half = Painter(machine.calibration, ball, replace(CLEAN, board_grey=0.0), tone=np.full(len(ball.faces), 0.5))

    assert full.max() > 100.0
    assert np.allclose(half.paint_light(0.4, "right"), 0.5 * full, rtol=1e-4, atol=1e-3)
