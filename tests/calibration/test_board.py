"""The board: its corners to a hundredth of a pixel, why it is not found, and the page to print."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from footscan.calibration.board_sheet import draw_board, page_of
from footscan.calibration.charuco import BoardFinder, corners_mm, dictionary_number, half_size_mm, why_not_found
from footscan.calibration.saddle import refine_corners
from footscan.config import DEFAULT_BOARD
from footscan.coordinates import Floats, Frame
from footscan.errors import ConfigError, InputError

_FINE = 8


@pytest.fixture(scope="module")
def fine_board() -> Frame:
    marks = cv2.aruco.getPredefinedDictionary(dictionary_number(DEFAULT_BOARD))
    grid = cv2.aruco.CharucoBoard((7, 5), 30.0, 22.0, marks)
    return np.asarray(grid.generateImage((7 * 40 * _FINE, 5 * 40 * _FINE)))


def _picture(
    fine_board: Frame, shift_px: tuple[float, float] = (0.0, 0.0), turn_deg: float = 0.0
) -> tuple[Frame, Floats]:
    """A blurred 480 x 360 picture of the board at 40 px a square, and where its corners really are."""
    c, s = np.cos(np.deg2rad(turn_deg)), np.sin(np.deg2rad(turn_deg))
    turn = np.array([[c, -s], [s, c]]) * 40.0 / 30.0
    middle = np.array([240.0, 180.0]) + shift_px
    uv = corners_mm(DEFAULT_BOARD) @ turn.T + middle
    side = np.array([7.0, 5.0]) * 40.0 * _FINE
    fine = turn * 30.0 / 40.0
    # pixel centres of the fine picture are integers, its board begins at -0.5
    shift = _FINE * middle + 0.5 * (_FINE - 1) - fine @ (0.5 * side - 0.5)
    size = (480 * _FINE, 360 * _FINE)
    wide = cv2.warpAffine(fine_board, np.column_stack([fine, shift]), size, borderValue=255)
    blurred = cv2.GaussianBlur(wide, (0, 0), 0.8 * _FINE)
    grey = np.asarray(cv2.resize(blurred, (480, 360), interpolation=cv2.INTER_AREA)).astype(np.float64)
    return np.where(grey * 0.4 < 16, 0, grey * 0.4).astype(np.uint8), uv


@pytest.mark.parametrize(("shift_px", "turn_deg"), [((0.0, 0.0), 0.0), ((0.3, -0.41), 7.0), ((0.17, 0.5), -31.0)])
def test_corners_are_found_to_three_hundredths_of_a_pixel(
    fine_board: Frame, shift_px: tuple[float, float], turn_deg: float
):
    frame, uv = _picture(fine_board, shift_px, turn_deg)
    found = BoardFinder(DEFAULT_BOARD).find(frame)

    assert found is not None
    assert len(found.number) == 24
    off = found.uv - uv[found.number]
    assert np.sqrt(np.mean(off**2)) < 0.03
    assert np.abs(off.mean(axis=0)).max() < 0.02


def test_a_place_that_is_no_saddle_is_not_called_one(fine_board: Frame):
    frame, uv = _picture(fine_board)
    _, good = refine_corners(frame, np.array([uv[0], [40.0, 20.0], [3.0, 3.0]]))

    assert good.tolist() == [True, False, False]


def test_measured_lengths_replace_the_nominal_side():
    measured = replace(DEFAULT_BOARD, measured_x_mm=210.7, measured_y_mm=149.5)

    assert half_size_mm(measured).tolist() == [105.35, 74.75]
    assert np.ptp(corners_mm(measured), axis=0) == pytest.approx([210.7 * 5 / 7, 149.5 * 3 / 5])


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda frame: frame // 12, "too dark"),
        (lambda frame: np.ascontiguousarray(frame[:, ::-1]), "mirrored"),
        (
            lambda frame: cv2.copyMakeBorder(
                cv2.resize(frame, (144, 108), interpolation=cv2.INTER_AREA), 60, 60, 60, 60, 0, value=90
            ),
            "too small",
        ),
        (lambda frame: np.full_like(frame, 90), "edge-on, covered"),
    ],
)
def test_the_reason_why_no_board_is_found_is_said(fine_board: Frame, change, reason: str):
    frame, _ = _picture(fine_board)

    assert reason in why_not_found(DEFAULT_BOARD, [np.asarray(change(frame), dtype=np.uint8)])


def test_another_dictionary_is_recognised(fine_board: Frame):
    frame, _ = _picture(fine_board)

    assert "DICT_4X4_50" in why_not_found(replace(DEFAULT_BOARD, dictionary="DICT_6X6_50"), [frame])


def test_an_unknown_dictionary_is_refused():
    with pytest.raises(ConfigError, match="DICT_NONE"):
        BoardFinder(replace(DEFAULT_BOARD, dictionary="DICT_NONE"))


def test_the_page_is_a_pdf_of_exactly_a4_landscape():
    page = draw_board(DEFAULT_BOARD)
    box = page.split(b"/MediaBox")[1].split(b"]")[0].split(b"[")[1].split()

    assert page.startswith(b"%PDF")
    assert [float(x) for x in box] == pytest.approx([0, 0, 297 / 25.4 * 72, 210 / 25.4 * 72], abs=0.01)


def test_a_board_that_fits_on_no_page_is_refused():
    assert page_of(replace(DEFAULT_BOARD, square_mm=40.0))[0] == "A3"
    with pytest.raises(InputError, match="does not fit on A1"):
        page_of(replace(DEFAULT_BOARD, square_mm=150.0))
