"""What every camera, encoder and digital I/O module must do, whether simulated, emulated, a file or real.

A test class inherits one of these and gives a `device` fixture. Where something has to happen to the device, it gives
the hook fixtures too; without them those tests are skipped. A device on another clock than the computer's gives
`clock`.
"""

from collections.abc import Callable

import numpy as np
import pytest

from footscan.devices.clock import Clock, MonotonicClock
from footscan.devices.protocols import Camera, DigitalIo, Encoder
from footscan.devices.values import ALL_OFF, CameraFrame, Outputs
from footscan.errors import CameraLostError, EncoderLostError, OutputsLostError

Hook = Callable[[], object]
NO_HOOK = "nobody can do that to this device from here"


def let_pass(clock: Clock, seconds: float) -> None:
    clock.wait(clock.now_s() + seconds)


class _OnItsClock:
    @pytest.fixture
    def clock(self) -> Clock:
        return MonotonicClock()


class CameraContract(_OnItsClock):
    """Hooks: `silence()` stops its frames."""

    @pytest.fixture
    def silence(self) -> Hook:
        pytest.skip(NO_HOOK)

    @staticmethod
    def some_frames(device: Camera, count: int) -> list[CameraFrame]:
        device.start()
        return [device.read(5.0) for _ in range(count)]

    def test_frames_are_grey_and_as_large_as_the_facts_say(self, device: Camera):
        facts = device.facts()
        frame = self.some_frames(device, 1)[0].frame

        assert frame.shape == (facts.height_px, facts.width_px)
        assert frame.dtype == np.uint8

    def test_stamps_and_numbers_rise(self, device: Camera):
        frames = self.some_frames(device, 8)

        assert np.all(np.diff([frame.time_s for frame in frames]) > 0)
        assert np.all(np.diff([frame.number for frame in frames]) > 0)

    def test_stamps_are_on_the_rigs_clock(self, device: Camera, clock: Clock):
        frames = self.some_frames(device, 3)

        assert abs(clock.now_s() - frames[-1].time_s) < 2.0

    def test_numbers_count_intervals_of_the_stated_rate(self, device: Camera):
        frames = self.some_frames(device, 12)
        intervals = np.diff([frame.time_s for frame in frames]) / np.diff([frame.number for frame in frames])

        assert np.median(intervals) * device.facts().frames_per_s == pytest.approx(1.0, abs=0.2)

    def test_the_exposure_is_shorter_than_a_frame(self, device: Camera):
        facts = device.facts()

        assert 0 < facts.exposure_s <= 1.0 / facts.frames_per_s

    def test_a_camera_that_sends_nothing_is_lost_in_words(self, device: Camera, silence: Hook):
        self.some_frames(device, 2)
        silence()

        with pytest.raises(CameraLostError, match=r"cable|start"):
            self.some_frames(device, 200)

    def test_nothing_comes_before_the_start(self, device: Camera):
        with pytest.raises(CameraLostError):
            device.read(0.05)

    def test_it_closes_twice_and_then_says_so(self, device: Camera):
        self.some_frames(device, 1)
        device.close()
        device.close()

        with pytest.raises(CameraLostError):
            device.read(0.05)


class EncoderContract(_OnItsClock):
    """Hooks: `turn(counts)` turns the head by about that much and returns by how much; `silence()` cuts its cable."""

    @pytest.fixture
    def turn(self) -> Callable[[int], int]:
        pytest.skip(NO_HOOK)

    @pytest.fixture
    def silence(self) -> Hook:
        pytest.skip(NO_HOOK)

    def test_it_counts_what_the_head_turns_both_ways(self, device: Encoder, clock: Clock, turn: Callable[[int], int]):
        let_pass(clock, 0.2)
        before = device.read().count
        forth = turn(700)
        let_pass(clock, 0.2)
        between = device.read().count
        back = turn(-300)
        let_pass(clock, 0.2)

        assert between == before + forth
        assert device.read().count == between + back

    def test_samples_come_once_in_order_without_a_gap(self, device: Encoder, clock: Clock):
        device.take_samples()
        parts = []
        for _ in range(5):
            let_pass(clock, 0.1)
            parts.append(device.take_samples())
        time_s = np.concatenate([part.time_s for part in parts])

        assert len(time_s) > 10
        assert np.all(np.diff(time_s) > 0)
        assert np.diff(time_s).max() < 0.06

    def test_samples_are_floats_and_integers_of_one_length(self, device: Encoder, clock: Clock):
        let_pass(clock, 0.2)
        samples = device.take_samples()

        assert samples.time_s.dtype == np.float64
        assert samples.count.dtype == np.int64
        assert samples.time_s.shape == samples.count.shape

    def test_stamps_are_on_the_rigs_clock(self, device: Encoder, clock: Clock):
        let_pass(clock, 0.2)

        assert abs(clock.now_s() - device.read().time_s) < 0.5

    def test_a_head_at_rest_keeps_its_count(self, device: Encoder, clock: Clock):
        let_pass(clock, 0.2)
        device.take_samples()
        let_pass(clock, 0.3)

        assert np.ptp(device.take_samples().count) == 0

    def test_a_silent_encoder_is_lost_in_words(self, device: Encoder, clock: Clock, silence: Hook):
        let_pass(clock, 0.1)
        silence()
        let_pass(clock, 0.5)

        with pytest.raises(EncoderLostError, match="cable"):
            device.read()

    def test_it_closes_twice(self, device: Encoder):
        device.close()
        device.close()


