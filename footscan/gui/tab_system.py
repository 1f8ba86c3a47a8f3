"""The System tab: devices in words, and the log."""

import html
from collections.abc import Iterator

import viser

from footscan.gui import texts
from footscan.gui.binding import put
from footscan.gui.desk import Desk
from footscan.gui.logbook import Logbook
from footscan.gui.station import Station

_LINES = 40


class SystemTab:
    """Handles of the tab."""

    def __init__(self, gui: viser.GuiApi, desk: Desk, station: Station, log: Logbook) -> None:
        del desk
        self._log, self._shown = log, -1
        with gui.add_folder(texts.DEVICES):
            gui.add_html(_table(device_facts(station)))
        with gui.add_folder(texts.LOG):
            self._lines = gui.add_html(texts.LOG_EMPTY)

    def tick(self) -> None:
        """New lines of the log."""
        if self._log.count != self._shown:
            self._shown = self._log.count
            lines = "".join(f"<div>{html.escape(line)}</div>" for line in self._log.latest(_LINES))
            put(self._lines, content=f'<div style="padding:0 1em;font:11.5px monospace">{lines}</div>')


def device_facts(station: Station) -> Iterator[tuple[str, str]]:
    """What the machine is made of, in words."""
    rig, facts = station.rig, station.session.facts
    yield "Machine", rig.scanner.machine_id or rig.scanner.name
    yield "Rig file", str(rig.path)
    yield "Camera", f"{facts.name}: {facts.width_px} x {facts.height_px} px, {facts.frames_per_s:g} frames/s"
    yield "Exposure", f"{1000.0 * facts.exposure_s:g} ms"
    yield "Encoder", f"{rig.devices.encoder.kind}, {rig.scanner.encoder.steps_per_rev} steps per turn"
    yield "Outputs", rig.devices.io.kind
    yield "Calibration", station.calibration_words
    yield "Data folder", str(station.data)


def _table(facts: Iterator[tuple[str, str]]) -> str:
    rows = "".join(
        f'<tr><th style="text-align:left;padding-right:8px">{html.escape(what)}</th>'
        f'<td style="overflow-wrap:anywhere">{html.escape(value)}</td></tr>'
        for what, value in facts
    )
    return f'<table style="font-size:13px;padding:0 1em">{rows}</table>'
