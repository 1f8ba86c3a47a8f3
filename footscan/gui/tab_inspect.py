"""The Inspect tab: a foot to turn, maps with a legend, a section at any plane, measurements, downloads."""

import html
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import viser

from footscan.errors import FootscanError, MeshError
from footscan.gui import texts
from footscan.gui.binding import on_press, on_value, put, put_options
from footscan.gui.desk import Desk
from footscan.gui.inspected import InspectedFoot, cut_at, open_foot, outline_svg
from footscan.gui.state import InspectChoice, PageState
from footscan.gui.station import Station
from footscan.gui.view_foot import FootView
from footscan.records import Take

_KEPT_FEET = 4


class InspectTab:
    """Handles of the tab, and the feet it has opened."""

    def __init__(self, gui: viser.GuiApi, desk: Desk, station: Station, view: FootView) -> None:
        self._desk, self._station, self._view = desk, station, view
        self._feet: dict[int, InspectedFoot] = {}
        self._drawn: tuple[Any, ...] | None = None
        self._cut: tuple[Any, ...] | None = None
        self._take = gui.add_dropdown(texts.TAKE, (texts.INSPECT_NONE,))
        self._shown = gui.add_dropdown(texts.SHOW, texts.SHOW_KINDS)
        self._beside = gui.add_checkbox(texts.OTHER_FOOT, False)
        self._legend = gui.add_html("")
        with gui.add_folder(texts.SECTION):
            self._share = gui.add_slider(texts.SECTION_SHARE, 0, 100, 1, 50, hint=texts.SECTION_SHARE_HINT)
            self._turn = gui.add_slider(texts.SECTION_TURN, -90, 90, 1, 0, hint=texts.SECTION_TURN_HINT)
            self._tilt = gui.add_slider(texts.SECTION_TILT, -90, 90, 1, 0, hint=texts.SECTION_TILT_HINT)
            self._section = gui.add_html("")
        self._table = gui.add_html("")
        with gui.add_folder(texts.DOWNLOADS):
            self._download = gui.add_button_group("", tuple(texts.DOWNLOAD_NAMES))
        self._bind()

    def _bind(self) -> None:
        def choose(**values: Any) -> None:
            self._desk.change(inspect=replace(self._desk.state.inspect, **values))

        desk = self._desk
        on_value(desk, self._take, lambda words: choose(take_id=_take_id(words)))
        on_value(desk, self._shown, lambda shown: choose(shown=shown))
        on_value(desk, self._beside, lambda beside: choose(beside=beside))
        on_value(desk, self._share, lambda percent: choose(share=percent / 100.0))
        on_value(desk, self._turn, lambda degrees: choose(turn_deg=float(degrees)))
        on_value(desk, self._tilt, lambda degrees: choose(tilt_deg=float(degrees)))
        on_press(desk, self._download, self._send)

    def show(self, state: PageState) -> None:
        """What the desk says."""
        takes = [take for take in state.takes if take.result is not None and not take.result.refused]
        options = tuple(_words(take) for take in takes) or (texts.INSPECT_NONE,)
        chosen = next((take for take in takes if take.id == state.inspect.take_id), takes[0] if takes else None)
        put_options(self._take, options, options[0] if chosen is None else _words(chosen))
        foot = None if chosen is None else self._open(chosen)
        self._draw(state, takes, foot)
        self._draw_section(state.inspect, foot)

    def _open(self, take: Take) -> InspectedFoot | None:
        assert take.result is not None
        key = take.result.id
        if key not in self._feet:
            try:
                self._feet[key] = open_foot(self._station, take)
            except FootscanError as err:
                self._desk.say(texts.FAILED, str(err), wrong=True)
                return None
            for old in list(self._feet)[:-_KEPT_FEET]:
                del self._feet[old]
        return self._feet[key]

    def _draw(self, state: PageState, takes: list[Take], foot: InspectedFoot | None) -> None:
        """The feet, the legend and the table, when something about them is new."""
        choice = state.inspect
        running = state.job is not None and state.job.words in (texts.JOB_CHECK, texts.JOB_SCAN)
        feet = [] if foot is None or running else [foot, *self._other(choice, takes, foot)]
        now = (tuple(id(each) for each in feet), choice.shown)
        if now == self._drawn:
            return
        self._drawn = now
        if feet:
            self._view.hide_cloud()
        self._view.show_feet([each.mesh for each in feet], choice.shown)
        legend = {"Seen / assumed": texts.LEGEND_ORIGIN, "Distance to points": texts.LEGEND_RESIDUAL}
        put(self._legend, content=_box(legend.get(choice.shown, "")))
        put(self._table, content=_box("" if foot is None else measurement_table(foot.measurements)))

    def _other(self, choice: InspectChoice, takes: list[Take], foot: InspectedFoot) -> list[InspectedFoot]:
        if not choice.beside:
            return []
        others = [take for take in takes if take.said.side != foot.take.said.side]
        best = next((take for take in others if take.in_use), others[0] if others else None)
        other = None if best is None else self._open(best)
        return [] if other is None else [other]

    def _draw_section(self, choice: InspectChoice, foot: InspectedFoot | None) -> None:
        now = (id(foot), choice.share, choice.turn_deg, choice.tilt_deg, choice.beside, self._drawn)
        if now == self._cut:
            return
        self._cut = now
        if foot is None or not self._drawn or not self._drawn[0]:
            self._view.show_section(())
            put(self._section, content=_box(texts.INSPECT_NONE if foot is None else ""))
            return
        try:
            cut = cut_at(foot, choice.share, choice.turn_deg, choice.tilt_deg)
        except MeshError:
            self._view.show_section(())
            put(self._section, content=_box(texts.SECTION_MISSES))
            return
        self._view.show_section(() if choice.beside else cut.polylines)
        unseen = cut.hull_unseen_share
        words = texts.SECTION_TABLE.format(
            area=cut.area_mm2 / 100.0,
            perimeter=cut.perimeter_mm,
            tape=cut.hull_perimeter_mm,
            width=cut.width_mm,
            height=cut.height_mm,
            unseen=texts.SECTION_UNSEEN.format(share=unseen) if unseen else "",
        )
        put(self._section, content=_box(f"{outline_svg(cut)}<div>{words}</div>"))

    def _send(self, client: viser.ClientHandle) -> None:
        name = texts.DOWNLOAD_NAMES[self._download.value]
        take = next((t for t in self._desk.state.takes if _words(t) == self._take.value), None)
        if take is None or take.result is None:
            self._desk.say(texts.FAILED, texts.INSPECT_NONE, wrong=True)
            return
        path = self._station.store.results_folder(take.result.id) / name
        client.send_file_download(f"take-{take.id}-{take.said.side}-{name}", path.read_bytes(), save_immediately=True)


