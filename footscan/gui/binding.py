"""Between handles of viser and the desk: callbacks only post, in the order in which the browser sent them."""

from collections.abc import Callable
from typing import Any

import viser

from footscan.gui import texts
from footscan.gui.desk import Desk

# Functions declared `async` run one after the other on viser's event loop; others run side by side in a pool.


def on_value(desk: Desk, handle: Any, act: Callable[[Any], None]) -> None:
    """Post what a person has entered; what the program itself has set is left alone.

    Typing and dragging send many values: each command takes the newest one, and what is typed or dragged must not be
    set back from the state, which is always a little behind.
    """
    listen = handle.on_click if isinstance(handle, viser.GuiButtonGroupHandle) else handle.on_update

    @listen
    async def _(event: Any) -> None:
        if event.client is not None:
            desk.post(lambda: act(handle.value))


def on_press(desk: Desk, handle: Any, act: Callable[[viser.ClientHandle], None]) -> None:
    """Post that a button was pressed, with the browser it was pressed in."""

    @handle.on_click
    async def _(event: Any) -> None:
        client = event.client
        if client is not None:
            desk.post(lambda: act(client))


def put(handle: Any, **values: Any) -> None:
    """Set what has changed; the rest is not sent again."""
    for name, value in values.items():
        if getattr(handle, name) != value:
            setattr(handle, name, value)


def put_options(handle: Any, options: tuple[str, ...], chosen: str) -> None:
    """New options of a dropdown, and which one is chosen."""
    if tuple(handle.options) != options:
        handle.options = options
    if handle.value != chosen:
        handle.value = chosen


def plain(words: str) -> str:
    """Words of a person as they are, where Markdown is shown: no sign of them means anything."""
    return "".join(f"&#{ord(sign)};" if not sign.isalnum() and sign != " " else sign for sign in words)


def ask(
    desk: Desk, client: viser.ClientHandle, title: str, body: str, yes: str, no: str, then: Callable[[], None],
    otherwise: Callable[[], None] = lambda: None,
) -> None:  # fmt: skip
    """Ask one browser a question; `then` or `otherwise` is posted, once.

    It covers the page, so it has a STOP of its own.
    """
    modal = client.gui.add_modal(title)
    answered: list[bool] = []

    def answer(act: Callable[[], None]) -> None:
        if not answered:
            answered.append(True)
            modal.close()
            act()

    with modal:
        client.gui.add_markdown(body)
        agree = client.gui.add_button(yes)  # red is STOP's alone
        refuse = client.gui.add_button(no, color="gray")
        stop = client.gui.add_button(texts.STOP, color="red", icon=viser.Icon.HAND_STOP, hint=texts.STOP_HINT)

    @stop.on_click
    async def _(_: Any) -> None:
        desk.stop()

    on_press(desk, agree, lambda _: answer(then))
    on_press(desk, refuse, lambda _: answer(otherwise))
