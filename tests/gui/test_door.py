"""The page is for this computer: foreign hosts and origins are refused, busy ports are said, nothing is shared."""

import socket
from collections.abc import Generator
from contextlib import redirect_stdout
from io import StringIO
from typing import TYPE_CHECKING

import pytest
import viser
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from footscan.errors import ConfigError, InputError
from footscan.gui import texts
from footscan.gui.door import Address, check_address, open_door, opened_door, tell_refusal, url_of

if TYPE_CHECKING:
    from playwright.sync_api import Browser

ORIGIN = "https://scanner.example"
PROTOCOL = [f"viser-v{viser.__version__}"]


@pytest.fixture(scope="module")
def server() -> Generator[viser.ViserServer]:
    with redirect_stdout(StringIO()):
        server = open_door(Address(port=0, origins=(ORIGIN,)), "test")
    yield server
    server.stop()


def _status(server: viser.ViserServer, origin: str | None) -> int:
    try:
        connect(f"ws://127.0.0.1:{server.get_port()}", origin=origin, subprotocols=PROTOCOL).close()  # pyright: ignore
    except InvalidStatus as refusal:
        return refusal.response.status_code
    return 101


@pytest.mark.parametrize(
    "origin",
    [None, "null", "http://evil.example", "https://scanner.example.evil.com", "http://127.0.0.1.evil.com:80"],
)
def test_a_foreign_or_missing_origin_gets_403(server: viser.ViserServer, origin: str | None) -> None:
    assert _status(server, origin) == 403


def test_this_computer_and_the_named_proxy_come_in(server: viser.ViserServer) -> None:
    assert _status(server, f"http://127.0.0.1:{server.get_port()}") == 101
    assert _status(server, f"http://localhost:{server.get_port()}") == 101
    assert _status(server, ORIGIN) == 101


def test_with_a_fixed_port_pages_of_other_ports_on_this_computer_are_foreign() -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with redirect_stdout(StringIO()):
        server = open_door(Address(port=port), "test")
    try:
        assert _status(server, f"http://127.0.0.1:{port}") == 101
        assert _status(server, f"http://127.0.0.1:{port + 1}") == 403
    finally:
        server.stop()


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.5", "scanner.example", "::", ""])
def test_another_host_is_refused_with_the_way_to_do_it(host: str) -> None:
    with pytest.raises(InputError, match=r"docs/howto/network\.md"):
        check_address(Address(host))


def test_a_busy_port_is_said_at_once(server: viser.ViserServer) -> None:
    with pytest.raises(InputError, match=r"cannot be used .* another port with --port"):
        check_address(Address(port=server.get_port()))


@pytest.mark.parametrize("port", [-1, 65536])
def test_an_impossible_port_is_refused(port: int) -> None:
    with pytest.raises(InputError, match="allowed are 1 to 65535"):
        check_address(Address(port=port))


@pytest.mark.parametrize("origin", ["http://a.example", "https://*.example", "https://a.example/page", "a.example", ""])
def test_an_origin_that_would_open_more_than_a_proxy_is_refused(origin: str) -> None:
    with pytest.raises(InputError, match=r"https://scanner\.example"):
        check_address(Address(origins=(origin,)))


def test_nobody_opens_a_tunnel(server: viser.ViserServer) -> None:
    with pytest.raises(ConfigError, match="switched off"):
        server.request_share_url()


@pytest.mark.browser
def test_what_cannot_be_opened_is_said_on_the_page_and_stays_when_the_door_closes(chromium: "Browser") -> None:
    address, tab = Address(port=0), chromium.new_page()
    with opened_door(address) as server:
        tab.goto(url_of(server, address))
        tab.get_by_text("is starting").wait_for()
        tell_refusal(server, "the camera <b>x</b> does not exist; plug it in.", 0.0)
    tab.wait_for_timeout(1000)
    told = tab.get_by_role("alert").last.inner_text()
    tab.close()

    assert texts.NOT_OPENED in told
    assert "the camera <b>x</b> does not exist; plug it in." in told
