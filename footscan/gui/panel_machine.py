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
.mantine-Button-root { min-height: 34px }
[id="%s"] { min-height: 50px; font-size: 19px; font-weight: 700 }
[data-dock-header] button:has(.tabler-icon-adjustments) { display: none }
button:has(.icon-tabler-chevron-right), button:has(.icon-tabler-chevron-down) {
  background: #fff !important; color: #212529 !important; border: 1px solid #ced4da }
[data-dock-root] label { color: #495057 }
[data-dock-root] input:focus-visible { outline: 2px solid #009ed3; outline-offset: 1px }
[data-dock-root] [role="slider"] { width: 13px !important; height: 18px !important }
[data-dock-root] .mantine-Checkbox-root { --checkbox-size: 20px !important }
[data-dock-root] .mantine-TextInput-input, [data-dock-root] .mantine-Select-input {
  min-height: 28px; font-size: 13px; letter-spacing: normal }
[data-dock-area] div:has(> p > label) { width: 8.6em !important }
[data-dock-root] .mantine-ScrollArea-content:not(:has(.mantine-ScrollArea-content)) { padding-right: 10px }
.mantine-ScrollArea-viewport:has([data-dock-area]) div:has([data-dock-area]) { height: 100%% }
div:has(> div > [data-dock-area]) { display: flex; flex-direction: column }
div:has(> div > [data-dock-area]) > div { flex: none }
div:has(> div > [data-dock-area]) > div:has(> [data-dock-area]) { flex: 1 1 0; min-height: 0; height: auto }
[data-dock-area], [data-dock-area] > div { height: 100%%; min-height: 0 }
[data-dock-area] > div > :not([data-dock-strip]) { flex: 1 1 0; min-height: 0 }
[data-dock-area] > div > :not([data-dock-strip]) div:has(.mantine-ScrollArea-viewport) { height: 100%% }
[data-dock-area] .mantine-ScrollArea-viewport { max-height: 100%% !important }
</style>"""
"""Targets a hand can hit and words an eye can read; tabs that scroll by themselves, with room for their scroll bars,
below a head that stays and takes the height it needs. viser has none of it; its settings would take STOP's place."""
_BAR = "height:9px;border-radius:4px"
_RED, _AMBER, _GREY = "#c81e1e", "#a85b00", "#444"


class MachinePanel:
    """STOP and the state line."""

    def __init__(self, server: viser.ViserServer, desk: Desk, station: Station) -> None:
        self._desk, self._station = desk, station
        gui = server.gui
        self.stop = gui.add_button(texts.STOP, color="red", icon=viser.Icon.HAND_STOP, hint=texts.STOP_HINT)
        self._line = gui.add_html(f'<div style="padding:0 1em 4px;font-size:14px">{texts.OPENING}</div>')
        self._cancel = gui.add_button(texts.CANCEL, hint=texts.CANCEL_HINT, icon=viser.Icon.X, visible=False)
        self._reset = gui.add_button(texts.RESET, hint=texts.RESET_HINT, visible=False)
        gui.add_html(_STYLE % self.stop._impl.uuid)  # pyright: ignore[reportPrivateUsage]
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

    def _put_right(self) -> None:
        self._station.session.post_reset().wait(10.0)

    def tick(self, snapshot: Snapshot) -> None:
        """Show the machine as it is now."""
        job = self._desk.state.job
        words = machine_words(snapshot, self._desk.state.calibration)
        put(self._line, content=state_line(snapshot, self._station, job, words))
        cancelling = job is not None and job.words == texts.CANCELLING
        put(
            self._cancel,
            visible=job is not None,
            disabled=cancelling,
            label=texts.CANCELLING if cancelling else texts.CANCEL,
        )
        put(self._reset, visible=_wrong(snapshot))


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
    return (
        f'<div role="status" data-footscan="state" style="padding:0 1em 4px;font-size:14px;line-height:1.4;'
        f'border-bottom:1px solid #ddd">{_laser_banner(snapshot)}'
        f'<div style="font-weight:600;color:{_RED if wrong else _GREY};max-height:5.6em;overflow-y:auto">{message}'
        f'</div><div style="font-size:12.5px;color:#555">{_facts(snapshot, station)}</div>'
        f"{_job_bar(snapshot, job)}</div>"
    )


def _facts(snapshot: Snapshot, station: Station) -> str:
    """Two lines, whatever they say: what stands below does not move up and down."""
    head = texts.HEAD_UNKNOWN if snapshot.theta_deg is None else texts.HEAD_AT.format(degrees=snapshot.theta_deg)
    free = texts.DISK_FREE.format(gigabytes=shutil.disk_usage(station.data).free / 1e9)
    lines = f"{_chips(snapshot, station)} {head}", f"{_calibration_words(station)} · {free}"
    return "".join(
        f'<div style="white-space:nowrap;overflow:hidden;text-overflow:ellipsis">{line}</div>' for line in lines
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
    if job.words == texts.CANCELLING:
        return 0.0, job.words
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
