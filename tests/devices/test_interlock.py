from dataclasses import replace

import pytest

from footscan.devices.interlock import Interlock, InterlockLimits, Purpose
from footscan.devices.values import ALL_OFF, Inputs, Outputs
from footscan.errors import EmergencyStopError, InterlockError, OutputsLostError

LIMITS = InterlockLimits(watchdog_s=0.2, max_on_s=10.0)
MOTOR = Outputs(motor_run=True)
SWEEP = Outputs(motor_run=True, laser_right=True)


class HandClock:
    """A clock somebody turns by hand."""

    def __init__(self) -> None:
        self.time_s = 100.0

    def now_s(self) -> float:
        return self.time_s

    def wait(self, until_s, ready=lambda: False) -> bool:
        return ready()

    def notify(self) -> None: ...
    def join(self) -> None: ...
    def leave(self) -> None: ...


class ListIo:
    """A module that obeys and remembers."""

    def __init__(self) -> None:
        self.outputs = ALL_OFF
        self.inputs = Inputs(0.0, estop_ok=True, home=False)
        self.fed = 0
        self.obeys = True

    def set_outputs(self, outputs: Outputs) -> None:
        if not self.obeys:
            raise OutputsLostError("the module does not answer; check its cable.")
        self.outputs = outputs

    def read_outputs(self) -> Outputs:
        return self.outputs

    def read_inputs(self) -> Inputs:
        return self.inputs

    def arm_watchdog(self, timeout_s: float) -> None:
        self.armed_s = timeout_s

    def feed_watchdog(self) -> None:
        self.fed += 1

    def close(self) -> None:
        self.outputs = ALL_OFF


@pytest.fixture
def io() -> ListIo:
    return ListIo()


@pytest.fixture
def clock() -> HandClock:
    return HandClock()


@pytest.fixture
def interlock(io: ListIo, clock: HandClock) -> Interlock:
    return Interlock(io, clock, LIMITS)


def test_nothing_dangerous_without_arming(interlock, io):
    for outputs in (MOTOR, SWEEP, Outputs(laser_left=True)):
        with pytest.raises(InterlockError, match="armed"):
            interlock.request(outputs)
    interlock.request(Outputs(buzzer=True), at_rest=True)

    assert io.outputs == Outputs(buzzer=True)


def test_arming_asks_for_faces_and_sets_the_watchdog(interlock, io):
    with pytest.raises(InterlockError, match="face"):
        interlock.arm(False)
    interlock.arm(True)

    assert interlock.armed
    assert io.armed_s == LIMITS.watchdog_s


def test_the_direction_changes_only_at_rest(interlock, io):
    interlock.arm(True)
    interlock.request(MOTOR)
    with pytest.raises(InterlockError, match="direction"):
        interlock.request(replace(MOTOR, motor_reverse=True), at_rest=True)
    interlock.request(ALL_OFF)
    with pytest.raises(InterlockError, match="direction"):
        interlock.request(replace(MOTOR, motor_reverse=True), at_rest=False)
    interlock.request(replace(MOTOR, motor_reverse=True), at_rest=True)

    assert io.outputs.motor_reverse


def test_beams_at_rest_need_a_purpose(interlock):
    interlock.arm(True)
    with pytest.raises(InterlockError, match="rests"):
        interlock.request(Outputs(laser_right=True), at_rest=True)
    interlock.request(Outputs(laser_right=True), Purpose.MEASURING, at_rest=True)

    assert interlock.outputs.laser_right


@pytest.mark.parametrize(("purpose", "limit_s"), [(Purpose.MEASURING, 6.0), (Purpose.HELD, 1.0)])
def test_beams_at_rest_end_by_themselves(interlock, io, clock, purpose, limit_s):
    interlock.arm(True)
    interlock.request(Outputs(laser_right=True), purpose, at_rest=True)
    clock.time_s += limit_s - 0.1
    interlock.check(io.inputs, moving=False)
    clock.time_s += 0.2
    with pytest.raises(InterlockError, match="same place"):
        interlock.check(io.inputs, moving=False)


def test_a_beam_on_a_head_that_stopped_ends_after_half_a_second(interlock, io, clock):
    interlock.arm(True)
    interlock.request(SWEEP)
    clock.time_s += 3.0
    interlock.check(io.inputs, moving=True)
    clock.time_s += 0.4
    interlock.check(io.inputs, moving=False)
    clock.time_s += 0.2
    with pytest.raises(InterlockError, match="same place"):
        interlock.check(io.inputs, moving=False)


def test_nothing_dangerous_is_on_for_longer_than_the_limit(interlock, io, clock):
    interlock.arm(True)
    interlock.request(SWEEP)
    for _ in range(100):
        clock.time_s += 0.1
        interlock.check(io.inputs, moving=True)
    clock.time_s += 0.1
    with pytest.raises(InterlockError, match="without a break"):
        interlock.check(io.inputs, moving=True)


def test_the_watchdog_is_fed_only_while_armed(interlock, io):
    interlock.check(io.inputs, moving=False)
    unarmed = io.fed
    interlock.arm(True)
    interlock.check(io.inputs, moving=False)
    interlock.disarm()
    interlock.check(io.inputs, moving=False)

    assert (unarmed, io.fed) == (0, 1)


def test_an_open_emergency_stop_disarms_and_latches(interlock, io):
    interlock.arm(True)
    io.inputs = replace(io.inputs, estop_ok=False)
    with pytest.raises(EmergencyStopError, match="is open"):
        interlock.check(io.inputs, moving=False)
    io.inputs = replace(io.inputs, estop_ok=True)
    with pytest.raises(EmergencyStopError, match="was pressed"):
        interlock.arm(True)
    interlock.reset_emergency()
    interlock.arm(True)

    assert interlock.armed


@pytest.mark.parametrize("lost", ["module_reset", "watchdog_tripped"])
def test_a_module_that_lost_its_outputs_must_be_armed_anew(interlock, io, lost):
    interlock.arm(True)
    with pytest.raises(OutputsLostError):
        interlock.check(replace(io.inputs, **{lost: True}), moving=False)

    assert not interlock.armed


def test_all_off_works_from_any_state_and_disarms(interlock, io):
    interlock.arm(True)
    interlock.request(SWEEP)
    interlock.all_off()
    interlock.all_off()

    assert io.outputs == ALL_OFF
    assert not interlock.armed


def test_a_module_that_does_not_obey_disarms(interlock, io):
    interlock.arm(True)
    io.obeys = False
    with pytest.raises(OutputsLostError):
        interlock.request(MOTOR)

    assert not interlock.armed
    assert interlock.outputs == ALL_OFF


def test_who_listens_hears_of_each_change_before_and_after_it(io, clock):
    heard: list[Outputs | None] = []
    interlock = Interlock(io, clock, LIMITS, lambda time_s, outputs: heard.append(outputs))
    interlock.arm(True)
    interlock.request(SWEEP)
    interlock.request(SWEEP)
    interlock.disarm()

    assert heard == [ALL_OFF, None, SWEEP, None, ALL_OFF]
