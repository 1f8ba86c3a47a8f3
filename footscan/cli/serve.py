"""`footscan serve`: the page in the browser."""

import os
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from footscan.cli.console import STDERR, STDOUT
from footscan.cli.scan import chosen_rig
from footscan.records.data_folder import data_folder


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
) -> None:
    """Open the page from which the machine is driven; Ctrl-C ends it."""
    from footscan.gui.door import Address  # noqa: PLC0415 - no other command should wait for a web server to load
    from footscan.gui.serve import serve as serve_page  # noqa: PLC0415

    address = Address(host, port, tuple(origin or ()))
    STDERR.print("starting ...")

    def say(url: str) -> None:
        STDOUT.print(f"footscan is at {url}  (Ctrl-C ends it)")
        if not no_browser and (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            webbrowser.open(url)

    serve_page(chosen_rig(rig, fast=False), data_folder(data), address, say)
    STDOUT.print("ended; lasers and motor are off.")
