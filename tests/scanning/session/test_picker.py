"""Of all frames the one nearest to each requested angle, and none for the run-up and the run-out."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from footscan.scanning.session.picker import AnglePicker, RequestedAngles

SWEEP_RAD = (float(np.deg2rad(-5.0)), float(np.deg2rad(365.0)))


def picked_rad(seen_rad: "np.ndarray", step_rad: float) -> list[float]:
    picker: AnglePicker[float] = AnglePicker(RequestedAngles(step_rad, SWEEP_RAD))
    picked = [theta for seen in seen_rad.tolist() for theta in picker.offer(seen, seen)]
    picked += picker.rest()

    assert len(picked) + picker.passed_over == len(seen_rad)
    return picked


@given(st.integers(0, 2**31), st.floats(2.0, 40.0), st.booleans())
def test_every_requested_angle_has_the_nearest_frame_whatever_the_run_up(seed: int, step_deg: float, ccw: bool) -> None:
    rng, step_rad = np.random.default_rng(seed), float(np.deg2rad(step_deg))
    seen_rad = np.deg2rad(np.cumsum(rng.uniform(0.2, 3.0, 400)) - 30.0)
    seen_rad = seen_rad[seen_rad < np.deg2rad(390.0)]
    picked = picked_rad(seen_rad if ccw else seen_rad[::-1], step_rad)
    wanted = np.round(seen_rad / step_rad)
    off_rad = np.abs(seen_rad - wanted * step_rad)
    inside = np.arange(np.ceil(SWEEP_RAD[0] / step_rad), np.floor(SWEEP_RAD[1] / step_rad) + 1)
    nearest = [seen_rad[wanted == k][off_rad[wanted == k].argmin()] for k in inside if (wanted == k).any()]

    assert sorted(picked) == nearest


def test_frames_of_the_run_up_belong_to_no_requested_angle() -> None:
    step_rad = float(np.deg2rad(15.0))
    picked = picked_rad(np.deg2rad([-8.01, -7.6, -1.2, 13.3, 353.0, 361.0, 368.0, 371.9]), step_rad)

    assert np.allclose(np.rad2deg(picked), [-1.2, 13.3, 361.0])