def measurement_table(measurements: Mapping[str, Mapping[str, Any]]) -> str:
    """All measurements with intervals and marks; a definition from the glossary is shown on hover."""
    rows = "".join(_row(name, value) for name, value in measurements.items())
    return f'<table style="width:100%;text-align:left;font-size:12.5px">{texts.MEASURE_HEAD}{rows}</table>'


def _row(name: str, value: Mapping[str, Any]) -> str:
    interval, number = value["interval"], value["value"]
    shown = "-" if number is None else f"{number:.1f} {value['unit'] if value['unit'] != '1' else ''}"
    span = "" if interval is None else f"{interval[0]:.1f} to {interval[1]:.1f}"
    mark = "" if value["reliable"] else f'<span title="{html.escape(str(value["reason"]))}">⚠</span>'
    mark += f'<span title="{html.escape(str(value["unusual"]))}">❗</span>' if value["unusual"] else ""
    meaning = html.escape(texts.GLOSSARY.get(name, str(value["reason"])))
    words = html.escape(name.replace("_", " "))
    return f'<tr><td title="{meaning}">{words}</td><td>{shown}</td><td>{span}</td><td>{mark}</td></tr>'


def _words(take: Take) -> str:
    day = take.said.recorded.astimezone().strftime("%Y-%m-%d %H:%M")
    used = f", {texts.IN_USE}" if take.in_use else ""
    return f"{texts.SIDES[take.said.side]} {day}{used}  #{take.id}"


def _take_id(words: str) -> int | None:
    number = words.rpartition("#")[2]
    return int(number) if number.isdigit() else None


def _box(content: str) -> str:
    return f'<div style="padding:2px 1em;font-size:13.5px">{content}</div>'
