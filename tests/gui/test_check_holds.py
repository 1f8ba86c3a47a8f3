"""A check holds as long as the machine stays as it was: after a stop or a fault nothing invites to start."""

from dataclasses import replace

import pytest

from footscan.gui.tab_scan import check_spoiled
from footscan.scanning.session.states import Snapshot, State

CHECKED = Snapshot(State.PARKED, armed=True)


@pytest.mark.parametrize("state", [State.FAULT, State.STOPPED, State.CLOSED])
def test_a_machine_that_was_stopped_is_checked_again(state: State) -> None:
    assert check_spoiled(replace(CHECKED, state=state))


def test_an_open_emergency_stop_spoils_a_check_and_a_laser_held_for_a_look_does_not() -> None:
    assert check_spoiled(replace(CHECKED, estop_ok=False))
    assert not check_spoiled(CHECKED)
    assert not check_spoiled(replace(CHECKED, state=State.HOLDING, lasers=("right",)))
