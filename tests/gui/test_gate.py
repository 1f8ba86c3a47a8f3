"""Whatever a browser sends, only values that the page offers are believed."""

import asyncio
from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import redirect_stdout
from io import StringIO
from typing import Any

import pytest
import viser
from hypothesis import given, settings
from hypothesis import strategies as st
from viser import _messages

from footscan.gui.door import Address, open_door
from footscan.gui.gate import LONGEST_TEXT, guard, refusal


@pytest.fixture(scope="module")
def server() -> Generator[viser.ViserServer]:
    with redirect_stdout(StringIO()):
        server = open_door(Address(port=0), "test")
    yield server
    server.stop()


@pytest.fixture(scope="module")
def handles(server: viser.ViserServer) -> dict[str, Any]:
    gui = server.gui
    return {
        "slider": gui.add_slider("s", 1, 254, 1, 60),
        "share": gui.add_slider("f", 0.0, 1.0, 0.1, 0.5),
        "dropdown": gui.add_dropdown("d", ("a", "b")),
        "group": gui.add_button_group("g", ("x", "y")),
        "checkbox": gui.add_checkbox("c", False),
        "button": gui.add_button("b"),
        "text": gui.add_text("t", ""),
        "off": gui.add_button("off", disabled=True),
        "hidden": gui.add_button("hidden", visible=False),
        "html": gui.add_html(""),
    }


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("slider", 999),
        ("slider", 0),
        ("slider", float("nan")),
        ("slider", float("inf")),
        ("slider", True),
        ("slider", "60"),
        ("slider", 60.5),
        ("slider", None),
        ("share", 1.01),
        ("dropdown", "z"),
        ("dropdown", 1),
        ("group", "z"),
        ("checkbox", 1),
        ("button", "yes"),
        ("text", 5),
        ("text", "a" * (LONGEST_TEXT + 1)),
        ("text", "bell\x07"),
        ("off", True),
        ("hidden", True),
        ("html", "<script>"),
    ],
)
def test_a_value_that_is_not_offered_is_refused(handles: dict[str, Any], name: str, value: Any) -> None:
    assert refusal(handles[name], {"value": value})


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("slider", 1),
        ("slider", 254),
        ("share", 0.3),
        ("dropdown", "b"),
        ("group", "x"),
        ("checkbox", True),
        ("button", True),
        ("text", "Željko 李 مريم"),
    ],
)
def test_a_value_that_is_offered_is_taken(handles: dict[str, Any], name: str, value: Any) -> None:
    assert refusal(handles[name], {"value": value}) == ""


def test_only_values_may_be_sent_not_properties(handles: dict[str, Any]) -> None:
    assert refusal(handles["slider"], {"value": 5, "max": 9999})
    assert refusal(handles["slider"], {"disabled": True})


@settings(max_examples=200, deadline=None)
@given(st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(), st.lists(st.integers())))
def test_whatever_is_sent_to_a_slider_only_its_range_is_taken(handles: dict[str, Any], value: Any) -> None:
    whole = isinstance(value, int | float) and not isinstance(value, bool) and value == value
    offered = whole and abs(value) < 1e6 and value == int(value) and 1 <= value <= 254

    assert (refusal(handles["slider"], {"value": value}) == "") == offered


def test_a_crafted_message_changes_nothing_and_is_reported(server: viser.ViserServer, handles: dict[str, Any]) -> None:
    refused: list[tuple[int, str]] = []
    guard(server.gui, lambda client, uuid: client == 1, lambda client, why: refused.append((client, why)))
    slider = handles["slider"]
    alone = ThreadPoolExecutor(1)

    def send(client: int, value: Any) -> None:
        message = _messages.GuiUpdateMessage(slider._impl.uuid, {"value": value})
        handlers = server.gui._websock_interface._incoming_handlers[_messages.GuiUpdateMessage]
        for handler in handlers:  # in a thread: Playwright's loop runs in this one while a browser test is under way
            alone.submit(lambda handler=handler: asyncio.run(handler(client, message))).result()

    send(1, 999)
    send(2, 100)
    assert slider.value == 60
    assert refused == [(1, "999 is outside 1 to 254"), (2, "watching")]
    send(1, 100)
    assert slider.value == 100
