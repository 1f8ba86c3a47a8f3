import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest

from footscan.devices.adam_io import AdamIo
from footscan.devices.adam_line import checksum, framed
from footscan.devices.values import ALL_OFF, Outputs
from footscan.errors import InterlockError, OutputsLostError, WrongDeviceError
from tests.devices.contracts import DigitalIoContract

BEAM = Outputs(laser_right=True)


class _EmulatedIo(DigitalIoContract):
    @pytest.fixture
    def device(self, io) -> Iterator[AdamIo]:
        module = AdamIo(io.model)
        yield module
        module.close()

    @pytest.fixture
    def seen(self, io) -> Callable[[], Outputs]:
        return lambda: io.panel.outputs

    @pytest.fixture
    def press(self, io):
        return io.press

    @pytest.fixture
    def reset(self, io):
        return lambda: io.device.reset(time.monotonic())

    @pytest.fixture
    def silence(self, io):
        def mute() -> None:
            io.device.mute = True

        return mute


class TestAdam4055(_EmulatedIo):
    @pytest.fixture
    def io(self, plug_io):
        return plug_io(dialect="adam4055")


class TestAdam4150WithChecksumAt9600(_EmulatedIo):
    @pytest.fixture
    def io(self, plug_io):
        return plug_io(dialect="adam4150", checksum=True, baud=9600, address=0x2F)


class TestI7050WithChecksum(_EmulatedIo):
    @pytest.fixture
    def io(self, plug_io):
        return plug_io(dialect="i7050", checksum=True)


class TestI7060At9600(_EmulatedIo):
    @pytest.fixture
    def io(self, plug_io):
        return plug_io(dialect="i7060", baud=9600)

    @pytest.fixture
    def silence(self, io):
        return io.line.unplug


@pytest.mark.parametrize(
    ("command", "whole"),
    [("#010003", b"#01000347\r"), ("$016", b"$016BB\r"), (">", b">3E\r"), ("!030000", b"!03000044\r")],
)
def test_checksums_are_the_manuals(command, whole):
    assert framed(command, with_checksum=True) == whole
    assert checksum(whole[:-3]) == whole[-3:-1]


@pytest.mark.parametrize("dialect", ["adam4055", "i7050"])
def test_outputs_drop_by_themselves_when_the_cable_is_pulled(plug_io, dialect):
    io = plug_io(dialect=dialect)
    module = AdamIo(io.model)
    module.arm_watchdog(0.2)
    module.set_outputs(BEAM)
    io.line.unplug()
    began_s = time.monotonic()
    time.sleep(0.5)

    assert not io.panel.outputs.dangerous
    assert io.panel.history[-1].time_s - began_s < 0.25
    module.close()


@pytest.mark.parametrize("obeys_tripped", [True, False])
def test_a_tripped_adam_is_armed_again_whichever_way_its_firmware_takes_it(plug_io, obeys_tripped):
    io = plug_io(obeys_tripped=obeys_tripped)
    module = AdamIo(io.model)
    module.arm_watchdog(0.2)
    module.set_outputs(BEAM)
    time.sleep(0.5)
    module.arm_watchdog(1.0)
    module.set_outputs(BEAM)

    assert io.panel.outputs.laser_right
    module.close()


def test_a_latched_trip_survives_power_and_is_cleared_by_arming(plug_io):
    io = plug_io(dialect="i7060")
    module = AdamIo(io.model)
    module.arm_watchdog(0.2)
    time.sleep(0.5)
    io.device.reset(time.monotonic())

    assert module.read_inputs().watchdog_tripped
    with pytest.raises(OutputsLostError, match="arm"):
        module.set_outputs(BEAM)
    module.arm_watchdog(1.0)
    module.set_outputs(BEAM)
    assert io.panel.outputs.laser_right
    module.close()


def test_a_new_program_finds_a_tripped_module_and_takes_it_over(plug_io):
    io = plug_io(dialect="i7050")
    io.device.hear(b"~013102\r", time.monotonic())
    time.sleep(0.4)
    module = AdamIo(io.model)

    assert module.read_outputs() == ALL_OFF
    module.close()


def test_a_trip_that_cannot_be_cleared_leaves_the_machine_unarmed(plug_io, monkeypatch):
    module = AdamIo(plug_io().model)
    monkeypatch.setattr(module._watchdog, "tripped", lambda: True)

    with pytest.raises(OutputsLostError, match=r"still says .* switch the module off and on"):
        module.arm_watchdog(1.0)
    module.close()


def test_a_restart_after_arming_keeps_the_beams_off(plug_io):
    io = plug_io()
    module = AdamIo(io.model)
    module.arm_watchdog(1.0)
    module.read_inputs()
    io.device.reset(time.monotonic())

    with pytest.raises(OutputsLostError, match="restarted"):
        module.set_outputs(BEAM)
    assert not any(change.outputs.dangerous for change in io.panel.history)
    module.close()


def test_a_restart_is_noticed_before_the_first_beam_although_the_lamp_was_on(plug_io):
    io = plug_io(outputs={"laser_left": 0, "laser_right": 1, "motor_run": 2, "motor_reverse": 3, "lamp": 4})
    module = AdamIo(io.model)
    module.arm_watchdog(1.0)
    module.set_outputs(Outputs(lamp=True))
    io.device.reset(time.monotonic())

    with pytest.raises(OutputsLostError, match="restarted"):
        module.set_outputs(replace(BEAM, lamp=True))
    assert not any(change.outputs.dangerous for change in io.panel.history)
    module.close()


