import numpy as np
import pytest

from footscan.sim.drive import STEP_S, HeadDrive


@pytest.mark.parametrize("share", [0.25, 0.5, 1.0])
def test_a_turning_head_does_not_wait_for_the_next_step(share: float) -> None:
    head = HeadDrive(0.0, 3.0, 0.02, seed=1, start_s=10.0)
    head.turn_until(11.0, 0.6)
    before_s = head.now_s
    ahead = head.theta_at(np.array([before_s + share * STEP_S]))[0]
    head.turn_until(before_s + STEP_S, 0.6)

    assert ahead == pytest.approx(head.theta_at(np.array([before_s + share * STEP_S]))[0], abs=1e-6)


def test_a_head_at_rest_stays_where_it_is() -> None:
    head = HeadDrive(0.3, 3.0, 0.02, seed=1, start_s=10.0)

    assert head.theta_at(np.array([10.0, 10.0 + STEP_S]))[1] == 0.3
