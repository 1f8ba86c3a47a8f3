"""What the camera panel draws of a frame."""

import numpy as np
import pytest

from footscan.coordinates import Frame
from footscan.gui.live_picture import brightness_curve, draw_live, row_curve
from footscan.scanning.stripe import StripeFinder


@pytest.fixture
def frame() -> Frame:
    """A bright vertical line at column 100 on a grey of 10."""
    frame = np.full((120, 200), 10, np.uint8)
    for off, grey in ((-2, 40), (-1, 120), (0, 200), (1, 120), (2, 40)):
        frame[10:110, 100 + off] = grey
    return frame


def test_the_binary_picture_is_white_above_the_threshold_alone(frame: Frame) -> None:
    picture = draw_live(frame, "Binary", 100, StripeFinder(), None)

    assert np.array_equal(picture.rgb[:, :, 0] == 255, frame > 100)
    assert set(np.unique(picture.rgb)) == {0, 255}


def test_a_higher_threshold_leaves_less_white(frame: Frame) -> None:
    white = [int((draw_live(frame, "Binary", level, StripeFinder(), None).rgb > 0).sum()) for level in (30, 100, 150)]

    assert white[0] > white[1] > white[2] > 0


def test_stripe_and_overlay_draw_the_same_points_on_other_grounds(frame: Frame) -> None:
    stripe = draw_live(frame, "Stripe", 60, StripeFinder(), None)
    overlay = draw_live(frame, "Overlay", 60, StripeFinder(), None)
    red = (stripe.rgb == (255, 70, 40)).all(axis=2)

    assert stripe.points == overlay.points == int(red.sum()) > 90
    assert np.array_equal(red, (overlay.rgb == (255, 70, 40)).all(axis=2))
    assert set(np.nonzero(red)[1]) == {100}
    assert not stripe.rgb[~red].any()
    assert (overlay.rgb[:, 20] == 10).all()


def test_the_automatic_threshold_stands_beside_a_given_one(frame: Frame) -> None:
    picture = draw_live(frame, "Grey", 250, StripeFinder(), None)

    assert 10 < picture.automatic < 200
    assert picture.points == 0


def test_a_large_picture_is_shown_small_and_in_shape() -> None:
    picture = draw_live(np.zeros((1200, 1600), np.uint8), "Grey", 50, StripeFinder(), 600)

    assert picture.rgb.shape == (600, 800, 3)


def test_curves_count_every_pixel_and_follow_the_row(frame: Frame) -> None:
    grey, logarithm = brightness_curve(frame)
    column, level = row_curve(frame, 50)

    assert round(float((10.0**logarithm - 1.0).sum())) == frame.size
    assert len(grey) == len(logarithm) == 128
    assert np.array_equal(level, frame[50]) and len(column) == 200
