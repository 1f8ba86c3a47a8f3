"""The gate: every value from a browser is looked at before anything believes it.

viser takes whatever a client sends, also values outside a slider's range, words no list offers, presses of disabled
buttons, and properties that are no value at all.
"""

import math
import unicodedata
from collections.abc import Callable, Mapping
from typing import Any

import viser
from viser import _messages
from viser._gui_handles import (
    GuiButtonGroupHandle,
    GuiButtonHandle,
    GuiCheckboxHandle,
    GuiDropdownHandle,
    GuiNumberHandle,
    GuiSliderHandle,
    GuiTabGroupHandle,
    GuiTextHandle,
)

LONGEST_TEXT = 2000
May = Callable[[int, str], bool]
"""Whether a client (its number) may use an element (its uuid)."""


def refusal(handle: Any, updates: Mapping[str, Any]) -> str:
    """Why an update is not believed; empty when it is."""
    if set(updates) != {"value"}:
        return f"only values may be sent, not {', '.join(sorted(map(str, updates)))}"
    if getattr(handle, "disabled", False) or not getattr(handle, "visible", True):
        return "the element cannot be used now"
    return _refuse_value(handle, updates["value"])


def _refuse_value(handle: Any, value: Any) -> str:
    if isinstance(handle, GuiSliderHandle | GuiNumberHandle):
        return _refuse_number(handle, value)
    if isinstance(handle, GuiDropdownHandle | GuiButtonGroupHandle):
        return "" if isinstance(value, str) and value in handle.options else "no such choice"
    if isinstance(handle, GuiCheckboxHandle | GuiButtonHandle):
        return "" if isinstance(value, bool) else "yes or no was expected"
    if isinstance(handle, GuiTextHandle):
        return _refuse_text(value)
    return "this element takes no values"


def _refuse_number(handle: Any, value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return "a number was expected"
    low, high = handle.min, handle.max
    if (low is not None and value < low) or (high is not None and value > high):
        return f"{value:g} is outside {low:g} to {high:g}"
    if isinstance(handle.value, int) and value != int(value):
        return "a whole number was expected"
    return ""


def _refuse_text(value: Any) -> str:
    if not isinstance(value, str):
        return "text was expected"
    if len(value) > LONGEST_TEXT:
        return f"the text is longer than {LONGEST_TEXT} characters"
    if any(unicodedata.category(sign) in ("Cc", "Cs") and sign not in "\n\t" for sign in value):
        return "the text holds characters that cannot be printed"
    return ""


def guard(gui: viser.GuiApi, may: May, refused: Callable[[int, str], None]) -> None:
    """Put the gate before all elements of a `server.gui` or `client.gui`.

    Args:
        gui: Whose elements.
        may: Who may use what.
        refused: Told the client and the reason of each refusal.
    """
    interface = gui._websock_interface  # pyright: ignore[reportPrivateUsage]
    handles = gui._gui_input_handle_from_uuid  # pyright: ignore[reportPrivateUsage]
    update, hold = gui._handle_gui_updates, gui._handle_gui_button_hold  # pyright: ignore[reportPrivateUsage]

    async def guarded_update(client_id: Any, message: Any) -> None:
        handle = handles.get(message.uuid)
        if handle is None or isinstance(handle, GuiTabGroupHandle):
            return
        why = refusal(handle, message.updates) or ("" if may(client_id, message.uuid) else "watching")
        if not why:
            await update(client_id, message)
            return
        _show_true_value(gui, handle)
        refused(client_id, why)

    async def guarded_hold(client_id: Any, message: Any) -> None:
        handle = handles.get(message.uuid)
        if handle is not None and not refusal(handle, {"value": True}) and may(client_id, message.uuid):
            await hold(client_id, message)

    for kind, handler in ((_messages.GuiUpdateMessage, guarded_update), (_messages.GuiButtonHoldMessage, guarded_hold)):
        interface.unregister_handler(kind)
        interface.register_handler(kind, handler)


def _show_true_value(gui: viser.GuiApi, handle: Any) -> None:
    """The browser shows what was refused; make it show what holds."""
    if not handle._impl.is_button:
        message = _messages.GuiUpdateMessage(handle._impl.uuid, {"value": handle._impl.value})
        gui._websock_interface.queue_message(message)  # pyright: ignore[reportPrivateUsage]
