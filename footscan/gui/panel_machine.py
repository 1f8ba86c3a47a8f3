"""What is always there: STOP, the machine's state, its calibration, the disk. It stays when the tabs below scroll."""

import html
import shutil
from typing import Any

import viser

from footscan.gui import texts
from footscan.gui.binding import on_press, put
from footscan.gui.desk import Desk
from footscan.gui.state import CalibrationChoice, Job
from footscan.gui.station import Station
from footscan.scanning.session.states import Snapshot, State
from footscan.workflow.calibration_log import OLDEST_DAYS

_STYLE = """<style>
.mantine-Button-root {{ min-height: 34px }}
[id="{stop}"] {{ min-height: 50px; font-size: 19px; font-weight: 700 }}
[data-dock-area] .mantine-ScrollArea-viewport {{ max-height: calc(100vh - {head:.0f}px) }}
[data-dock-root] .mantine-ScrollArea-content:not(:has(.mantine-ScrollArea-content)) {{ padding-right: 10px }}
</style>"""
"""Targets a hand can hit, tabs that scroll by themselves below a head that stays, and room for their scroll bars, which
lie over them otherwise; viser has none of it."""
_HEAD_PX, _BUTTON_PX, _JOB_PX, _BANNER_PX, _LINE_PX = 228.0, 44.0, 40.0, 34.0, 22.0
"""Height of the head at rest, and what a button, a running job, the banner of a laser and a further line add."""
_LINE_LETTERS, _MOST_LINES = 50, 4
_BAR = "height:9px;border-radius:4px"
_RED, _AMBER, _GREY = "#c81e1e", "#a85b00", "#444"


class MachinePanel:
    """STOP and the state line."""

    def __init__(self, server: viser.ViserServer, desk: Desk, station: Station) -> None:
        self._desk, self._station, self._clients = desk, station, server.get_clients
        gui = server.gui
        self.stop = gui.add_button(texts.STOP, color="red", icon=viser.Icon.HAND_STOP, hint=texts.STOP_HINT)
        self._line = gui.add_html(f'<div style="padding:0 1em 4px;font-size:14px">{texts.OPENING}</div>')
        self._cancel = gui.add_button(texts.CANCEL, hint=texts.CANCEL_HINT, icon=viser.Icon.X, visible=False)
        self._reset = gui.add_button(texts.RESET, hint=texts.RESET_HINT, visible=False)
        self._style = gui.add_html(self._styled(_HEAD_PX))
        command = gui.add_command(texts.STOP_HOTKEY_LABEL, hotkey="X")

        @self.stop.on_click
        async def _(_: Any) -> None:
            desk.stop()

        @command.on_trigger
        async def _(_: Any) -> None:
            desk.stop()

        on_press(desk, self._reset, lambda _: self._put_right())

        @self._cancel.on_click
        async def _(_: Any) -> None:
            desk.cancel()

    def _styled(self, head_px: float) -> str:
        return _STYLE.format(stop=self.stop._impl.uuid, head=head_px)  # pyright: ignore[reportPrivateUsage]

    def _put_right(self) -> None:
        self._station.session.post_reset().wait(10.0)

    def tick(self, snapshot: Snapshot) -> None:
        """Show the machine as it is now."""
        job = self._desk.state.job
        words = machine_words(snapshot, self._desk.state.calibration)
        put(self._line, content=state_line(snapshot, self._station, job, words))
        put(self._cancel, visible=job is not None)
        put(self._reset, visible=_wrong(snapshot))
        put(self._style, content=self._styled(head_px(snapshot, job, len(self._clients()))))


