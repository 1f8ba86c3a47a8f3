"""`footscan serve`: the page in the browser."""

import os
import webbrowser
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from footscan.cli.console import STDOUT
from footscan.cli.scan import chosen_rig
from footscan.config.rig_file import Rig
from footscan.records import RecordStore
from footscan.records.data_folder import data_folder
from footscan.workflow.demo_patients import add_demo_patients


def serve(
    rig: Annotated[Path | None, typer.Option(help="Rig file; default: the simulated machine.")] = None,
    data: Annotated[Path | None, typer.Option(help="Data folder; default: FOOTSCAN_DATA or the user's own.")] = None,
    host: Annotated[str, typer.Option(help="Only this computer: 127.0.0.1, localhost or ::1.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="0 for any free one.")] = 8080,
    origin: Annotated[
        list[str] | None,
        typer.Option(help="Origin of a reverse proxy with TLS and log-in, such as https://scanner.example."),
    ] = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Only print the address.")] = False,
    demo: Annotated[bool, typer.Option("--demo", help="Enter two demo patients if there are none.")] = False,
    check: Annotated[
        bool, typer.Option("--check", help="Look whether the page stands, in a browser if there is one, and end.")
    ] = False,
) -> None:
    """Open the page from which the machine is driven; Ctrl-C ends it."""
    from footscan.gui.door import Address, check_address  # noqa: PLC0415 - no other command should wait for a web server to load
    from footscan.gui.serve import serve as serve_page  # noqa: PLC0415
    from footscan.gui.serve import serve_and_check  # noqa: PLC0415

    address, folder = Address(host, port, tuple(origin or ())), data_folder(data)
    check_address(address)  # before a data folder is made for a page that will not open
    if demo:
        with RecordStore(folder) as store:
            add_demo_patients(store)

    def say(sentence: str) -> None:
        STDOUT.print(sentence)
        url = next((word for word in sentence.split() if word.startswith("http://")), "")
        if url and not no_browser and not check:
            STDOUT.print("Ctrl-C ends it.")
            _show(url)

    (serve_and_check if check else serve_page)(paced(chosen_rig(rig, fast=False)), folder, address, say)
    STDOUT.print("ended; lasers and motor are off.")


def paced(rig: Rig) -> Rig:
    """A simulated machine must not stumble because this computer is busy; emulated wires need their real time."""
    world = rig.devices.world
    if world is None or world.time != "real" or rig.devices.emulated:
        return rig
    return replace(rig, devices=rig.devices.model_copy(update={"world": world.model_copy(update={"time": "paced"})}))


def _show(url: str) -> None:
    """Open a browser where there is a desktop."""
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        webbrowser.open(url)
