"""The Last tab: lasts ranked for a foot, one laid round it, customised with its proof, and taken away as a file."""

from __future__ import annotations

import io
import tempfile
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import viser

from footscan.errors import FootscanError
from footscan.gui import texts
from footscan.gui.binding import on_press, on_value, put, put_options
from footscan.gui.inspected import InspectedFoot, open_foot
from footscan.gui.last_choice import LastChoice
from footscan.gui.last_tables import proof_words, ranking_table, room_tables
from footscan.gui.legend import legend_html
from footscan.gui.state import PageState
from footscan.gui.tab import Tools
from footscan.gui.tab_inspect import measured_takes, words_of_take
from footscan.gui.view_last import LastView
from footscan.records import Take
from footscan.scanning.session.states import Snapshot
from footscan.shoelast.fitting_defaults import TRANSITION_MM, profile_names

if TYPE_CHECKING:
    from footscan.gui.fitting import Fitting
    from footscan.shoelast.custom_last import CustomLast
    from footscan.shoelast.model import Shoelast

_ENGRAVED = ("stl", "3dm")


class LastTab:
    """Handles of the tab, and the lasts it has opened."""

    def __init__(self, tools: Tools) -> None:
        gui = tools.server.gui
        self._desk, self._station = tools.desk, tools.station
        self._view = LastView(tools.server, tools.view)
        self._drawn: tuple[Any, ...] = ()
        self._foot = gui.add_dropdown(texts.LAST_FOOT, (texts.FOOT_NONE,))
        names = profile_names()
        self._profile = gui.add_dropdown(
            texts.LAST_PROFILE, names, initial_value=LastChoice().profile, hint=texts.LAST_PROFILE_HINT
        )
        self._rank = gui.add_button(texts.LAST_RANK, hint=texts.LAST_RANK_HINT)
        self._ranking = gui.add_html("")
        self._last = gui.add_dropdown(texts.LAST_CHOSEN, (texts.LAST_NONE,))
        self._picture = gui.add_image(np.full((2, 2, 3), 255, np.uint8), visible=False)
        self._compare = gui.add_button(texts.LAST_COMPARE, hint=texts.LAST_COMPARE_HINT)
        self._shown = gui.add_dropdown(texts.LAST_SHOW, texts.LAST_SHOW_KINDS)
        self._legend = gui.add_html("")
        self._hide = gui.add_button(texts.LAST_HIDE, hint=texts.LAST_HIDE_HINT, visible=False)
        self._room = gui.add_html("")
        self._add_allowances(gui)
        self._customise = gui.add_button(texts.LAST_CUSTOMISE, hint=texts.LAST_CUSTOMISE_HINT)
        with gui.add_folder(texts.LAST_RESULT):
            self._result = gui.add_html("")
        with gui.add_folder(texts.LAST_FILES):
            self._engrave = gui.add_text(texts.LAST_ENGRAVE, "", hint=texts.LAST_ENGRAVE_HINT)
            self._files = [
                gui.add_button_group(kind, tuple(names), hint=texts.LAST_FILE_HINTS[kind])
                for kind, names in texts.LAST_FILE_NAMES.items()
            ]
        self._bind()

    def _add_allowances(self, gui: viser.GuiApi) -> None:
        with gui.add_folder(texts.LAST_ALLOWANCES):
            self._transition = gui.add_slider(
                texts.LAST_TRANSITION, 6.0, 30.0, 1.0, TRANSITION_MM, hint=texts.LAST_TRANSITION_HINT
            )
            self._smooth = gui.add_slider(texts.LAST_SMOOTH, 0.0, 1.0, 0.1, 0.0, hint=texts.LAST_SMOOTH_HINT)
            self._hold = gui.add_checkbox(texts.LAST_HOLD, True, hint=texts.LAST_HOLD_HINT)
            places = tuple(texts.LAST_PLACES.values())
            self._pin_at = gui.add_dropdown(texts.LAST_PIN_AT, places, hint=texts.LAST_PIN_AT_HINT)
            self._pin_radius = gui.add_slider(texts.LAST_PIN_RADIUS, 5.0, 40.0, 1.0, 15.0)
            self._pin_extra = gui.add_slider(texts.LAST_PIN_EXTRA, -3.0, 8.0, 0.5, 2.0, hint=texts.LAST_PIN_EXTRA_HINT)
            self._pin_add = gui.add_button(texts.LAST_PIN_ADD, hint=texts.LAST_PIN_ADD_HINT)
            self._pins = gui.add_html("")
            self._pin_clear = gui.add_button(texts.LAST_PIN_CLEAR, color="gray")

    def _bind(self) -> None:
        desk = self._desk
        on_value(desk, self._foot, self._take_foot)
        on_value(desk, self._profile, lambda name: self._put(self._choice.without_last(profile=name, ranking=())))
        on_value(desk, self._last, self._take_last)
        on_value(desk, self._shown, lambda shown: self._change(shown=shown, hidden=False))
        on_press(desk, self._rank, lambda _: self._rank_lasts())
        on_press(desk, self._compare, lambda _: self._lay())
        on_press(desk, self._hide, lambda _: self._change(hidden=not self._choice.hidden))
        on_press(desk, self._pin_add, lambda _: self._set_pin())
        on_press(desk, self._pin_clear, lambda _: self._change(pins=()))
        on_press(desk, self._customise, lambda _: self._make())
        for group, names in zip(self._files, texts.LAST_FILE_NAMES.values(), strict=True):
            on_press(desk, group, lambda client, group=group, names=names: self._send(client, names[group.value]))

    @cached_property
    def _fitting(self) -> Fitting:
        from footscan.gui.fitting import Fitting

        return Fitting(self._station.data)

    @property
    def _choice(self) -> LastChoice:
        return self._desk.state.last

    def _put(self, choice: LastChoice) -> None:
        self._desk.change(last=choice)

    def _change(self, **values: Any) -> None:
        self._put(replace(self._choice, **values))

    def tick(self, snapshot: Snapshot) -> None:
        """Nothing here moves."""

    def show(self, state: PageState) -> None:
        """What the desk says."""
        choice, busy = state.last, state.job is not None
        takes = measured_takes(state)
        chosen = self._take(state)
        options = tuple(words_of_take(take) for take in takes) or (texts.FOOT_NONE,)
        put_options(self._foot, options, options[0] if chosen is None else words_of_take(chosen))
        names = tuple(one.entry.id for one in choice.ranking) or (texts.LAST_NONE,)
        put_options(self._last, names, choice.last_id if choice.last_id in names else names[0])
        ranked = ranking_table(choice.ranking, choice.last_id) if takes else texts.LAST_FOOT_NONE
        put(self._ranking, content=_box(ranked))
        put(self._shown, value=choice.shown)
        put(self._rank, disabled=busy or chosen is None)
        ready = not busy and chosen is not None and bool(choice.ranking)
        for button in (self._compare, self._customise):
            put(button, disabled=not ready)
        hide = texts.LAST_UNHIDE if choice.hidden else texts.LAST_HIDE
        put(self._hide, visible=choice.fitted is not None or choice.custom is not None, label=hide)
        put(self._pin_add, disabled=chosen is None)
        put(self._pin_clear, disabled=not choice.pins)
        put(
            self._room,
            content="" if choice.fitted is None else _box(room_tables(choice.fitted.comparison, choice.fitted.last_id)),
        )
        words = ", ".join(f"{pin.why} {pin.extra_mm:+g} mm over {pin.radius_mm:g} mm" for pin in choice.pins)
        pins = texts.LAST_PINS.format(count=len(choice.pins), words=words) if choice.pins else texts.LAST_PINS_NONE
        put(self._pins, content=_box(pins))
        result = texts.LAST_RESULT_NONE if choice.custom is None else proof_words(choice.custom)
        put(self._result, content=_box(result))
        self._draw(choice)

    def _draw(self, choice: LastChoice) -> None:
        now = (id(choice.fitted), id(choice.custom), choice.shown, choice.hidden, choice.thumbnail)
        if now == self._drawn:
            return
        self._drawn = now
        put(self._legend, content=_box(_legend(choice)))
        self._picture.visible = bool(choice.thumbnail)
        if choice.thumbnail:
            from matplotlib import image

            picture = image.imread(io.BytesIO(choice.thumbnail))[..., :3]
            self._picture.image = np.round(255 * picture).astype(np.uint8)
        self._view.show(choice)

    def _take(self, state: PageState) -> Take | None:
        takes = measured_takes(state)
        wanted = next((take for take in takes if take.id == state.last.take_id), None)
        return wanted or next((take for take in takes if take.in_use), takes[0] if takes else None)

    def _opened(self) -> InspectedFoot | None:
        take = self._take(self._desk.state)
        if take is None:
            self._desk.say(texts.FAILED, texts.LAST_FOOT_NONE, wrong=True)
            return None
        try:
            return open_foot(self._station, take)
        except FootscanError as err:
            self._desk.say(texts.FAILED, str(err), wrong=True)
            return None

    def _take_foot(self, words: str) -> None:
        take = next((take for take in measured_takes(self._desk.state) if words_of_take(take) == words), None)
        if take is not None:
            self._put(LastChoice(take.id, self._choice.profile))

    def _take_last(self, last_id: str) -> None:
        if last_id != texts.LAST_NONE:
            self._put(self._choice.without_last(last_id=last_id, thumbnail=self._thumbnail(last_id)))

    def _thumbnail(self, last_id: str) -> bytes:
        from footscan.workflow.lasts_pictures import thumbnail_png

        return thumbnail_png(self._fitting.shelf.load(last_id))

    def _rank_lasts(self) -> None:
        foot, profile = self._opened(), self._choice.profile
        if foot is None:
            return

        def work(progress: Any) -> LastChoice:
            ranking = self._fitting.ranking(foot, profile)
            best = ranking[0].entry.id
            choice = self._choice.without_last(ranking=ranking, last_id=best, take_id=foot.take.id)
            return replace(choice, thumbnail=self._thumbnail(best))

        self._desk.job(texts.JOB_RANK, work, self._put, keeps_nothing=True)

    def _lay(self) -> None:
        foot, choice = self._opened(), self._choice
        if foot is None:
            return
        self._desk.job(
            texts.JOB_FIT,
            lambda progress: self._fitting.fitted(foot, choice.last_id, choice.profile),
            lambda fitted: self._change(fitted=fitted, custom=None, hidden=False, shown=_unchanged(self._choice)),
            keeps_nothing=True,
        )

    def _set_pin(self) -> None:
        foot = self._opened()
        if foot is None:
            return
        words = str(self._pin_at.value)
        place = next(name for name, shown in texts.LAST_PLACES.items() if shown == words)
        pin = self._fitting.pin_at(foot, place, float(self._pin_radius.value), float(self._pin_extra.value), words)
        self._change(pins=(*self._choice.pins, pin))

    def _make(self) -> None:
        foot, choice = self._opened(), self._choice
        if foot is None:
            return
        from footscan.shoelast.customise import CustomSettings

        settings = CustomSettings(
            float(self._transition.value),
            hold=bool(self._hold.value),
            pins=choice.pins,
            smooth_mm=float(self._smooth.value),
        )
        self._desk.job(
            texts.JOB_CUSTOMISE,
            lambda progress: self._fitting.customised(foot, choice.last_id, choice.profile, settings, progress),
            self._show_made,
            keeps_nothing=True,
        )

    def _show_made(self, custom: CustomLast) -> None:
        self._change(custom=custom, hidden=False, shown="Changed areas")
        self._desk.say(texts.LAST_MADE, texts.LAST_MADE_HOLDS if custom.proof.holds else texts.LAST_MADE_NOT)

    def _send(self, client: viser.ClientHandle, kind: str) -> None:
        """Write the customised last, or the chosen one, and hand it to the browser."""
        choice = self._choice
        if choice.custom is None and not choice.last_id:
            self._desk.say(texts.FAILED, texts.LAST_NONE, wrong=True)
            return
        engrave = str(self._engrave.value).strip() if kind in _ENGRAVED else ""
        name = f"{choice.last_id}{'' if choice.custom is None else '-customised'}.{kind}"

        def work(progress: Any) -> bytes:
            shoelast = self._fitting.shelf.load(choice.last_id) if choice.custom is None else choice.custom.shoelast
            return _file_of(shoelast, name, engrave)

        self._desk.job(
            texts.JOB_EXPORT,
            work,
            lambda content: client.send_file_download(name, content, save_immediately=True),
            keeps_nothing=True,
        )


def _legend(choice: LastChoice) -> str:
    """Of what the 3-D view shows now."""
    if choice.hidden or (choice.fitted is None and choice.custom is None):
        return ""
    if choice.custom is not None and choice.shown == "Changed areas":
        return legend_html(texts.LAST_LEGEND_CHANGED)
    return legend_html(texts.LAST_LEGEND if choice.shown == "Clearance map" else texts.LAST_LEGEND_ROUND)


def _unchanged(choice: LastChoice) -> str:
    return "Last round the foot" if choice.shown == "Changed areas" else choice.shown


def _file_of(shoelast: Shoelast, name: str, engrave: str) -> bytes:
    from footscan.workflow.lasts_export import ExportWish, export_last

    with tempfile.TemporaryDirectory(prefix="footscan-last-") as folder:
        return export_last(shoelast, Path(folder) / name, ExportWish(engrave=engrave)).files[0].read_bytes()


def _box(content: str) -> str:
    return f'<div style="padding:2px 1em;font-size:13.5px">{content}</div>'
