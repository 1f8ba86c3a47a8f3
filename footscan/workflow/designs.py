"""Designs that come with footscan."""

from importlib import resources
from pathlib import Path
from typing import Literal

from footscan.config import load_scanner
from footscan.config.rig_file import Rig, load_rig
from footscan.errors import InputError
from footscan.optics.scanner import Scanner

DesignName = Literal["prototype", "usb3-1440"]


def builtin_scanner(name: DesignName) -> Scanner:
    """A design from `configs/`, which the package carries along.

    Raises:
        InputError: The installation is incomplete.
    """
    return load_scanner(builtin_config(name))


def builtin_rig() -> Rig:
    """The simulated rig, `configs/sim.toml`.

    Raises:
        InputError: The installation is incomplete.
    """
    return load_rig(builtin_config("sim"))


def builtin_config(name: str) -> Path:
    """Where a file of `configs/` lies, in a checkout or in an installed package.

    Raises:
        InputError: The installation is incomplete.
    """
    for folder in (Path(str(resources.files("footscan"))) / "configs", Path(__file__).parents[2] / "configs"):
        path = folder / f"{name}.toml"
        if path.is_file():
            return path
    raise InputError(f"the built-in file {name}.toml is not installed; install footscan again.")
