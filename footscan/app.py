"""The only module that chooses real, emulated or simulated devices, by what a rig file says.

What only one kind of rig needs (emulators, drivers, the drill) is imported where it is chosen: the page waits for this
module.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from footscan.config import load_calibration, save_calibration
from footscan.config.device_models import (
    CameraModels,
    DevicesModel,
    EncoderModels,
    IoModels,
    SimulatedCamera,
    SimulatedEncoder,
    SimulatedIo,
    V4l2CameraModel,
    WorldModel,
)
from footscan.config.rig_file import Rig
from footscan.coordinates import Side
from footscan.devices.clock import Clock, MonotonicClock
from footscan.devices.pictures import View
from footscan.devices.protocols import Camera, DigitalIo, Encoder
from footscan.errors import ConfigError
from footscan.optics.calibration import Calibration
from footscan.optics.tables import build_tables
from footscan.scanning.session.assembly import RigDevices, SessionSetup, drive_of
from footscan.scanning.session.control import Session
from footscan.sim.calibration_run import stand_board
from footscan.sim.clock import VirtualClock
from footscan.sim.devices import SimCamera, SimDigitalIo, SimEncoder
from footscan.sim.machine import TrueMachine, ideal_machine, workshop_machine
from footscan.sim.module_twin import MirroredModule
from footscan.sim.objects import build_object
from footscan.sim.obstacles import build_obstacle
from footscan.sim.person import CALM, RESTLESS, STATUE, PersonSettings
from footscan.sim.standing import BoardStanding, Standing
from footscan.sim.world import World, WorldSettings
from footscan.workflow.opened_rig import OpenedRig

if TYPE_CHECKING:
    from footscan.devices.diagnosis import Finding
    from footscan.devices.v4l2_camera import OpenCapture
    from footscan.sim.emulators.emulated_rig import EmulatedRig
    from footscan.workflow.drill import Drill
    from footscan.workflow.served_rig import ServedRig

    ChooseCapture = Callable[[], OpenCapture]

_PERSONS: dict[str, PersonSettings] = {"statue": STATUE, "calm": CALM, "restless": RESTLESS}
_HOME_PLAY_RAD = np.deg2rad(0.3)
"""How far from its place the home switch of a simulated machine may sit."""


def open_rig(rig: Rig, side: Side = "left") -> OpenedRig:
    """Open all devices of a rig; with a simulated world in it, a foot of that side stands on the board.

    Raises:
        ConfigError: A simulated device without a world.
        DeviceError: A device is missing, is another one, or is in trouble; those already open are given back.
    """
    model = rig.devices.world
    if rig.devices.simulated and model is None:
        raise ConfigError(f"{rig.path}: simulated devices need a table [devices.world] that says what they look at.")
    clock = _clock(model)
    if model is None:
        with ExitStack() as opening:
            return OpenedRig(
                rig, _open_devices(rig, rig.devices, clock, None, lambda: capture_opener(rig), opening), None, None
            )
    world = build_world(rig, side, clock)
    with ExitStack() as opening:
        emulated = _emulated(rig, world) if rig.devices.emulated else None
        if emulated is not None:
            opening.callback(emulated.close)
        models = rig.devices if emulated is None else emulated.devices

        def opener() -> "OpenCapture":
            return capture_opener(rig) if emulated is None or emulated.camera is None else emulated.open_capture

        devices = _open_devices(rig, models, clock, world, opener, opening)
        give_back = (lambda: None) if emulated is None else emulated.close
        return OpenedRig(
            rig,
            devices,
            world,
            lambda who: world.put(_standing(model, world.machine, who)),
            lambda setup: world.put(_calibration_board(world.machine, setup, model.seed or 0)),
            emulated,
            give_back,
        )


def _clock(model: WorldModel | None) -> Clock:
    if model is None or model.time == "real":
        return MonotonicClock()
    return VirtualClock(pace=model.pace if model.time == "paced" else None)


def emulators(rig: Rig) -> "EmulatedRig":
    """The emulators of a rig alone, switched on: whoever looks at them opens their ports.

    Raises:
        ConfigError: The rig has no world they could live in.
    """
    return _emulated(rig, build_world(rig, "left", MonotonicClock()))


def _emulated(rig: Rig, world: World) -> "EmulatedRig":
    from footscan.sim.emulators.emulated_rig import EmulatedRig

    return EmulatedRig(world, rig.devices, rig.motion.frames_per_s)


def examine_devices(rig: Rig) -> "Iterator[Finding]":
    """Every device of a rig that nothing else has open, in words; lasers and motor stay off."""
    from footscan.workflow.doctor import examine_drivers, examine_open_devices

    if rig.devices.emulated:
        with closing(emulators(rig)) as emulated:
            yield from examine_drivers(emulated.devices, rig, camera_view(rig), emulated.open_capture)
    elif not rig.devices.simulated:
        yield from examine_drivers(rig.devices, rig, camera_view(rig), capture_opener(rig))
    else:
        opened = open_rig(rig)
        with closing(opened.devices.camera), closing(opened.devices.encoder), closing(opened.devices.io):
            yield from examine_open_devices(opened.devices, rig.motion.frames_per_s)


def build_drill(rig: Rig, seed: int, folder: Path) -> "Drill":
    """A drill of a simulated or emulated machine in a folder of its own.

    Raises:
        ConfigError: A real machine; nobody breaks that on purpose.
    """
    from footscan.workflow.drill import Drill

    if rig.devices.world is None:
        raise ConfigError(f"{rig.path} is a real machine; the drill breaks simulated and emulated ones only.")
    if not rig.devices.emulated:
        world = rig.devices.world.model_copy(update={"time": "fast"})
        rig = replace(rig, devices=rig.devices.model_copy(update={"world": world}))
    calibration = true_machine(rig).calibration
    setup = SessionSetup(rig.scanner, rig.motion, calibration, build_tables(calibration))
    return Drill(rig, open_rig, serve_emulators, setup, seed, folder)


def serve_emulators(rig: Rig, folder: Path) -> "AbstractContextManager[ServedRig]":
    """The emulators of a rig behind fixed links in a folder, for another program.

    Raises:
        ConfigError: Nothing in the rig is emulated, or something in it is simulated.
        StorageError: The folder cannot hold links and sockets.
    """
    from footscan.workflow.served_rig import served_rig

    return served_rig(rig, build_world(rig, "left", MonotonicClock()), folder)


def capture_opener(rig: Rig) -> "OpenCapture":
    """What opens a rig's V4L2 camera: OpenCV, or a client of the emulated one that `footscan emulate` serves."""
    from footscan.devices.v4l2_camera import open_capture
    from footscan.sim.emulators.capture import Abilities
    from footscan.sim.emulators.server import RemoteCapture

    camera = rig.devices.camera
    if not isinstance(camera, V4l2CameraModel) or not Path(camera.path).is_socket():
        return open_capture
    view = camera_view(rig)
    size = (view.width_px, view.height_px * camera.rows_per_row)
    return RemoteCapture(Abilities((size,), (view.frames_per_s,)))


