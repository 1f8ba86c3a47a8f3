"""The panel that is always there: the machine's state, its calibration, the disk, STOP, and who controls."""

import html
import shutil
from typing import Any

import viser

from footscan.gui import texts
from footscan.gui.binding import on_press, put
from footscan.gui.desk import Desk
from footscan.gui.station import Station
from footscan.scanning.session.states import Snapshot, State
from footscan.workflow.calibration_log import OLDEST_DAYS

_LARGE = (
    "<style>.mantine-Button-root{{min-height:34px}} "
    '[id="{stop}"],[id="{stop}"] .mantine-Button-root{{min-height:48px;font-size:19px;font-weight:700}}</style>'
)
"""Targets a hand can hit; viser has no size of its own for buttons."""
_RED, _AMBER, _GREEN, _GREY = "#c81e1e", "#a85b00", "#176b2c", "#555"


class MachinePanel:
    """The state line and STOP."""

    def __init__(self, server: viser.ViserServer, desk: Desk, station: Station) -> None:
        self._desk, self._station = desk, station
        self._line = server.gui.add_html("")
        self.stop = server.gui.add_button(texts.STOP, color="red", icon=viser.Icon.HAND_STOP, hint=texts.STOP_HINT)
        self._reset = server.gui.add_button(texts.RESET, hint=texts.RESET_HINT, visible=False)
        server.gui.add_html(_LARGE.format(stop=self.stop._impl.uuid))  # pyright: ignore[reportPrivateUsage]
        command = server.gui.add_command(texts.STOP_HOTKEY_LABEL, hotkey="X")

        @self.stop.on_click
        async def _(_: Any) -> None:
            station.session.post_cancel(texts.STOPPED_BY)

        @command.on_trigger
        async def _(_: Any) -> None:
            station.session.post_cancel(texts.STOPPED_BY)

        on_press(desk, self._reset, lambda _: self._put_right())

    def _put_right(self) -> None:
        self._station.session.post_reset().wait(10.0)

    def tick(self, snapshot: Snapshot) -> None:
        """Show the machine as it is now."""
        put(self._line, content=state_line(snapshot, self._station))
        fault = snapshot.state is State.FAULT or not snapshot.estop_ok
        put(self._reset, visible=fault)


def state_line(snapshot: Snapshot, station: Station) -> str:
    """The machine's state as HTML."""
    colour = _RED if snapshot.state is State.FAULT or not snapshot.estop_ok else _GREY
    message = snapshot.message or snapshot.state.value
    chips = [_chip(texts.SIMULATED, _AMBER)] if station.put_on_board is not None else []
    if snapshot.lasers:
        chips.append(_chip(texts.LASER_ON.format(lasers=" + ".join(snapshot.lasers)), _RED))
    if snapshot.armed:
        chips.append(_chip(texts.ARMED, _AMBER))
    head = texts.HEAD_UNKNOWN if snapshot.theta_deg is None else texts.HEAD_AT.format(degrees=snapshot.theta_deg)
    free = shutil.disk_usage(station.data).free / 1e9
    facts = f"{head} · {_calibration_words(station)} · {texts.DISK_FREE.format(gigabytes=free)}"
    return (
        f'<div role="status" style="padding:0 1em;font-size:14px;line-height:1.45">'
        f'<div style="font-weight:600;color:{colour}">{html.escape(message)}</div>'
        f'<div style="min-height:22px">{" ".join(chips)}</div>'
        f'<div style="font-size:12.5px;color:#555">{facts}</div></div>'
    )


def _calibration_words(station: Station) -> str:
    if station.calibration is None:
        return f'<b style="color:{_RED}">{texts.NO_CALIBRATION}</b>'
    days = station.calibration_days()
    if days is None:
        return texts.CALIBRATION_UNDATED
    if days > OLDEST_DAYS:
        return f'<b style="color:{_AMBER}">{texts.CALIBRATION_OLD.format(days=days)}</b>'
    return texts.CALIBRATION_AGE.format(days=days)


def _chip(words: str, colour: str) -> str:
    return (
        f'<span style="background:{colour};color:white;border-radius:4px;padding:1px 7px;font-size:12px;'
        f'font-weight:600">{html.escape(words)}</span>'
    )
