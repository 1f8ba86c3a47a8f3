"""The simulated devices keep the contracts that real and emulated ones keep; on simulated time."""

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from footscan import app
from footscan.devices.clock import Clock
from footscan.devices.values import Outputs
from footscan.sim.clock import VirtualClock
from footscan.sim.devices import SimCamera, SimDigitalIo, SimEncoder
from footscan.sim.world import World
from tests.devices.contracts import CameraContract, DigitalIoContract, EncoderContract
from tests.scanning.session.conftest import small_rig


class _InAWorld:
    @pytest.fixture
    def clock(self) -> Iterator[Clock]:
        clock = VirtualClock()
        clock.join()
        yield clock
        clock.leave()

    @pytest.fixture
    def world(self, clock: Clock) -> World:
        return app.build_world(small_rig(), "left", clock)


class TestSimCamera(_InAWorld, CameraContract):
    @pytest.fixture
    def device(self, world: World) -> SimCamera:
        return SimCamera(world, 25.0, 0.004)

    @pytest.fixture
    def silence(self, world: World) -> Callable[[], object]:
        return lambda: world.inject("camera-frozen")

    def test_a_slow_reader_finds_the_missed_frames_gone(self, device: SimCamera, clock: Clock):
        device.start()
        first = device.read(1.0)
        clock.wait(clock.now_s() + 1.0)
        second = device.read(1.0)

        assert 15 < second.number - first.number < 25

    def test_the_stamp_is_late_by_the_machines_latency(self, device: SimCamera, world: World):
        device.start()
        numbers = [device.read(1.0) for _ in range(3)]
        latency_s = world.machine.calibration.latency_s
        started_s = world.start_s + 0.5 / 25.0

        assert latency_s > 0
        for frame in numbers:
            assert frame.time_s == pytest.approx(started_s + frame.number / 25.0 + latency_s, abs=1e-9)

    def test_before_time_runs_everything_is_used_once(self, world: World, clock: Clock):
        moved: list[float] = []
        world.standing.xyz_world_at = moved.append  # type: ignore[method-assign,assignment,return-value]
        SimCamera(world, 25.0, 0.004).warm_up()

        assert moved == [0.0]  # what moves a person is compiled at first use, and that takes seconds


class TestSimEncoder(_InAWorld, EncoderContract):
    @pytest.fixture
    def device(self, world: World) -> SimEncoder:
        return SimEncoder(world, 500.0)

    @pytest.fixture
    def silence(self, world: World) -> Callable[[], object]:
        return lambda: world.inject("encoder-silent")

    @pytest.fixture
    def turn(self, world: World, clock: Clock, device: SimEncoder) -> Callable[[int], int]:
        def turn(counts: int) -> int:
            before = device.read().count
            world.arm_watchdog(60.0)
            world.set_outputs(Outputs(motor_run=True, motor_reverse=counts < 0))
            while abs(device.read().count - before) < abs(counts):
                clock.wait(clock.now_s() + 0.01)
            world.set_outputs(Outputs())
            clock.wait(clock.now_s() + 1.0)
            true = world.theta_at(np.array([clock.now_s()]))
            return int(world.counts_at(np.array([clock.now_s()]))[0]) - before if np.isfinite(true).all() else 0

        return turn


class TestSimDigitalIo(_InAWorld, DigitalIoContract):
    @pytest.fixture
    def device(self, world: World) -> SimDigitalIo:
        return SimDigitalIo(world)

    @pytest.fixture
    def seen(self, world: World) -> Callable[[], Outputs]:
        return world.outputs

    @pytest.fixture
    def silence(self, world: World) -> Callable[[], object]:
        return lambda: world.inject("io-silent")

    @pytest.fixture
    def reset(self, world: World) -> Callable[[], object]:
        return lambda: world.inject("io-reset")

    @pytest.fixture
    def press(self, world: World) -> Callable[[str, bool], object]:
        def press(name: str, closed: bool) -> None:
            match name:
                case "button":
                    world.press_button(closed)
                case "estop_ok":
                    world.mend("estop") if closed else world.inject("estop")
                case _:
                    pytest.skip("the home switch is moved by the head alone")

        return press

    def test_an_open_emergency_stop_darkens_the_lasers_whatever_the_module_says(
        self, device: SimDigitalIo, world: World, clock: Clock
    ):
        self.armed(device).set_outputs(Outputs(laser_right=True, motor_run=True))
        lit = world.lasers_at(clock.now_s())
        world.inject("estop")
        clock.wait(clock.now_s() + 0.01)

        assert lit == ("right",)
        assert device.read_outputs().laser_right
        assert world.lasers_at(clock.now_s()) == ()
        assert world.off_since_s is not None
