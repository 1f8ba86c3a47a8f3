"""A machine of emulators served in a folder: ports, sockets, and the files with which another program opens it."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from footscan.config import save_calibration
from footscan.config.device_models import QsbModel, V4l2CameraModel
from footscan.config.io_models import AdamModel
from footscan.config.port_name import EMULATED
from footscan.config.rig_file import Rig
from footscan.config.toml_file import read_toml, toml_bytes, write_whole
from footscan.errors import ConfigError, StorageError
from footscan.sim.emulators.emulated_rig import EmulatedRig
from footscan.sim.emulators.server import CAMERA, EmulatorServer, ask
from footscan.sim.world import World

RIG_FILE, CALIBRATION_FILE = "rig.toml", "calibration.toml"


@dataclass(frozen=True)
class ServedRig:
    """Emulators that run until their context ends.

    Attributes:
        world: What they live in.
        emulated: The emulators.
        server: Serves pictures and takes commands.
        rig_file: The rig with the places of the emulators, without a world: to a program it is a real machine.
        calibration_file: The truth of the simulated machine.
        places: What a rig file says to reach each device: the table, the key and the path.
    """

    world: World
    emulated: EmulatedRig
    server: EmulatorServer
    rig_file: Path
    calibration_file: Path
    places: dict[str, tuple[str, Path]]


@contextmanager
def served_rig(rig: Rig, world: World, folder: Path) -> Generator[ServedRig]:
    """Switch the emulators of a rig on behind fixed links in `folder`, and write how to reach them.

    Raises:
        ConfigError: Nothing in the rig is emulated, or something in it is simulated and lives in one program only.
        StorageError: The folder cannot hold links and sockets, or another machine is served there.
    """
    _refuse_other_rigs(rig)
    folder = folder.absolute()
    _refuse_second(folder)
    emulated, server = _switched_on(rig, world, folder)
    try:
        places = _places(rig, folder)
        table = read_toml(rig.path)
        for device, (key, path) in places.items():
            table["devices"][device][key] = str(path)
        table["devices"].pop("world")
        write_whole(folder / RIG_FILE, toml_bytes(table))
        save_calibration(world.machine.calibration, folder / CALIBRATION_FILE)
        yield ServedRig(world, emulated, server, folder / RIG_FILE, folder / CALIBRATION_FILE, places)
    finally:
        server.close()


def _switched_on(rig: Rig, world: World, folder: Path) -> tuple[EmulatedRig, EmulatorServer]:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        emulated = EmulatedRig(world, rig.devices, rig.motion.frames_per_s, links=folder)
        return emulated, EmulatorServer(world, emulated, folder)
    except OSError as err:
        raise StorageError(
            f"{folder} cannot hold the links and sockets of the emulators ({err}); choose a folder with a short path, "
            "such as /tmp/machine."
        ) from err


def _places(rig: Rig, folder: Path) -> dict[str, tuple[str, Path]]:
    camera, encoder, io = rig.devices.camera, rig.devices.encoder, rig.devices.io
    places: dict[str, tuple[str, Path]] = {}
    if isinstance(camera, V4l2CameraModel) and camera.path == EMULATED:
        places["camera"] = ("path", folder / CAMERA)
    if isinstance(encoder, QsbModel) and encoder.port == EMULATED:
        places["encoder"] = ("port", folder / "encoder")
    if isinstance(io, AdamModel) and io.port == EMULATED:
        places["io"] = ("port", folder / "io")
    return places


def _refuse_second(folder: Path) -> None:
    try:
        ask(folder, "state")
    except OSError:
        return  # nobody is there
    raise StorageError(f"another machine is served in {folder} already; end it, or choose another folder.")


def _refuse_other_rigs(rig: Rig) -> None:
    if not rig.devices.emulated:
        raise ConfigError(
            f'{rig.path}: nothing in it is "emulated"; take a rig file such as configs/rig-emulated.toml.'
        )
    if rig.devices.simulated:
        raise ConfigError(
            f'{rig.path}: its simulated devices live in one program only; make all of them "emulated" ones, as in '
            "configs/rig-emulated.toml."
        )
