import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footscan.errors import InputError
from footscan.optics import EncoderScale
from footscan.optics.calibration import theta_from_encoder
from footscan.sim.motion import SweepPlan, count_from_theta, plan_motion, sample_encoder

PLAN = SweepPlan()
ENCODER = EncoderScale(steps_per_rev=8000, zero_count=1234, direction=-1)


def test_each_sweep_turns_once_around_its_own_way():
    motion = plan_motion(("ccw", "cw"), PLAN, seed=1)
    there, back = (motion.theta_at(moments) for moments in motion.exposure_s)

    assert len(there) == len(back) == 240
    assert (np.diff(there) > 0.0).all()
    assert (np.diff(back) < 0.0).all()
    assert there[-1] - there[0] == pytest.approx(2.0 * np.pi * 239 / 240, abs=0.02)
    assert there[0] == pytest.approx(back[-1], abs=0.03)


def test_speed_ripples_by_about_what_was_asked():
    plan = SweepPlan(frames_per_sweep=2000, frames_per_s=100.0, ripple=0.02)
    motion = plan_motion(("ccw",), plan, seed=2)
    speed = np.diff(motion.theta_at(motion.exposure_s[0]))

    assert 0.01 < np.std(speed) / np.mean(speed) < 0.03


def test_same_seed_moves_the_same_way():
    first, again, other = (plan_motion(("ccw", "cw"), PLAN, seed).theta_rad for seed in (1, 1, 2))

    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_head_rests_before_between_and_after():
    motion = plan_motion(("ccw", "cw"), PLAN, seed=1)
    turn = motion.theta_at(np.array([12.45, 12.9]))

    assert motion.theta_at(np.array([-0.6]))[0] == motion.theta_at(np.array([-0.45]))[0]
    assert turn[0] == pytest.approx(turn[1], abs=1e-9)


def test_encoder_is_sampled_250_times_a_second_in_whole_steps():
    motion = plan_motion(("ccw",), PLAN, seed=1)
    time_s, count = sample_encoder(motion, ENCODER, PLAN)
    theta = theta_from_encoder(count.astype(float), ENCODER)

    assert np.allclose(np.diff(time_s), 0.004)
    assert count.dtype == np.int64
    assert np.max(np.abs(theta - motion.theta_at(time_s))) <= np.pi / 8000 * (1.0 + 1e-9)


@given(
    theta=st.floats(-10.0, 10.0),
    eccentricity=st.floats(0.0, 1e-3),
    phase=st.floats(0.0, 6.3),
    direction=st.sampled_from([1, -1]),
)
def test_angle_of_the_count_is_the_angle_to_half_a_step(theta, eccentricity, phase, direction):
    encoder = EncoderScale(8000, 77, direction, eccentricity, phase)
    count = count_from_theta(np.array([theta]), encoder).astype(float)

    assert abs(theta_from_encoder(count, encoder)[0] - theta) <= 1.002 * np.pi / 8000


@pytest.mark.parametrize("plan", [SweepPlan(frames_per_sweep=0), SweepPlan(frames_per_s=0.0), SweepPlan(ripple=0.5)])
def test_impossible_plan_is_refused(plan: SweepPlan):
    with pytest.raises(InputError, match="found"):
        plan_motion(("ccw",), plan, seed=0)
