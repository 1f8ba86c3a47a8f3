import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footscan.scanning.stripe import StripeFinder, StripeSettings, automatic_threshold, find_stripe
from footscan.workflow.stripe_bench import THRESHOLD, draw_line, measure_step


def gaussian_line(shape, normal_deg, place, sigma=1.3, peak=180.0, background=6.0):
    v, u = np.mgrid[0 : shape[0], 0 : shape[1]].astype(float)
    angle = np.radians(normal_deg)
    across = (u - place[0]) * np.cos(angle) + (v - place[1]) * np.sin(angle)
    light = background + peak * np.exp(-(across**2) / (2 * sigma**2))
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 60.0, 90.0])
def test_a_noisy_line_is_found_to_four_hundredths_of_a_pixel_in_any_direction(angle_deg):
    line = draw_line(582, 500, angle_deg, seed=1)
    stripe = find_stripe(line.frame, THRESHOLD)
    error = line.error_across_px(stripe.uv)

    assert len(stripe) >= 500
    assert np.sqrt(np.mean(error**2)) < 0.04
    assert np.abs(error).max() < 0.5


@settings(max_examples=40, deadline=None)
@given(st.floats(0.0, 180.0), st.floats(-0.5, 0.5), st.floats(0.7, 3.0))
def test_a_clean_line_is_found_across_its_own_direction(angle_deg, shift, sigma):
    place = (100.0 + shift, 80.0 - shift)
    stripe = find_stripe(gaussian_line((160, 200), angle_deg, place, sigma), 40)
    angle = np.radians(angle_deg)
    error = (stripe.uv - place) @ np.array([np.cos(angle), np.sin(angle)])
    inner = ((stripe.uv > 6) & (stripe.uv < np.array([193, 153]))).all(axis=1)

    assert inner.sum() > 100
    assert np.abs(error[inner]).max() < 0.03


def test_a_saturated_line_is_found_as_well():
    stripe = find_stripe(gaussian_line((160, 200), 20.0, (100.2, 80.0), 1.4, peak=900.0), 40)
    angle = np.radians(20.0)
    error = (stripe.uv - (100.2, 80.0)) @ np.array([np.cos(angle), np.sin(angle)])
    inner = ((stripe.uv > 4) & (stripe.uv < np.array([195, 155]))).all(axis=1)

    assert np.sqrt(np.mean(error[inner] ** 2)) < 0.03


@pytest.mark.parametrize("radius", [10.0, 16.0, 30.0])
def test_a_bend_is_not_cut_short(radius):
    v, u = np.mgrid[0:100, 0:100].astype(float)
    away = np.hypot(u - 50.3, v - 49.8) - radius
    frame = np.rint(6.0 + 180.0 * np.exp(-(away**2) / (2 * 0.8**2))).astype(np.uint8)
    uv = find_stripe(frame, 40).uv
    short = radius - np.hypot(uv[:, 0] - 50.3, uv[:, 1] - 49.8)

    assert len(uv) > 3 * radius
    assert abs(short.mean()) < 0.45 / radius  # the facet alone would cut 0.72 / radius off


def test_a_step_leaves_no_ghost_and_costs_at_most_three_rows():
    step = measure_step(frames=12)

    assert step.ghosts == 0
    assert step.most_rows_dropped <= 3
    assert step.share_within_006 > 0.95
    assert step.rms_px < 0.035


def test_two_stripes_in_a_row_give_two():
    frame = np.maximum(gaussian_line((120, 200), 0.0, (60.3, 0.0)), gaussian_line((120, 200), 0.0, (90.7, 0.0)))
    stripe = find_stripe(frame, 40)
    rows = np.rint(stripe.uv[:, 1]).astype(int)

    assert (np.bincount(rows, minlength=120)[2:118] == 2).all()
    np.testing.assert_allclose(np.unique(np.round(stripe.uv[:, 0], 1)), [60.3, 90.7], atol=0.11)


@pytest.mark.parametrize("place", [1.0, 2.4, 197.3, 198.0])
def test_a_line_along_the_border_is_found(place):
    stripe = find_stripe(gaussian_line((120, 200), 0.0, (place, 0.0)), 40)

    assert len(stripe) > 100
    assert np.abs(stripe.uv[:, 0] - place).max() < 0.25


def test_a_line_reaches_the_first_and_last_row():
    stripe = find_stripe(gaussian_line((120, 200), 8.0, (100.0, 60.0)), 40)

    assert stripe.uv[:, 1].min() < 1.0
    assert stripe.uv[:, 1].max() > 118.0


@pytest.mark.parametrize("threshold", [None, 35])
def test_a_dark_frame_gives_nothing(rng, threshold):
    frame = rng.integers(10, 31, (500, 582), dtype=np.uint8)

    assert len(find_stripe(frame, threshold)) == 0


