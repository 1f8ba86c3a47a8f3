"""The printed board in the picture against its projected corners and lines, which nothing draws."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from footscan.config import Board
from footscan.coordinates import Floats, Frame, Ints, uv_from_pixel
from footscan.errors import InputError
from footscan.geometry.rigid import transform_points
from footscan.optics import Calibration
from footscan.optics.calibration import camera_from_world
from footscan.optics.camera import pixel_from_camera
from footscan.sim.board import DEFAULT_BOARD, Placement, PrintedBoard, PrintFaults, pattern_of
from footscan.sim.machine import TrueMachine
from footscan.sim.picture import DEFAULT_PICTURE, Painter

NOISELESS = replace(DEFAULT_PICTURE, electrons_per_grey=0.0, read_noise_grey=0.0, black_level=0)
SIZE_MM = (210.0, 150.0)
POSES = [
    (Placement((15.0, 0.0, 92.0), 0.0, 0.2, 0.05), 0.0),
    (Placement((0.0, 10.0, 85.0), 0.1, 0.6, -0.1), -0.3),
    (Placement((0.0, 0.0, 75.0), -0.15, 0.9, 0.05), 0.25),
    (Placement((-20.0, 10.0, 92.0), 0.35, 0.3, 0.02), 0.0),
]


def board_at(placement: Placement, faults: PrintFaults | None = None) -> PrintedBoard:
    return PrintedBoard(DEFAULT_BOARD, placement.world_from_board(SIZE_MM), faults or PrintFaults())


def detector(board: Board) -> cv2.aruco.CharucoDetector:
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    size = (board.squares_x, board.squares_y)
    return cv2.aruco.CharucoDetector(cv2.aruco.CharucoBoard(size, board.square_mm, board.marker_mm, dictionary))


def found_corners(frame: Frame) -> tuple[Floats, Ints]:
    corners, ids, _, _ = detector(DEFAULT_BOARD).detectBoard(frame)
    finer = cv2.cornerSubPix(frame, corners.reshape(-1, 1, 2), (4, 4), (-1, -1), (3, 100, 1e-4))
    return finer.reshape(-1, 2).astype(np.float64), ids.ravel().astype(np.int64)


def true_corners(board: PrintedBoard, calibration: Calibration, theta_rad: float) -> Floats:
    xyz_camera = transform_points(camera_from_world(calibration, theta_rad), board.corners_world())
    return uv_from_pixel(pixel_from_camera(xyz_camera, calibration.camera), calibration.camera.height_px)


def corners_off(machine: TrueMachine, faults: PrintFaults | None, believed: PrintFaults | None = None) -> Floats:
    off: list[Floats] = []
    for placement, theta in POSES:
        frame = Painter.of_board(machine.calibration, board_at(placement, faults), NOISELESS).paint(theta, None)
        uv, ids = found_corners(frame)
        off.append(uv - true_corners(board_at(placement, believed or faults), machine.calibration, theta)[ids])
    return np.concatenate(off)


@pytest.mark.parametrize("faults", [PrintFaults(), PrintFaults(1.01, 0.99, 3.0)], ids=["flat", "scaled and bent"])
def test_corners_are_found_where_the_true_camera_projects_them(machine: TrueMachine, faults: PrintFaults):
    off = corners_off(machine, faults)

    assert len(off) > 70
    assert np.sqrt(np.mean(off**2)) <= 0.05  # of which OpenCV's own refinement has most
    assert np.abs(off.mean(axis=0)).max() <= 0.01


@pytest.mark.parametrize("faults", [PrintFaults(scale_x=1.005), PrintFaults(scale_y=1.005), PrintFaults(bow_mm=2.0)])
def test_a_fault_of_the_board_shows_in_its_picture(machine: TrueMachine, faults: PrintFaults):
    off = corners_off(machine, faults, believed=PrintFaults())

    assert np.sqrt(np.mean(off**2)) > 0.2


@pytest.fixture(scope="module")
def facing(machine: TrueMachine) -> tuple[Painter, PrintedBoard]:
    board = board_at(POSES[0][0])
    return Painter.of_board(machine.calibration, board, NOISELESS), board


def at_squares(picture: Floats, board: PrintedBoard, calibration: Calibration, column: float, row: float) -> float:
    place = np.array([[column * 30.0, row * 30.0, 0.0]])
    xyz_camera = transform_points(camera_from_world(calibration, 0.0) @ board.world_from_board, place)
    u, v = uv_from_pixel(pixel_from_camera(xyz_camera, calibration.camera), calibration.camera.height_px)[0]
    return float(picture[round(v), round(u)])


def test_paper_is_white_and_print_black(machine: TrueMachine, facing: tuple[Painter, PrintedBoard]):
    painter, board = facing
    frame = painter.paint(0.0, None)

    assert at_squares(frame, board, machine.calibration, 2.5, 2.5) == pytest.approx(board.paper.black_grey, abs=1.0)
    assert at_squares(frame, board, machine.calibration, 3.5, 5.15) == pytest.approx(board.paper.white_grey, abs=1.0)


def test_stripe_is_broken_where_the_print_is_black(machine: TrueMachine, facing: tuple[Painter, PrintedBoard]):
    painter, board = facing
    light = painter.paint_light(0.0, "right")
    sheet = machine.calibration.laser("right")
    line = np.linspace(-8.0, 158.0, 20_000)
    # where the sheet n.x = offset meets the plate, for each y of the board
    m, normal = board.world_from_board, np.array(sheet.normal)
    x = (sheet.offset_mm - normal @ m[:3, 3] - line * (normal @ m[:3, 1])) / (normal @ m[:3, 0])
    on_board = np.column_stack([x, line, np.zeros_like(x)])
    xyz_camera = transform_points(camera_from_world(machine.calibration, 0.0) @ m, on_board)
    uv = uv_from_pixel(pixel_from_camera(xyz_camera, machine.calibration.camera), 500)
    seen = np.isfinite(uv).all(axis=1) & (uv[:, 1] > 2)
    squares, _ = pattern_of(DEFAULT_BOARD)
    place = np.floor(on_board[:, :2] / 30.0).astype(int)
    inner = np.abs(on_board[:, :2] / 30.0 - place - 0.5).max(axis=1) < 0.4
    on_pattern = inner & (line > 0.0) & (line < 150.0) & (x > 0.0) & (x < 210.0)
    black = on_pattern & (squares[np.clip(place[:, 1], 0, 4), np.clip(place[:, 0], 0, 6)] < 0) & seen
    white = (line > 152.0) & seen
    row, column = np.rint(uv[:, 1]).clip(0, 499).astype(int), np.rint(uv[:, 0]).clip(0, 581).astype(int)
    value = light[row, column]

    assert black.sum() > 100
    assert white.sum() > 100
    assert np.median(value[black]) == pytest.approx(
        np.median(value[white]) * board.paper.black_laser / board.paper.white_laser, rel=0.15
    )


def test_back_of_the_board_has_no_print(machine: TrueMachine, facing: tuple[Painter, PrintedBoard]):
    painter, board = facing
    frame = painter.paint(np.pi, None)

    assert set(np.unique(np.rint(frame[:150, 200:380] / board.paper.back_grey))) == {1.0}


def test_unknown_and_small_dictionaries_and_impossible_faults_are_named():
    with pytest.raises(InputError, match="'DICT_NONSENSE' is unknown"):
        pattern_of(replace(DEFAULT_BOARD, dictionary="DICT_NONSENSE"))
    with pytest.raises(InputError, match="needs 60 markers, DICT_4X4_50 has 50"):
        pattern_of(replace(DEFAULT_BOARD, squares_x=12, squares_y=10))
    with pytest.raises(InputError, match=r"0\.9 to 1\.1"):
        PrintFaults(scale_x=2.0)
    with pytest.raises(InputError, match="at most 10 mm"):
        PrintFaults(bow_mm=30.0)
