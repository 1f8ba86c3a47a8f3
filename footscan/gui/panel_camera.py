"""The camera panel: the live picture, the threshold slider, exposure and profile."""

from dataclasses import replace
from typing import Any

import numpy as np
import viser
from viser import uplot

from footscan.coordinates import Frame, LaserName
from footscan.gui import texts
from footscan.gui.binding import on_value, put
from footscan.gui.desk import Desk
from footscan.gui.live_picture import KINDS, LivePicture, brightness_curve, draw_live, row_curve
from footscan.gui.state import CameraChoice, PageState
from footscan.gui.station import Station
from footscan.gui.visit_scan import ScanWork
from footscan.scanning.stripe import StripeFinder

_HOLD_HZ = 10.0
_CURVES_EVERY = 4
_WORDS = "font-size:13px;line-height:20px;min-height:40px;padding:0 1em"
"""Of two lines, whatever they say: the button below must not move from under the finger that holds it."""


class CameraPanel:
    """Handles of the panel, and what they show.

    Attributes:
        shown_points: Stripe points in the picture that is shown.
    """

    def __init__(self, server: viser.ViserServer, desk: Desk, station: Station, scan: ScanWork) -> None:
        self._desk, self._station, self._scan = desk, station, scan
        self._finder = StripeFinder()
        self._drawn: tuple[int, CameraChoice] | None = None
        self.shown_points = 0
        self._turn = 0
        gui, facts = server.gui, station.rig.scanner.camera
        blank = np.full((facts.height_px, facts.width_px, 3), 40, np.uint8)
        self._image = gui.add_image(blank, format="jpeg", jpeg_quality=80)
        self._kind = gui.add_button_group(texts.PICTURE, KINDS)
        self._automatic = gui.add_checkbox(texts.AUTOMATIC, True, hint=texts.AUTOMATIC_HINT)
        self._threshold = gui.add_slider(texts.THRESHOLD, 1, 254, 1, 60, hint=texts.THRESHOLD_HINT)
        self._words = gui.add_html("")
        self._laser = gui.add_button_group(texts.SHINE_LASER, texts.LASERS)
        self._shine = gui.add_button(texts.SHINE, hint=texts.SHINE_HINT, icon=viser.Icon.BULB)
        self._fold = gui.add_folder(texts.EXPOSURE, expand_by_default=True)
        with self._fold:
            grey, count = brightness_curve(blank[:, :, 0])
            self._brightness = _plot(gui, grey, count, texts.EXPOSURE_TITLE)
            self._row = gui.add_slider(texts.ROW, 0, facts.height_px - 1, 1, facts.height_px // 2, hint=texts.ROW_HINT)
            column, level = row_curve(blank[:, :, 0], 0)
            self._profile = _plot(gui, column, level, texts.PROFILE_TITLE)
        self._bind()

    @property
    def threshold_uuid(self) -> str:
        """Of the slider's element in the page."""
        return self._threshold._impl.uuid  # pyright: ignore[reportPrivateUsage]

    def _bind(self) -> None:
        def choose(**values: Any) -> None:
            self._desk.change(camera=replace(self._desk.state.camera, **values))

        on_value(self._desk, self._kind, lambda kind: choose(kind=kind))
        on_value(self._desk, self._automatic, lambda automatic: choose(automatic=automatic))
        on_value(self._desk, self._threshold, lambda value: choose(threshold=int(value), automatic=False))
        on_value(self._desk, self._row, lambda row: choose(row=int(row)))
        on_value(self._desk, self._laser, lambda words: choose(laser=_laser(words)))

        @self._shine.on_hold(callback_hz=_HOLD_HZ)
        async def _(_: Any) -> None:
            self._desk.post(self._scan.hold_light)

    def show(self, state: PageState) -> None:
        """What the desk says."""
        camera = state.camera
        put(self._automatic, value=camera.automatic)
        put(self._kind, label=texts.CHOSEN.format(what=texts.PICTURE, chosen=camera.kind))
        laser = texts.LASERS[0] if camera.laser == "right" else texts.LASERS[1]
        put(self._laser, label=texts.CHOSEN.format(what=texts.SHINE_LASER, chosen=laser))
        self._show_shine()

    def _show_shine(self) -> None:
        """No light without somebody having looked whether a face is there."""
        put(self._shine, disabled=self._desk.state.job is not None or not self._station.session.snapshot().armed)

    def tick(self) -> None:
        """Draw the newest frame, if it or the choice is new."""
        self._show_shine()
        newest, choice = self._station.session.grabber.latest, self._desk.state.camera
        if newest is None or self._drawn == (newest.number, choice):
            return
        self._drawn = (newest.number, choice)
        lit = bool(self._station.session.snapshot().lasers) or not choice.automatic
        kind = choice.kind if lit else "Grey"
        picture = draw_live(newest.frame, kind, choice.in_use, self._finder, choice.row)
        self._image.image = picture.rgb
        self.shown_points = picture.points if lit else 0
        self._tell(picture, choice, lit)
        self._turn += 1
        if self._turn % _CURVES_EVERY == 0:
            self._draw_curves(newest.frame, choice)

    def _tell(self, picture: LivePicture, choice: CameraChoice, lit: bool) -> None:
        """An automatic threshold of a picture without laser light would be that of its noise."""
        used = picture.automatic if choice.automatic else choice.threshold
        words = texts.AUTOMATIC_VALUE.format(value=picture.automatic, used=used, points=picture.points)
        words = words if lit else texts.NO_LIGHT
        put(self._words, content=f'<div style="{_WORDS}">{words}</div>')

    def _draw_curves(self, frame: Frame, choice: CameraChoice) -> None:
        self._brightness.data = brightness_curve(frame)
        row = frame.shape[0] // 2 if choice.row is None else min(choice.row, frame.shape[0] - 1)
        self._profile.data = row_curve(frame, row)


def _plot(gui: viser.GuiApi, x: Any, y: Any, title: str) -> viser.GuiUplotHandle:
    return gui.add_uplot(
        (x, y),
        (uplot.Series(label="x"), uplot.Series(label="", stroke="#d04020", width=1)),
        title=title,
        scales={"x": uplot.Scale(time=False)},
        legend=uplot.Legend(show=False),
        height=120,
        padding=(10, 8, 0, 0),  # else the uppermost number is cut in half
    )


def _laser(words: str) -> LaserName:
    return "right" if words == texts.LASERS[0] else "left"
