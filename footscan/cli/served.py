"""What `footscan serve` does once its door is open."""

from dataclasses import dataclass, replace
from pathlib import Path

import viser

from footscan.cli.console import STDERR, STDOUT
from footscan.cli.rig_option import chosen_rig
from footscan.compiled import announce_compilation
from footscan.config.rig_file import Rig
from footscan.gui.door import Address
from footscan.gui.serve import check_behind, serve_behind
from footscan.records import RecordStore
from footscan.records.data_folder import data_folder
from footscan.workflow.demo_patients import add_demo_patients


@dataclass(frozen=True)
class Wishes:
    """Options of `footscan serve` that are not about its address."""

    rig: Path | None
    data: Path | None
    demo: bool
    check: bool


def serve_wished(server: viser.ViserServer, address: Address, wishes: Wishes) -> None:
    """Open machine and records and serve, or look whether the page stands.

    Raises:
        FootscanError: As `page_behind`; a page that does not stand.
    """
    rig, folder = paced(chosen_rig(wishes.rig, fast=False)), data_folder(wishes.data)
    fill = add_demo_patients if wishes.demo else _nobody
    with announce_compilation(STDERR.print):
        if wishes.check:
            check_behind(server, rig, folder, fill, address, STDOUT.print)
        else:
            serve_behind(server, rig, folder, fill)


def _nobody(store: RecordStore) -> None:
    """The records stay as they are."""


def paced(rig: Rig) -> Rig:
    """A simulated machine must not stumble because this computer is busy; emulated wires need their real time."""
    world = rig.devices.world
    if world is None or world.time != "real" or rig.devices.emulated:
        return rig
    return replace(rig, devices=rig.devices.model_copy(update={"world": world.model_copy(update={"time": "paced"})}))