def camera_view(rig: Rig) -> View:
    """What the rig expects of its camera."""
    camera = rig.scanner.camera
    return View(camera.width_px, camera.height_px, rig.motion.frames_per_s, camera.image_rotation_deg)


def _open_devices(
    rig: Rig,
    models: DevicesModel,
    clock: Clock,
    world: World | None,
    opener: "ChooseCapture",
    opening: ExitStack,
) -> RigDevices:
    camera = _open_camera(rig, models.camera, world, opener)
    opening.callback(camera.close)
    encoder = _open_encoder(models.encoder, world)
    opening.callback(encoder.close)
    io = _open_io(rig, models.io, world)
    opening.pop_all()  # all are open: from now on their session closes them
    return RigDevices(camera, encoder, io, clock)


def _open_camera(rig: Rig, model: CameraModels, world: World | None, opener: "ChooseCapture") -> Camera:
    if not isinstance(model, SimulatedCamera):
        from footscan.devices.drivers import open_camera

        return open_camera(model, camera_view(rig), opener())
    assert world is not None
    camera = SimCamera(world, rig.motion.frames_per_s, model.exposure_s)
    camera.warm_up()
    return camera


def _open_encoder(model: EncoderModels, world: World | None) -> Encoder:
    if not isinstance(model, SimulatedEncoder):
        from footscan.devices.drivers import open_encoder

        return open_encoder(model)
    assert world is not None
    return SimEncoder(world, model.samples_per_s)


