import numpy as np
import pytest

from footscan.errors import RecordingError
from footscan.optics.calibration import EncoderScale
from footscan.scanning.angles import frame_angles, refuse_silent_encoder
from footscan.scanning.recording import EncoderTrack

SCALE = EncoderScale(8000, 1000, 1)


def track(*samples):
    time_s, count = np.array(samples, dtype=float).T
    return EncoderTrack(time_s, count)


def test_the_angle_is_that_of_the_exposure_not_of_the_stamp():
    angles = frame_angles(np.array([0.030]), 0.010, track((0.0, 1000), (0.04, 1040)), SCALE)

    np.testing.assert_allclose(angles.theta_rad, 2 * np.pi * 20 / 8000)


def test_an_encoder_that_counts_down_turns_the_other_way():
    down = EncoderScale(8000, 1000, -1)
    angles = frame_angles(np.array([0.02]), 0.0, track((0.0, 1000), (0.04, 1040)), down)

    np.testing.assert_allclose(angles.theta_rad, -2 * np.pi * 20 / 8000)


@pytest.mark.parametrize(
    ("time_s", "known"),
    [
        (0.0, True),
        (0.02, True),
        (0.049, False),
        (0.5, False),
        (1.0, True),
        (1.5, True),
        (2.0, True),
        (2.1, False),
        (-0.1, False),
    ],
)
def test_a_frame_far_from_the_samples_is_unknown_but_not_at_a_standstill(time_s, known):
    encoder = track((0.0, 1000), (0.04, 1020), (1.0, 1100), (2.0, 1100))
    angles = frame_angles(np.array([time_s]), 0.0, encoder, SCALE)

    assert bool(angles.known[0]) is known
    assert np.isnan(angles.theta_rad[0]) == (not known)


def test_both_neighbours_must_be_near_where_the_head_moves():
    encoder = track((0.0, 1000), (0.09, 1100), (0.19, 1200))
    angles = frame_angles(np.array([0.045, 0.100, 0.15]), 0.0, encoder, SCALE)

    assert angles.known.tolist() == [True, False, False]


def test_a_jump_of_the_count_is_named_with_its_line():
    with pytest.raises(RecordingError, match="line 4: the count jumps from 1002 to 5000"):
        frame_angles(np.array([0.0]), 0.0, track((0.0, 1000), (0.004, 1002), (0.008, 5000)), SCALE)


def test_a_gap_in_time_may_hold_any_turn():
    angles = frame_angles(np.array([3.0]), 0.0, track((0.0, 1000), (3.0, 7000), (3.01, 7001)), SCALE)

    assert angles.known.all()


def test_a_silent_encoder_is_named():
    still = track((0.0, 1000), (1.0, 1000))
    with pytest.raises(RecordingError, match="encoder is silent: its count stays at 1000 over 5 frames"):
        refuse_silent_encoder(np.linspace(0.1, 0.9, 5), still, 0.0)
    refuse_silent_encoder(np.linspace(0.1, 0.9, 5), track((0.0, 1000), (1.0, 1100)), 0.0)


def test_a_jump_far_beyond_the_usual_speed_is_named_even_if_it_is_small():
    count = 1000 + np.cumsum(np.full(400, 3.0))
    count[200:] += 60.0
    jumping = EncoderTrack(np.arange(400) * 0.004, count)

    with pytest.raises(RecordingError, match="line 202: the count jumps"):
        frame_angles(np.array([0.5]), 0.0, jumping, SCALE)
