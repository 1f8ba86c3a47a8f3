"""In the Patient tab: what was done with a patient's records, by whom and why; nobody can change it."""

import html
from collections.abc import Mapping, Sequence
from typing import Any

from footscan.gui import texts
from footscan.gui.binding import put
from footscan.gui.fold import Fold
from footscan.gui.state import PageState
from footscan.gui.tab import Tools
from footscan.records import AuditEntry

_MOST = 40


class History:
    """Handles of the folder; it is read anew whenever something about the patient is new."""

    def __init__(self, tools: Tools) -> None:
        gui = tools.server.gui
        self._store = tools.station.store
        self._read: tuple[Any, ...] = ()
        self._fold = Fold(gui, tools.desk, texts.HISTORY, visible=False)
        with self._fold.inside:
            self._lines = gui.add_html("")

    def show(self, state: PageState) -> None:
        """Of the chosen patient, the latest first."""
        self._fold.show(state.patient is not None)
        now = (state.patient, state.takes, state.feet)
        if state.patient is not None and now != self._read:
            self._read = now
            put(self._lines, content=history_html(self._store.audit(state.patient.id, _MOST)))


def history_html(entries: Sequence[AuditEntry]) -> str:
    """One line each: when, who, what, what it changed, and the reason."""
    lines = "".join(f'<div style="margin-bottom:3px">{_line(entry)}</div>' for entry in entries)
    return f'<div style="padding:2px 1em;font-size:12.5px;overflow-wrap:anywhere">{lines}</div>'


def _line(entry: AuditEntry) -> str:
    day = entry.at.astimezone().strftime("%Y-%m-%d %H:%M")
    words = html.escape(f"{entry.by}: {entry.action}, {entry.subject}{changes_words(entry.detail)}")
    reason = f" <i>({html.escape(entry.reason)})</i>" if entry.reason else ""
    return f'<span style="color:#666">{day}</span> {words}{reason}'


def changes_words(detail: Mapping[str, Any]) -> str:
    """What a correction changed, from and to, or how a take was judged; empty for other lines."""
    if detail.get("verdict") in texts.VERDICTS:
        return f": {texts.VERDICTS[detail['verdict']]}"
    before, after = detail.get("before"), detail.get("after")
    if not isinstance(before, Mapping) or not isinstance(after, Mapping):
        return ""
    changed = [(name, before[name], after.get(name)) for name in before if before[name] != after.get(name)]
    words = ", ".join(f"{texts.HISTORY_OF.get(name, name)} {_word(old)} → {_word(new)}" for name, old, new in changed)
    return f": {words}" if words else ""


def _word(value: Any) -> str:
    if isinstance(value, bool):
        return texts.YES if value else texts.NO
    return f"#{value}" if isinstance(value, int) else texts.LOADS.get(value, str(value))
