"""The door of the page: this computer only, known origins only, no tunnel; a busy port is said at once."""

import functools
import html
import re
import socket
import threading
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from typing import Any
from urllib.parse import urlsplit

import viser
import websockets.asyncio.server
from viser import _messages

from footscan.errors import ConfigError, InputError
from footscan.gui import texts

LOOPBACK = ("127.0.0.1", "localhost", "::1")
_PROXY_WORD = "docs/howto/network.md says how to open it to others through a reverse proxy with TLS and a log-in"
_LOCAL_ORIGINS = r"http://(127\.0\.0\.1|localhost|\[::1\]):{port}"
_UNUSED = (
    _messages.ShareUrlRequest,
    _messages.ShareUrlDisconnect,
    _messages.FileTransferStartUpload,
    _messages.GuiFormSubmitMessage,
    _messages.GuiFormDirtyMessage,
)
_TOLD_S = 1.5
"""What was sent reaches a browser that is still drawing."""
_opening = threading.Lock()


@dataclass(frozen=True)
class Address:
    """Where the page is served.

    Attributes:
        host: A loopback address.
        port: 0 for any free one.
        origins: Further origins that may connect, such as https://scanner.example: those of a reverse proxy.
    """

    host: str = "127.0.0.1"
    port: int = 8080
    origins: tuple[str, ...] = ()


def check_address(address: Address) -> None:
    """Refuse what would not work or would open the machine to others.

    Raises:
        InputError: A host that is not this computer alone; a port that is taken or not allowed; a malformed origin.
    """
    if address.host not in LOOPBACK:
        raise InputError(
            f"the page was to be served on {address.host!r}; it drives lasers and a motor and has no log-in, so it is "
            f"served on {LOOPBACK[0]} only. {_PROXY_WORD}."
        )
    if not 0 <= address.port <= 65535:
        raise InputError(f"the port is {address.port}; allowed are 1 to 65535, or 0 for any free one.")
    for origin in address.origins:
        _check_origin(origin)
    family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((address.host, address.port))
        except OSError as err:
            raise InputError(
                f"{address.host}:{address.port} cannot be used ({err.strerror}); another footscan may be running: use "
                "that one, close it, or choose another port with --port."
            ) from err


def _check_origin(origin: str) -> None:
    parts = urlsplit(origin)
    if parts.scheme != "https" or not parts.hostname or parts.path or parts.query or "*" in origin:
        raise InputError(
            f"the origin is {origin!r}; give that of your reverse proxy without a path, such as https://scanner.example."
        )


def open_door(address: Address, label: str) -> viser.ViserServer:
    """A viser server that answers this computer alone.

    Raises:
        InputError: As `check_address`.
    """
    check_address(address)
    with _checked_origins(address):
        server = viser.ViserServer(host=address.host, port=address.port, label=label, verbose=False)
    if address.port not in (0, server.get_port()):
        server.stop()
        raise InputError(f"port {address.port} was taken meanwhile; choose another with --port.")
    server.request_share_url = _no_tunnel
    for message in _UNUSED:
        server._websock_server.unregister_handler(message)  # pyright: ignore[reportPrivateUsage]
    return server


@contextmanager
def opened_door(address: Address) -> Generator[viser.ViserServer]:
    """A door with a word that the machine is being opened; closed at the end of the block.

    Raises:
        InputError: As `check_address`.
    """
    with redirect_stdout(StringIO()):  # viser prints a banner that names the wrong things to do
        server = open_door(address, texts.TITLE)
    try:
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.main_panel.dock_right()
        server.gui.add_html(f'<div style="padding:1em;font-size:16px">{texts.STARTING}</div>')
        yield server
    finally:
        server.stop()


def tell_refusal(server: viser.ViserServer, why: str, patience_s: float) -> None:
    """Show why nothing can be opened, in place of everything else; the browser keeps it when the door closes.

    Args:
        server: The door.
        why: The whole sentence.
        patience_s: How long to wait for a browser that is on its way.
    """
    server.gui.reset()
    server.gui.add_html(
        f'<div role="alert" style="padding:1em;font-size:16px"><b style="color:#c81e1e">{texts.NOT_OPENED}</b>'
        f"<p>{html.escape(why)}</p><p>{texts.NOT_OPENED_NEXT}</p></div>"
    )
    until_s = time.monotonic() + patience_s
    while not server.get_clients() and time.monotonic() < until_s:
        time.sleep(0.1)
    if server.get_clients():
        time.sleep(_TOLD_S)


def url_of(server: viser.ViserServer, address: Address) -> str:
    """What a browser on this computer opens."""
    host = f"[{address.host}]" if ":" in address.host else address.host
    return f"http://{host}:{server.get_port()}"


def _no_tunnel(verbose: bool = True) -> None:
    """Nobody opens a public tunnel to a machine with lasers."""
    del verbose
    raise ConfigError("sharing over the internet is switched off.")


@contextmanager
def _checked_origins(address: Address) -> Generator[None]:
    """While viser starts its web server, add the check of origins that it does not have itself."""
    serve: Callable[..., Any] = websockets.asyncio.server.serve
    port = address.port or r"\d+"
    allowed = [re.compile(_LOCAL_ORIGINS.format(port=port)), *address.origins]
    with _opening:
        websockets.asyncio.server.serve = functools.partial(serve, origins=allowed)  # pyright: ignore
        try:
            yield
        finally:
            websockets.asyncio.server.serve = serve  # pyright: ignore
