"""The only module that chooses real, emulated or simulated devices, by what a rig file says."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from footscan.config import load_calibration, save_calibration
from footscan.config.device_models import SimulatedCamera, SimulatedEncoder, SimulatedIo, WorldModel
from footscan.config.rig_file import Rig
from footscan.coordinates import Side
from footscan.devices.clock import Clock, MonotonicClock
from footscan.errors import ConfigError
from footscan.optics.calibration import Calibration
from footscan.scanning.session.control import RigDevices, Session, SessionSetup, drive_of
from footscan.sim.clock import VirtualClock
from footscan.sim.devices import SimCamera, SimDigitalIo, SimEncoder
from footscan.sim.machine import TrueMachine, ideal_machine, workshop_machine
from footscan.sim.module_twin import MirroredModule
from footscan.sim.objects import build_object
from footscan.sim.person import CALM, RESTLESS, STATUE, PersonSettings
from footscan.sim.standing import Standing
from footscan.sim.world import World, WorldSettings
from footscan.workflow.opened_rig import OpenedRig
from footscan.workflow.process import build_tables

_PERSONS: dict[str, PersonSettings] = {"statue": STATUE, "calm": CALM, "restless": RESTLESS}
_HOME_PLAY_RAD = np.deg2rad(0.3)
"""How far from its place the home switch of a simulated machine may sit."""


def open_rig(rig: Rig, side: Side = "left") -> OpenedRig:
    """Open all devices of a rig; on a simulated one a foot of that side stands on the board.

    Raises:
        ConfigError: A simulated device without a world, or devices that cannot work together.
        DeviceError: A device is missing or in trouble.
    """
    devices = rig.devices
    if not devices.simulated:
        raise ConfigError(f"{rig.path}: only simulated devices can be opened by this version.")
    model = _world_model(rig)
    clock: Clock = MonotonicClock() if model.time == "real" else VirtualClock()
    world = build_world(rig, side, clock)
    camera, encoder, io = devices.camera, devices.encoder, devices.io
    if not isinstance(camera, SimulatedCamera) or not isinstance(encoder, SimulatedEncoder):
        raise ConfigError(f"{rig.path}: a simulated camera needs a simulated encoder, and the other way round.")
    if not isinstance(io, SimulatedIo):
        raise ConfigError(f"{rig.path}: simulated devices need a simulated output module.")
    opened = RigDevices(
        SimCamera(world, rig.motion.frames_per_s, camera.exposure_s),
        SimEncoder(world, encoder.samples_per_s),
        SimDigitalIo(world, 0.5 * rig.motion.switching_s),
        clock,
    )
    return OpenedRig(rig, opened, world, lambda who: world.put(_standing(model, world.machine, who)))


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
    if rig.devices.world is not None and rig.devices.simulated:
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
        DeviceError: A device does not answer.
    """
    tables = None if calibration is None else build_tables(calibration)
    session = Session(opened.devices, SessionSetup(opened.rig.scanner, opened.rig.motion, calibration, tables))
    session.start()
    return session


def _world_model(rig: Rig) -> WorldModel:
    if rig.devices.world is None:
        raise ConfigError(f"{rig.path}: simulated devices need a table [devices.world] that says what they look at.")
    return rig.devices.world


def _standing(model: WorldModel, machine: TrueMachine, side: Side) -> Standing:
    body = build_object(model.object, model.unit, side, model.size)
    return Standing(body, machine, _PERSONS[model.person], seed=model.seed or 0)


def _switch_off_rad(model: WorldModel) -> float:
    if model.seed is None:
        return 0.0
    return float(np.random.default_rng([model.seed, 0x403E]).uniform(-_HOME_PLAY_RAD, _HOME_PLAY_RAD))