def test_a_command_spoiled_once_is_repeated_and_an_unknown_one_is_said(plug_io):
    io = plug_io()
    module = AdamIo(io.model)
    hear, spoil = io.device.hear, [True]
    io.device.hear = lambda data, time_s: hear(b"$01Q\r" if spoil and spoil.pop() else data, time_s)
    inputs = module.read_inputs()
    io.device.hear = lambda data, time_s: hear(b"$01Q\r", time_s)

    assert inputs.estop_ok
    with pytest.raises(OutputsLostError, match=r"does not know '\$016'; give the dialect"):
        module.read_inputs()
    io.device.hear = hear
    module.close()


def test_safe_and_power_on_values_are_all_off_before_anything_may_be_on(plug_io):
    io = plug_io(dialect="i7060")
    io.device._safe_bits = io.device._power_on_bits = 0x0F
    module = AdamIo(io.model)
    module.arm_watchdog(1.0)

    assert (io.device._safe_bits, io.device._power_on_bits) == (0, 0)
    module.close()


def test_an_output_that_the_module_switches_by_itself_is_an_error_and_is_switched_off(plug_io):
    io = plug_io()
    module = AdamIo(io.model)
    module.arm_watchdog(1.0)
    io.device._switch(0b10, time.monotonic())

    with pytest.raises(OutputsLostError, match="laser_right other than asked for"):
        module.read_inputs()
    module.read_inputs()
    assert io.panel.outputs == ALL_OFF
    module.close()


def test_an_unconfirmed_off_is_said_again_before_anything_else(plug_io, monkeypatch):
    io = plug_io()
    module = AdamIo(io.model)
    module.arm_watchdog(5.0)
    module.set_outputs(BEAM)
    with monkeypatch.context() as deaf:
        deaf.setattr(io.device, "_switch_asked", lambda bits, time_s: ">")
        with pytest.raises(OutputsLostError, match="laser_right"):
            module.set_outputs(ALL_OFF)
    module.read_inputs()

    assert io.panel.outputs == ALL_OFF
    module.close()


def test_another_address_says_what_to_check(plug_io):
    io = plug_io(address=2)

    with pytest.raises(OutputsLostError, match=r"address 05 .*does not answer .* check its supply"):
        AdamIo(io.model.model_copy(update={"address": 5}))


def test_another_module_is_named(plug_io):
    io = plug_io(dialect="i7060")

    with pytest.raises(WrongDeviceError, match="calls itself '7060', the rig file says adam4055"):
        AdamIo(io.model.model_copy(update={"dialect": "adam4055"}))


def test_another_baud_rate_or_checksum_says_so(plug_io):
    io = plug_io(baud=9600, checksum=True)

    for wrong in ({"baud": 115200}, {"checksum": False}):
        with pytest.raises(OutputsLostError, match="baud rate"):
            AdamIo(io.model.model_copy(update=wrong))


def test_one_lost_answer_is_asked_for_again(plug_io):
    io = plug_io()
    module = AdamIo(io.model)
    hear, lost = io.device.hear, [True]
    io.device.hear = lambda data, time_s: [] if lost and lost.pop() else hear(data, time_s)

    module.set_outputs(Outputs(motor_reverse=True))
    assert io.panel.outputs.motor_reverse
    module.close()


def test_a_late_answer_is_not_taken_for_the_next_one(plug_io):
    io = plug_io()
    module = AdamIo(io.model)
    io.press("estop_ok", False)
    module.read_inputs()
    io.line._line._say([(time.monotonic(), b"!0001")])
    io.line._line._say([(time.monotonic(), b"00\r")])
    time.sleep(0.1)

    assert not module.read_inputs().estop_ok
    module.close()


def test_a_speed_that_is_not_wired_is_refused(plug_io):
    module = AdamIo(plug_io().model)

    with pytest.raises(InterlockError, match="speed step 1"):
        module.set_outputs(Outputs(speed_step=1))
    module.close()


def test_lamp_and_buzzer_without_a_wire_change_nothing(plug_io):
    io = plug_io(dialect="i7060")
    module = AdamIo(io.model)
    module.set_outputs(Outputs(lamp=True, buzzer=True))

    assert io.panel.history == []
    module.close()


def test_everything_can_be_wired_at_once(plug_io):
    outputs = {"laser_left": 7, "laser_right": 0, "motor_run": 6, "motor_reverse": 5}
    io = plug_io(outputs=outputs | {"speed": [3, 1], "lamp": 2, "buzzer": 4, "inverted": ["lamp", "speed"]})
    module = AdamIo(io.model)
    module.arm_watchdog(1.0)
    for step in range(4):
        wanted = replace(BEAM, speed_step=step, lamp=step % 2 == 0, buzzer=step > 1)
        module.set_outputs(wanted)

        assert io.panel.outputs == wanted
    module.close()


def test_feeding_costs_nothing_while_other_words_are_said(plug_io):
    io = plug_io()
    module = AdamIo(io.model)
    module.arm_watchdog(4.0)
    said: list[bytes] = []
    hear = io.device.hear
    io.device.hear = lambda data, time_s: said.append(data) or hear(data, time_s)
    for _ in range(20):
        module.feed_watchdog()

    assert said == []
    module.close()