def _open_io(rig: Rig, model: IoModels, world: World | None) -> DigitalIo:
    if not isinstance(model, SimulatedIo):
        from footscan.devices.drivers import open_io

        return open_io(model)
    assert world is not None
    return SimDigitalIo(world, 0.5 * rig.motion.switching_s)


def build_world(rig: Rig, side: Side, clock: Clock) -> World:
    """The world of a rig's simulated devices.

    Raises:
        ConfigError: The rig file has no world.
        InputError: What should stand on the board cannot.
    """
    model = _world_model(rig)
    machine = true_machine(rig)
    home_rad = float(np.deg2rad(rig.motion.home_deg)) + _switch_off_rad(model)
    settings = WorldSettings(drive_of(rig.scanner, rig.motion), home_rad, seed=model.seed or 0)
    module = None if model.mirror is None else MirroredModule(Path(model.mirror))
    return World(machine, _standing(model, machine, side), settings, clock, module)


def true_machine(rig: Rig) -> TrueMachine:
    """The simulated machine as it really is.

    Its zero of the encoder is that of the design, off by what its home switch is off: the counter is set there.
    """
    model = _world_model(rig)
    machine = ideal_machine(rig.scanner) if model.seed is None else workshop_machine(rig.scanner, model.seed)
    encoder = machine.calibration.encoder
    off_counts = round(encoder.direction * _switch_off_rad(model) * encoder.steps_per_rev / (2.0 * np.pi))
    encoder = replace(encoder, zero_count=rig.scanner.encoder.zero_count - off_counts)
    calibration = replace(machine.calibration, machine_id=rig.scanner.machine_id, encoder=encoder)
    return TrueMachine(rig.scanner, calibration)


def calibration_in_force(rig: Rig, data: Path) -> tuple[Calibration | None, str]:
    """The calibration a scan uses, and a word about it: the data folder's, or the truth of a simulated machine.

    Raises:
        ConfigError: The stored file is damaged.
    """
    path = calibration_path(rig, data)
    if path.is_file():
        return load_calibration(path), f"calibration {path}"
    if rig.devices.world is not None:
        return true_machine(rig).calibration, "simulated machine: its true calibration is used until one is made"
    return None, f"no calibration: {path} does not exist"


def calibration_path(rig: Rig, data: Path) -> Path:
    """Where the calibration in force of a machine lies."""
    return data / "calibrations" / f"{rig.scanner.machine_id or rig.scanner.name}.toml"


def keep_calibration(rig: Rig, data: Path, calibration: Calibration) -> Path:
    """Write the calibration in force, for whoever processes the recording again; returns where."""
    path = calibration_path(rig, data)
    save_calibration(calibration, path)
    return path


def start_session(opened: OpenedRig, calibration: Calibration | None) -> Session:
    """The control thread over opened devices; everything is off.

    Raises:
        DeviceError: A device does not answer; all are given back.
    """
    with ExitStack() as opening:
        for device in (opened.devices.camera, opened.devices.encoder, opened.devices.io):
            opening.callback(device.close)
        tables = None if calibration is None else build_tables(calibration)
        session = Session(opened.devices, SessionSetup(opened.rig.scanner, opened.rig.motion, calibration, tables))
        session.start()
        opening.pop_all()  # from now on the session closes them
    return session


def _world_model(rig: Rig) -> WorldModel:
    if rig.devices.world is None:
        raise ConfigError(f"{rig.path}: simulated devices need a table [devices.world] that says what they look at.")
    return rig.devices.world


def _standing(model: WorldModel, machine: TrueMachine, side: Side) -> Standing:
    body = build_object(model.object, model.unit, side, model.size)
    beside = tuple(part.surface for name in model.obstacles for part in build_obstacle(name, body, side))
    return Standing(body, machine, _PERSONS[model.person], model.seed or 0, beside)


def _calibration_board(machine: TrueMachine, setup: int | None, seed: int) -> BoardStanding:
    return BoardStanding(None if setup is None else stand_board(setup, seed=seed), machine)


def _switch_off_rad(model: WorldModel) -> float:
    if model.seed is None:
        return 0.0
    return float(np.random.default_rng([model.seed, 0x403E]).uniform(-_HOME_PLAY_RAD, _HOME_PLAY_RAD))
