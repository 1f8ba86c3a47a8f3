"""`footscan screenshots`: pictures of the page for the documents."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from footscan.cli.console import STDERR, STDOUT
from footscan.cli.rig_option import chosen_rig
from footscan.cli.served import paced

_PACE = 3.0


def screenshots(
    out: Annotated[Path, typer.Option(help="Folder for the pictures.")] = Path("docs/pictures"),
) -> None:
    """Use the page like a person over the simulated machine and keep pictures of it; needs Chromium and playwright."""
    from footscan.gui.screenshots import take_screenshots  # noqa: PLC0415 - needs a dependency of developers

    rig = paced(chosen_rig(None, fast=False))
    assert rig.devices.world is not None
    hurried = rig.devices.world.model_copy(update={"pace": _PACE})
    rig = replace(rig, devices=rig.devices.model_copy(update={"world": hurried}))
    made = take_screenshots(rig, out, STDERR.print)
    STDOUT.print(f"{len(made)} pictures in {out}")