def test_dark_rows_give_nothing():
    frame = gaussian_line((200, 200), 0.0, (100.0, 0.0))
    frame[80:140] = 6
    stripe = find_stripe(frame, 40)

    assert not ((stripe.uv[:, 1] > 79.6) & (stripe.uv[:, 1] < 139.4)).any()
    assert len(stripe) > 100


def test_specks_and_single_columns_are_no_stripe(rng):
    frame = np.full((200, 200), 5, np.uint8)
    frame[rng.integers(5, 195, 40), rng.integers(5, 195, 40)] = 255
    frame[:, 100] = 250

    assert len(find_stripe(frame, 40)) == 0


def test_light_wider_than_a_stripe_is_no_stripe():
    assert len(find_stripe(gaussian_line((300, 300), 0.0, (150.0, 0.0), sigma=14.0), 40)) == 0


def test_the_weight_follows_the_light():
    bright = find_stripe(gaussian_line((120, 200), 0.0, (100.0, 0.0), peak=200.0), 40)
    dim = find_stripe(gaussian_line((120, 200), 0.0, (100.0, 0.0), peak=70.0), 40)

    assert 0.0 < dim.weight.mean() < 0.6 * bright.weight.mean() < 0.6
    assert ((bright.weight >= 0.0) & (bright.weight <= 1.0)).all()


def test_the_width_of_the_stripe_is_measured():
    for sigma in (1.0, 2.0, 3.0):
        stripe = find_stripe(gaussian_line((120, 200), 30.0, (100.0, 60.0), sigma=sigma), 30)
        assert np.median(stripe.sigma_px) == pytest.approx(sigma, rel=0.1)


def test_a_finder_reused_over_frames_of_other_sizes_gives_the_same_as_a_new_one():
    finder = StripeFinder()
    frames = [gaussian_line((120, 200), 30.0, (100.0, 60.0)), gaussian_line((60, 90), 80.0, (40.0, 30.0))]
    for frame in (frames[0], frames[1], frames[0]):
        np.testing.assert_array_equal(finder.find(frame, 40).uv, StripeFinder().find(frame, 40).uv)


def test_a_part_of_a_larger_array_is_read_as_a_frame():
    large = np.zeros((200, 400), np.uint8)
    large[:, 100:300] = gaussian_line((200, 200), 0.0, (100.4, 0.0))
    np.testing.assert_array_equal(find_stripe(large[:, 100:300], 40).uv, find_stripe(large[:, 100:300].copy(), 40).uv)


@pytest.mark.parametrize("frame", [np.zeros((5, 5, 3), np.uint8), np.zeros((5, 5), np.float32)])
def test_what_is_no_frame_is_refused(frame):
    with pytest.raises(ValueError, match="frame"):
        find_stripe(frame, 40)


def test_an_impossible_threshold_is_refused():
    with pytest.raises(ValueError, match="between 0 and 255"):
        find_stripe(np.zeros((50, 50), np.uint8), 300)


@pytest.mark.parametrize("shape", [(1, 1), (6, 40), (40, 6), (7, 7)])
def test_a_tiny_frame_is_no_trouble(shape):
    assert len(find_stripe(np.full(shape, 200, np.uint8), 40)) == 0


def test_the_automatic_threshold_lies_between_background_and_stripe():
    line = draw_line(582, 500, 10.0, seed=3)

    assert 30 <= automatic_threshold(line.frame) <= 120


@pytest.mark.parametrize("columns", [60, 400])
def test_a_picture_whose_dark_pixels_were_stored_as_nothing_has_the_threshold_above_its_background(columns, rng):
    frame = np.zeros((500, 582), np.uint8)
    patch = np.rint(rng.normal(17.0, 2.0, (60, columns)))
    frame[200:260, 20 : 20 + columns] = np.where(patch < 16.0, 0, patch)
    frame = np.maximum(frame, gaussian_line((500, 582), 0.0, (500.3, 0.0), sigma=1.5, background=0.0))

    assert 20 <= automatic_threshold(frame) <= 60


def test_stricter_rules_keep_fewer_points():
    line = draw_line(582, 500, 10.0, seed=3)
    strict = StripeFinder(StripeSettings(sigma_px=(0.4, 1.5))).find(line.frame, THRESHOLD)

    assert len(strict) < 0.2 * len(find_stripe(line.frame, THRESHOLD))


def test_a_frame_full_of_light_loses_no_row():
    frame = np.full((60, 400), 5, np.uint8)
    for column in range(6, 400, 12):
        frame = np.maximum(frame, gaussian_line((60, 400), 0.0, (column + 0.2, 0.0), sigma=1.0))
    wide = np.tile(frame, (30, 4))
    stripe = find_stripe(wide, 40)

    assert len(stripe) > 100 * 1700
    assert stripe.uv[:, 1].max() > wide.shape[0] - 2
