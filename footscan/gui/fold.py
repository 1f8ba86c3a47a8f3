"""A heading to press, and what it opens: viser's own folders cannot be opened from the keyboard."""

from __future__ import annotations

import viser

from footscan.gui.binding import on_press, put
from footscan.gui.desk import Desk


class Fold:
    """Closed at first; opened and closed for all browsers.

    Attributes:
        inside: A context: what is made in it stands below the heading.
    """

    def __init__(self, gui: viser.GuiApi, desk: Desk, label: str, visible: bool = True) -> None:
        self._visible, self._open = visible, False
        self._heading = gui.add_button(label, icon=viser.Icon.CHEVRON_RIGHT, color="gray", visible=visible)
        self.inside = gui.add_folder(None, visible=False)
        on_press(desk, self._heading, lambda _: self._turn())

    def show(self, visible: bool) -> None:
        """Whether there is anything to open."""
        self._visible = visible
        put(self._heading, visible=visible)
        put(self.inside, visible=visible and self._open)

    def _turn(self) -> None:
        self._open = not self._open
        put(self._heading, icon=viser.Icon.CHEVRON_DOWN if self._open else viser.Icon.CHEVRON_RIGHT)
        self.show(self._visible)