def head_px(snapshot: Snapshot, job: Job | None, browsers: int) -> float:
    """How high the part above the tabs is, so that these reach down to the window's edge and no further."""
    letters = len(snapshot.message or snapshot.state.value)
    lines = min(max(-(-letters // _LINE_LETTERS), 1), _MOST_LINES) - 1
    lines += 1 if snapshot.armed else 0  # its chip moves the facts to a further line
    buttons = int(job is not None) + int(_wrong(snapshot)) + int(browsers > 1)
    parts = (buttons, _BUTTON_PX), (int(job is not None), _JOB_PX), (int(bool(snapshot.lasers)), _BANNER_PX)
    return _HEAD_PX + _LINE_PX * lines + sum(count * px for count, px in parts)


def _wrong(snapshot: Snapshot) -> bool:
    return snapshot.state is State.FAULT or not snapshot.estop_ok


def machine_words(snapshot: Snapshot, calibration: CalibrationChoice) -> str:
    """What the machine says of itself, with the page's own words where the next step depends on the tab."""
    said = snapshot.message or snapshot.state.value
    if said == State.CONNECTED.value:
        return texts.HOME_FIRST
    if said == State.CLOSED.value:
        return texts.MACHINE_CLOSED
    recording = calibration.folder is not None and not calibration.recorded
    return texts.CALIBRATE_PARKED if recording and said == State.PARKED.value else said


def state_line(snapshot: Snapshot, station: Station, job: Job | None, words: str) -> str:
    """The machine's state as HTML; red all over while a laser shines."""
    wrong = _wrong(snapshot) or snapshot.state is State.CLOSED
    message = html.escape(words)
    head = texts.HEAD_UNKNOWN if snapshot.theta_deg is None else texts.HEAD_AT.format(degrees=snapshot.theta_deg)
    free = shutil.disk_usage(station.data).free / 1e9
    facts = f"{head} · {_calibration_words(station)} · {texts.DISK_FREE.format(gigabytes=free)}"
    return (
        f'<div role="status" data-footscan="state" style="padding:0 1em 4px;font-size:14px;line-height:1.4;'
        f'border-bottom:1px solid #ddd">{_laser_banner(snapshot)}'
        f'<div style="font-weight:600;color:{_RED if wrong else _GREY};max-height:5.6em;overflow-y:auto">{message}'
        f'</div><div style="font-size:12.5px;color:#555">{_chips(snapshot, station)} {facts}</div>'
        f"{_job_bar(snapshot, job)}</div>"
    )


def _laser_banner(snapshot: Snapshot) -> str:
    if not snapshot.lasers:
        return ""
    words = texts.LASER_ON.format(lasers=" + ".join(snapshot.lasers))
    return (
        f'<div style="background:{_RED};color:white;font-weight:700;font-size:16px;text-align:center;'
        f'border-radius:4px;padding:3px">{html.escape(words)}</div>'
    )


def _job_bar(snapshot: Snapshot, job: Job | None) -> str:
    """What is being done, how far it is, and how long it will take where that is known."""
    if job is None:
        return ""
    percent, words = job_words(snapshot, job)
    return (
        f'<div style="font-weight:700;font-size:16px;margin-top:3px">{html.escape(words)}</div>'
        f'<div role="progressbar" aria-valuenow="{percent:.0f}" style="{_BAR};background:#e4e8ea">'
        f'<div style="{_BAR};width:{percent:.1f}%;background:#006080"></div></div>'
    )


def job_words(snapshot: Snapshot, job: Job) -> tuple[float, str]:
    """Percent done, and what the operator reads."""
    if snapshot.state is State.COUNTDOWN:
        return 0.0, texts.STAND_STILL.format(seconds=snapshot.remaining_s + 0.5)
    if snapshot.state is State.SCANNING:
        percent = 100.0 * snapshot.progress
        frames = snapshot.frames.captured
        return percent, texts.REMAINING.format(percent=percent, seconds=snapshot.remaining_s, frames=frames)
    if snapshot.state is State.CALIBRATING:
        return 100.0 * snapshot.progress, texts.STOPS.format(what=job.words, percent=100.0 * snapshot.progress)
    if job.total:
        return 100.0 * job.done / job.total, texts.PROCESSING.format(what=job.words, done=job.done, total=job.total)
    return 0.0, f"{job.words} ..."


def _chips(snapshot: Snapshot, station: Station) -> str:
    chips = [_chip(texts.SIMULATED)] if station.simulated else []
    if snapshot.armed:
        chips.append(_chip(texts.ARMED))
    return " ".join(chips)


def _calibration_words(station: Station) -> str:
    if station.calibration is None:
        return f'<b style="color:{_RED}">{texts.NO_CALIBRATION}</b>'
    days = station.calibration_days()
    if days is None:
        return texts.CALIBRATION_UNDATED
    why = html.escape("; ".join(doubt.sentence for doubt in station.doubts))
    if station.invalid:
        return f'<b style="color:{_RED}" title="{why}">{texts.CALIBRATION_INVALID}</b>'
    if days > OLDEST_DAYS:
        return f'<b style="color:{_AMBER}" title="{why}">{texts.CALIBRATION_OLD.format(days=days)}</b>'
    words = texts.CALIBRATION_TODAY if days < 1 else texts.CALIBRATION_AGE.format(days=days)
    return f'<b style="color:{_AMBER}" title="{why}">{words}, {texts.CALIBRATION_DOUBT}</b>' if why else words


def _chip(words: str) -> str:
    return (
        f'<span style="background:{_AMBER};color:white;border-radius:4px;padding:1px 7px;font-size:12px;'
        f'font-weight:600;white-space:nowrap">{html.escape(words)}</span>'
    )
