"""Designs that come with footscan."""

from importlib import resources
from pathlib import Path
from typing import Literal

from footscan.config import load_scanner
from footscan.errors import InputError
from footscan.optics.scanner import Scanner

DesignName = Literal["prototype", "usb3-1440"]


def builtin_scanner(name: DesignName) -> Scanner:
    """A design from `configs/`, which the package carries along.

    Raises:
        InputError: The installation is incomplete.
    """
    for folder in (Path(str(resources.files("footscan"))) / "configs", Path(__file__).parents[2] / "configs"):
        path = folder / f"{name}.toml"
        if path.is_file():
            return load_scanner(path)
    raise InputError(f"the built-in design {name!r} is not installed; install footscan again.")
