"""A whole simulated machine behind real bytes, in real time."""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from footscan import app
from footscan.config.rig_file import Rig, load_rig
from footscan.devices.clock import MonotonicClock
from footscan.devices.drivers import open_camera, open_encoder, open_io
from footscan.devices.pictures import View
from footscan.devices.v4l2_camera import OpenCapture
from footscan.devices.values import ALL_OFF, Outputs
from footscan.errors import CameraLostError, DeviceError, EncoderLostError, OutputsLostError
from footscan.scanning.session.assembly import RigDevices
from footscan.sim.emulators.capture import Abilities
from footscan.sim.emulators.emulated_rig import FAULTS, EmulatedRig
from footscan.sim.emulators.server import EmulatorServer, RemoteCapture, ask
from footscan.sim.world import World
from footscan.workflow.designs import builtin_config
from tests.scanning.session.conftest import small_rig

RUN = Outputs(motor_run=True, speed_step=1)


@pytest.fixture(scope="module")
def rig() -> Rig:
    """The emulated rig with the small camera and the quick head of the session's tests."""
    small = small_rig()
    devices = load_rig(builtin_config("rig-emulated")).devices
    assert devices.world is not None
    world = devices.world.model_copy(update={"person": "statue"})
    return replace(small, devices=devices.model_copy(update={"world": world}))


@pytest.fixture
def world(rig: Rig) -> World:
    return app.build_world(rig, "left", MonotonicClock())


def view_of(rig: Rig) -> View:
    camera = rig.scanner.camera
    return View(camera.width_px, camera.height_px, rig.motion.frames_per_s)


@pytest.fixture
def emulated(world: World, rig: Rig, tmp_path: Path) -> Iterator[EmulatedRig]:
    opened = EmulatedRig(world, rig.devices, rig.motion.frames_per_s, links=tmp_path / "machine")
    yield opened
    opened.close()


@pytest.fixture
def drive(emulated: EmulatedRig, rig: Rig) -> Iterator[Callable[..., RigDevices]]:
    opened: list[RigDevices] = []

    def opening(capture: OpenCapture = emulated.open_capture, path: str = "emulated") -> RigDevices:
        devices = emulated.devices
        camera_model = devices.camera.model_copy(update={"path": path})
        camera = open_camera(camera_model, view_of(rig), capture)
        encoder, io = open_encoder(devices.encoder), open_io(devices.io)
        opened.append(RigDevices(camera, encoder, io, MonotonicClock()))
        camera.start()
        return opened[-1]

    yield opening
    for devices in opened:
        for device in (devices.camera, devices.encoder, devices.io):
            device.close()


def test_the_world_turns_as_the_drivers_say_and_they_see_it(drive, world: World, emulated: EmulatedRig):
    devices = drive()
    devices.io.arm_watchdog(2.0)
    before = devices.encoder.read()
    devices.io.set_outputs(RUN)
    for _ in range(8):
        time.sleep(0.1)
        devices.io.feed_watchdog()
    devices.io.set_outputs(ALL_OFF)
    time.sleep(0.3)
    samples = devices.encoder.take_samples()
    turned = samples.count[-1] - before.count
    true = world.counts_at(samples.time_s) - emulated.encoder._zero_count

    assert turned > 800
    assert np.abs(samples.count - true).max() <= 6  # a count is 0.7 ms at this speed
    assert world.off_since_s is not None


def test_the_camera_sees_the_beams_that_the_module_switches(drive):
    devices = drive()
    dark = devices.camera.read(1.0).frame.astype(int)
    devices.io.arm_watchdog(5.0)
    devices.io.set_outputs(Outputs(laser_right=True, laser_left=True))
    ends_s, brighter = time.monotonic() + 3.0, 0
    while time.monotonic() < ends_s and brighter < 100:
        brighter = int(np.sum(devices.camera.read(1.0).frame - dark > 20))

    assert brighter >= 100


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_an_error_of_its_device_or_a_flag_and_nothing_stays_on(
    fault, drive, emulated: EmulatedRig, world: World
):
    devices = drive()
    devices.io.arm_watchdog(1.0)  # a busy computer may be silent for a while before the fault
    devices.io.set_outputs(RUN)
    emulated.inject(fault)
    error = _first_error(devices)
    _wait_for(lambda: world.off_since_s is not None)

    assert (
        error == {"camera": CameraLostError, "encoder": EncoderLostError, "io": OutputsLostError}[fault.split("-")[0]]
    )
    assert world.off_since_s is not None


def _wait_for(holds: Callable[[], bool]) -> None:
    ends_s = time.monotonic() + 20.0
    while not holds() and time.monotonic() < ends_s:
        time.sleep(0.02)


def _first_error(devices: RigDevices) -> type[DeviceError] | None:
    """What a control loop meets first; afterwards nobody feeds the watchdog."""
    ends_s = time.monotonic() + 4.0
    while time.monotonic() < ends_s:
        try:
            devices.encoder.read()
            devices.camera.read(1.0)
            inputs = devices.io.read_inputs()
            devices.io.feed_watchdog()
        except DeviceError as err:
            return type(err)
        if inputs.module_reset or inputs.watchdog_tripped:
            return OutputsLostError
    return None


def test_mended_devices_work_again(drive, emulated: EmulatedRig):
    emulated.inject("encoder-unplugged")
    emulated.inject("camera-frozen")
    emulated.inject("io-silent")
    emulated.mend()
    devices = drive()

    assert devices.io.read_outputs() == ALL_OFF
    assert devices.encoder.read().count == 0
    assert devices.camera.read(1.0).frame.any()


def test_a_fault_of_a_device_that_is_not_emulated_is_refused(world: World, rig: Rig):
    other = rig.devices.model_copy(update={"camera": load_rig(builtin_config("sim")).devices.camera})
    emulated = EmulatedRig(world, other, 25.0)
    with pytest.raises(ValueError, match="camera-frozen needs an emulated camera"):
        emulated.inject("camera-frozen")
    emulated.close()

    assert emulated.camera is None


@pytest.fixture
def served(world: World, emulated: EmulatedRig, tmp_path: Path) -> Iterator[Path]:
    server = EmulatorServer(world, emulated, tmp_path / "machine")
    yield tmp_path / "machine"
    server.close()


def test_a_machine_in_another_process_is_driven_through_its_folder(drive, served: Path, rig: Rig):
    view = view_of(rig)
    remote = RemoteCapture(Abilities(((view.width_px, view.height_px),), (view.frames_per_s,)))
    devices = drive(remote, str(served / "camera"))
    frames = [devices.camera.read(2.0) for _ in range(4)]
    devices.io.arm_watchdog(0.3)
    devices.io.set_outputs(RUN)
    on = ask(served, "state")
    ask(served, "inject", "camera-frozen")
    with pytest.raises(CameraLostError):
        for _ in range(200):
            devices.camera.read(1.0)
    time.sleep(0.5)
    off = ask(served, "state")

    assert (served / "encoder").is_symlink()
    assert frames[0].frame.any()
    assert on["off_since_s"] is None
    assert off["off_since_s"] is not None  # nobody fed the module meanwhile
    with pytest.raises(ValueError, match="explode"):
        ask(served, "explode")
    assert "error" not in ask(served, "end")


def test_a_camera_that_nobody_serves_is_not_there(tmp_path: Path, rig: Rig):
    remote = RemoteCapture(Abilities(((64, 48),)))

    assert not remote(str(tmp_path / "camera")).isOpened()
