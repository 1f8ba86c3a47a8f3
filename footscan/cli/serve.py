"""`footscan serve`: the page in the browser."""

import os
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from footscan.cli.console import STDOUT
from footscan.errors import FootscanError

_BROWSER_COMES_S = 15.0


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
    # What takes long to load is loaded behind the open door, while the browser loads the page.
    from footscan.gui.door import Address, opened_door, tell_refusal, url_of  # noqa: PLC0415

    address = Address(host, port, tuple(origin or ()))
    with opened_door(address) as server:
        url = url_of(server, address)
        STDOUT.print(f"footscan is at {url}{'' if check else '  (Ctrl-C ends it)'}")
        desktop = bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
        shown = desktop and not no_browser and not check and webbrowser.open(url)
        from footscan.gui.readiness import hurried  # noqa: PLC0415

        with hurried():
            from footscan.cli.served import Wishes, serve_wished  # noqa: PLC0415

        try:
            serve_wished(server, address, Wishes(rig, data, demo, check))
        except FootscanError as err:
            tell_refusal(server, str(err), _BROWSER_COMES_S if shown else 0.0)
            raise
    STDOUT.print("ended; lasers and motor are off.")
