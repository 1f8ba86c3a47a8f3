"""Which rig a command uses."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from footscan.config.rig_file import Rig, load_rig
from footscan.errors import InputError
from footscan.workflow.designs import builtin_rig

RigOption = Annotated[Path | None, typer.Option(help="Rig file; default: the simulated machine.")]


def chosen_rig(path: Path | None, fast: bool) -> Rig:
    """The rig of a file, or the simulated one.

    Raises:
        ConfigError: A damaged file.
        InputError: A real machine cannot be hurried.
    """
    rig = load_rig(path) if path is not None else builtin_rig()
    if not fast:
        return rig
    if rig.devices.world is None:
        raise InputError("--fast is for the simulated machine; a real one needs its time.")
    if rig.devices.emulated:
        raise InputError("--fast is for simulated devices; emulated ones speak over wires, which need their time.")
    world = rig.devices.world.model_copy(update={"time": "fast"})
    return replace(rig, devices=rig.devices.model_copy(update={"world": world}))
