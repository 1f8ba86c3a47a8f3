"""The Inspect tab: a foot to turn, maps with a legend, a section at any plane, measurements, downloads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import viser

from footscan.coordinates import Floats
from footscan.errors import FootscanError, MeshError
from footscan.gui import texts
from footscan.gui.binding import on_press, on_value, put, put_options
from footscan.gui.fold import Fold
from footscan.gui.inspected import InspectedFoot, cut_at, open_foot, outlines_svg, try_smoothing
from footscan.gui.legend import legend_html
from footscan.gui.measurement_tables import comparison_table, measurement_table, measurements_csv, price_table
from footscan.gui.state import InspectChoice, PageState
from footscan.gui.tab import Tools
from footscan.gui.view_foot import LOOK_AT, aside_mm
from footscan.records import Take
from footscan.scanning.session.states import Snapshot

if TYPE_CHECKING:
    from footscan.foot.sections import Section

_KEPT_FEET = 4


class InspectTab:
    """Handles of the tab, and the feet it has opened."""

    def __init__(self, tools: Tools) -> None:
        gui = tools.server.gui
        self._desk, self._station, self._view = tools.desk, tools.station, tools.view
        self._feet: dict[int, InspectedFoot] = {}
        self._drawn: tuple[Any, ...] | None = None
        self._cut: tuple[Any, ...] | None = None
        self._beside_it: InspectedFoot | None = None
        self._take = gui.add_dropdown(texts.TAKE, (texts.FOOT_NONE,))
        self._shown = gui.add_dropdown(texts.SHOW, texts.SHOW_KINDS, hint=texts.SHOW_HINT)
        self._beside = gui.add_checkbox(texts.OTHER_FOOT, False, hint=texts.OTHER_FOOT_HINT)
        self._look = gui.add_button_group(texts.LOOK, tuple(texts.LOOK_FROM), hint=texts.LOOK_HINT)
        self._legend = gui.add_html("")
        with gui.add_folder(texts.SECTION):
            self._share = gui.add_slider(texts.SECTION_SHARE, 0, 100, 1, 50, hint=texts.SECTION_SHARE_HINT)
            self._turn = gui.add_slider(texts.SECTION_TURN, -90, 90, 1, 0, hint=texts.SECTION_TURN_HINT)
            self._tilt = gui.add_slider(texts.SECTION_TILT, -90, 90, 1, 0, hint=texts.SECTION_TILT_HINT)
            self._section = gui.add_html("")
        with gui.add_folder(texts.MEASUREMENTS):
            self._table = gui.add_html("")
        with Fold(gui, tools.desk, texts.SMOOTHING).inside:
            gui.add_html(_box(texts.SMOOTHING_WORDS))
            self._filter = gui.add_slider(texts.FILTER, 0.0, 1.0, 0.1, 0.5, hint=texts.FILTER_HINT)
            self._smooth = gui.add_slider(texts.SMOOTH, 0.0, 30.0, 1.0, 10.0, hint=texts.SMOOTH_HINT)
            self._try = gui.add_button(texts.SMOOTH_GO, hint=texts.SMOOTH_GO_HINT)
            self._price = gui.add_html("")
            self._back = gui.add_button(texts.SMOOTH_BACK, hint=texts.SMOOTH_BACK_HINT, visible=False)
        with gui.add_folder(texts.DOWNLOADS):
            self._downloads = [
                gui.add_button_group(kind, tuple(names), hint=texts.DOWNLOAD_HINTS[kind])
                for kind, names in texts.DOWNLOAD_NAMES.items()
            ]
        self._bind()

    def _bind(self) -> None:
        desk = self._desk
        on_value(desk, self._take, lambda words: self._choose(take_id=_take_id(words), tried=None))
        on_value(desk, self._shown, lambda shown: self._choose(shown=shown))
        on_value(desk, self._beside, lambda beside: self._choose(beside=beside))
        on_value(desk, self._share, lambda percent: self._choose(share=percent / 100.0))
        on_value(desk, self._turn, lambda degrees: self._choose(turn_deg=float(degrees)))
        on_value(desk, self._tilt, lambda degrees: self._choose(tilt_deg=float(degrees)))
        on_press(desk, self._try, lambda _: self._try_smoothing())
        on_press(desk, self._back, lambda _: self._choose(tried=None))
        on_press(desk, self._look, self._look_from)
        for group, names in zip(self._downloads, texts.DOWNLOAD_NAMES.values(), strict=True):
            on_press(desk, group, lambda client, group=group, names=names: self._send(client, names[group.value]))

    def _choose(self, **values: Any) -> None:
        state = self._desk.state
        self._desk.change(inspect=replace(state.inspect, **values), last=replace(state.last, hidden=True))

    def _look_from(self, client: viser.ClientHandle) -> None:
        client.camera.position, client.camera.look_at = texts.LOOK_FROM[str(self._look.value)], LOOK_AT
        client.camera.up_direction = (0.0, 0.0, 1.0)

    def tick(self, snapshot: Snapshot) -> None:
        """Nothing here moves."""

    def show(self, state: PageState) -> None:
        """What the desk says."""
        takes = measured_takes(state)
        options = tuple(words_of_take(take) for take in takes) or (texts.FOOT_NONE,)
        chosen = next((take for take in takes if take.id == state.inspect.take_id), takes[0] if takes else None)
        put_options(self._take, options, options[0] if chosen is None else words_of_take(chosen))
        put(self._shown, value=state.inspect.shown)
        put(self._beside, value=state.inspect.beside)
        busy = state.job is not None
        put(self._try, disabled=busy or chosen is None)
        tried = state.inspect.tried
        put(self._back, visible=tried is not None)
        put(self._price, content="" if tried is None else _box(price_table(tried.words, tried.price)))
        foot = None if chosen is None else self._open(chosen)
        if foot is not None and tried is not None and tried.take_id == foot.take.id:
            foot = tried.foot
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

    def _try_smoothing(self) -> None:
        take = next((take for take in self._desk.state.takes if words_of_take(take) == self._take.value), None)
        from footscan.workflow.foot import FootSettings

        foot = None if take is None else self._open(take)
        if foot is None:
            self._desk.say(texts.FAILED, texts.INSPECT_NONE, wrong=True)
            return
        settings = FootSettings(float(self._filter.value), float(self._smooth.value))
        if settings == FootSettings():
            self._desk.say(texts.FAILED, texts.SMOOTH_NOTHING, wrong=True)
            return
        self._desk.job(
            texts.JOB_SMOOTH,
            lambda progress: try_smoothing(foot, settings),
            lambda tried: self._choose(tried=tried),
            keeps_nothing=True,
        )

    def _draw(self, state: PageState, takes: list[Take], foot: InspectedFoot | None) -> None:
        """The feet, the legend and the table, when something about them is new."""
        choice = state.inspect
        running = state.job is not None and state.job.words in (texts.JOB_CHECK, texts.JOB_SCAN)
        preparing = running or state.step == "checked"  # the place is the next foot's
        other = None if foot is None or not choice.beside else self._other(takes, foot)
        feet = [] if foot is None or preparing else [foot] if other is None else [foot, other]
        now = (tuple(id(each) for each in feet), choice.shown)
        if now == self._drawn:
            return
        self._drawn = now
        if feet:
            self._view.hide_cloud()
            self._view.clear_placement()
        self._view.show_feet({each.take.said.side: each.mesh for each in feet}, choice.shown)
        self._beside_it = other
        legend = {"Seen / assumed": texts.LEGEND_ORIGIN, "Distance to points": texts.LEGEND_RESIDUAL}
        missing = f"<div>{texts.OTHER_FOOT_NONE}</div>" if choice.beside and foot is not None and other is None else ""
        put(self._legend, content=_box(missing + legend_html(legend.get(choice.shown, ()))))
        put(self._table, content=_box(_table_of(foot, other)))

    def _other(self, takes: list[Take], foot: InspectedFoot) -> InspectedFoot | None:
        others = [take for take in takes if take.said.side != foot.take.said.side]
        best = next((take for take in others if take.in_use), others[0] if others else None)
        return None if best is None else self._open(best)

    def _draw_section(self, choice: InspectChoice, foot: InspectedFoot | None) -> None:
        now = (id(foot), choice.share, choice.turn_deg, choice.tilt_deg, choice.beside, self._drawn)
        if now == self._cut:
            return
        self._cut = now
        if foot is None or not self._drawn or not self._drawn[0]:
            self._view.show_section(())
            put(self._section, content=_box(texts.INSPECT_NONE if foot is None else ""))
            return
        feet = [foot] if self._beside_it is None else [foot, self._beside_it]
        try:
            cuts = [(each, cut_at(each, choice.share, choice.turn_deg, choice.tilt_deg)) for each in feet]
        except MeshError:
            self._view.show_section(())
            put(self._section, content=_box(texts.SECTION_MISSES))
            return
        self._view.show_section([line for each, cut in cuts for line in _in_place(each, cut, len(cuts))])
        put(self._section, content=_box(outlines_svg(cuts) + section_words(cuts)))

    def _send(self, client: viser.ClientHandle, name: str) -> None:
        take = next((take for take in self._desk.state.takes if words_of_take(take) == self._take.value), None)
        foot = None if take is None else self._open(take)
        if foot is None:
            self._desk.say(texts.FAILED, texts.INSPECT_NONE, wrong=True)
            return
        table = name == texts.DOWNLOAD_NAMES["Values"][texts.DOWNLOAD_TABLE]
        content = measurements_csv(foot.measurements) if table else (foot.folder / name).read_bytes()
        file_name = f"take-{foot.take.id}-{foot.take.said.side}-{name}"
        client.send_file_download(file_name, content, save_immediately=True)


def _table_of(foot: InspectedFoot | None, other: InspectedFoot | None) -> str:
    if foot is None:
        return texts.INSPECT_NONE
    if other is None:
        return measurement_table(foot.measurements)
    left, right = (foot, other) if foot.take.said.side == "left" else (other, foot)
    return comparison_table(left.measurements, right.measurements)


def _in_place(foot: InspectedFoot, cut: Section, feet: int) -> list[Floats]:
    """The lines of a cut where the foot is drawn."""
    shift = np.array([0.0, aside_mm(foot.take.said.side) if feet > 1 else 0.0, 0.0])
    return [line + shift for line in cut.polylines]


def section_words(cuts: Sequence[tuple[InspectedFoot, Section]]) -> str:
    """What was measured in a cut; of both feet, each with its name and the kind of its line."""
    words: list[str] = []
    for (foot, cut), line in zip(cuts, texts.COMPARE_LINES, strict=False):
        unseen = cut.hull_unseen_share
        figures = texts.SECTION_TABLE.format(
            area=cut.area_mm2 / 100.0,
            perimeter=cut.perimeter_mm,
            tape=cut.hull_perimeter_mm,
            width=cut.width_mm,
            height=cut.height_mm,
            unseen=texts.SECTION_UNSEEN.format(share=unseen) if unseen else "",
        )
        side = texts.COMPARE_SECTION.format(side=texts.SIDES[foot.take.said.side], line=line) if len(cuts) > 1 else ""
        words.append(f"<div>{side}{figures}</div>")
    return "".join(words)


def words_of_take(take: Take) -> str:
    """How a take stands in a list."""
    day = take.said.recorded.astimezone().strftime("%Y-%m-%d %H:%M")
    used = f", {texts.IN_USE}" if take.in_use else ""
    return f"{texts.SIDES[take.said.side]} {day}{used}  #{take.id}"


def measured_takes(state: PageState) -> list[Take]:
    """Takes with a foot that can be looked at."""
    return [take for take in state.takes if take.result is not None and not take.result.refused]


def _take_id(words: str) -> int | None:
    number = words.rpartition("#")[2]
    return int(number) if number.isdigit() else None


def _box(content: str) -> str:
    return f'<div style="padding:2px 1em;font-size:13.5px">{content}</div>'