class DigitalIoContract(_OnItsClock):
    """Hooks: `seen()` is what really is on, `press(input, closed)`, `silence()`, `reset()` a brown-out."""

    @pytest.fixture
    def seen(self, device: DigitalIo) -> Callable[[], Outputs]:
        return device.read_outputs

    @pytest.fixture
    def press(self) -> Callable[[str, bool], object]:
        pytest.skip(NO_HOOK)

    @pytest.fixture
    def silence(self) -> Hook:
        pytest.skip(NO_HOOK)

    @pytest.fixture
    def reset(self) -> Hook:
        pytest.skip(NO_HOOK)

    @staticmethod
    def armed(device: DigitalIo, timeout_s: float = 2.0) -> DigitalIo:
        device.read_inputs()
        device.arm_watchdog(timeout_s)
        return device

    @pytest.mark.parametrize(
        "outputs",
        [
            Outputs(laser_right=True),
            Outputs(laser_left=True),
            Outputs(laser_right=True, laser_left=True, motor_run=True),
            Outputs(motor_run=True, motor_reverse=True),
            ALL_OFF,
        ],
    )
    def test_outputs_switch_and_read_back(self, device: DigitalIo, seen: Callable[[], Outputs], outputs: Outputs):
        self.armed(device).set_outputs(outputs)

        assert device.read_outputs() == outputs
        assert seen() == outputs

    def test_everything_is_off_at_the_start(self, device: DigitalIo, seen: Callable[[], Outputs]):
        assert device.read_outputs() == ALL_OFF
        assert seen() == ALL_OFF

    @pytest.mark.parametrize("name", ["estop_ok", "home", "button"])
    def test_inputs_say_what_is_closed(
        self, device: DigitalIo, clock: Clock, press: Callable[[str, bool], object], name: str
    ):
        for closed in (True, False, True):
            press(name, closed)
            let_pass(clock, 0.05)

            assert getattr(device.read_inputs(), name) is closed

    def test_a_module_that_is_not_fed_drops_its_outputs(
        self, device: DigitalIo, clock: Clock, seen: Callable[[], Outputs]
    ):
        self.armed(device, 0.3).set_outputs(Outputs(laser_right=True, motor_run=True))
        let_pass(clock, 1.0)

        assert not seen().dangerous
        assert device.read_inputs().watchdog_tripped
        with pytest.raises(OutputsLostError):
            device.set_outputs(Outputs(laser_right=True))
        assert not seen().dangerous

    def test_arming_again_clears_a_trip(self, device: DigitalIo, clock: Clock, seen: Callable[[], Outputs]):
        self.armed(device, 0.2).set_outputs(Outputs(laser_left=True))
        let_pass(clock, 0.8)
        device.read_inputs()
        self.armed(device).set_outputs(Outputs(laser_left=True))

        assert seen().laser_left
        assert not device.read_inputs().watchdog_tripped

    def test_a_fed_module_keeps_its_outputs(self, device: DigitalIo, clock: Clock, seen: Callable[[], Outputs]):
        self.armed(device, 0.6).set_outputs(Outputs(laser_right=True))
        for _ in range(15):
            let_pass(clock, 0.06)
            device.feed_watchdog()

        assert seen().laser_right

    def test_a_brown_out_is_told_once_and_nothing_is_on_after_it(
        self, device: DigitalIo, clock: Clock, reset: Hook, seen: Callable[[], Outputs]
    ):
        self.armed(device).set_outputs(Outputs(laser_right=True))
        device.read_inputs()
        reset()
        let_pass(clock, 0.05)

        assert seen() == ALL_OFF
        assert device.read_inputs().module_reset
        assert not device.read_inputs().module_reset

    def test_a_silent_module_is_lost_in_words(self, device: DigitalIo, silence: Hook):
        self.armed(device)
        silence()

        for call in (device.read_inputs, device.read_outputs, lambda: device.set_outputs(ALL_OFF)):
            with pytest.raises(OutputsLostError, match=r"cable|supply"):
                call()

    def test_closing_switches_everything_off(self, device: DigitalIo, seen: Callable[[], Outputs]):
        self.armed(device).set_outputs(Outputs(laser_right=True, motor_run=True))
        shown = device.read_outputs()
        seen_on = seen()
        device.close()
        device.close()

        assert shown.dangerous
        assert seen_on.dangerous
