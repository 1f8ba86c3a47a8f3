"""The Calibrate tab: the guided procedure at the machine, its residuals, and whether the new one comes into force."""

import html
from collections.abc import Callable
from datetime import datetime

import viser

from footscan.config import DEFAULT_BOARD
from footscan.gui import texts
from footscan.gui.binding import ask, on_press, put, put_options
from footscan.gui.fold import Fold
from footscan.gui.state import CalibrationChoice, PageState
from footscan.gui.station import Station
from footscan.gui.tab import Tools
from footscan.scanning.session.states import Snapshot, State
from footscan.workflow.calibration_log import machine_name


class CalibrateTab:
    """Handles of the tab."""

    def __init__(self, tools: Tools) -> None:
        gui = tools.server.gui
        self._desk, self._station, self._work = tools.desk, tools.station, tools.calibration
        self._in_force = gui.add_html("")
        gui.add_html(_box(texts.BOARD_WORDS))
        self._row = _length(gui, texts.BOARD_ROW, DEFAULT_BOARD.squares_x)
        self._column = _length(gui, texts.BOARD_COLUMN, DEFAULT_BOARD.squares_y)
        with gui.add_folder(texts.CALIBRATE_RECORD):
            self._advice = gui.add_html("")
            self._print = gui.add_button(texts.BOARD_PRINT, hint=texts.BOARD_PRINT_HINT, color="gray")
            self._begin = gui.add_button(texts.CALIBRATE_BEGIN, hint=texts.CALIBRATE_BEGIN_HINT)
            self._record = gui.add_button(texts.CALIBRATE_PLACE, hint=texts.CALIBRATE_PLACE_HINT, visible=False)
            self._shown = gui.add_html("")
            self._finish = gui.add_button(texts.CALIBRATE_FINISH, hint=texts.CALIBRATE_FINISH_HINT, visible=False)
            self._abandon = gui.add_button(
                texts.CALIBRATE_ABANDON, hint=texts.CALIBRATE_ABANDON_HINT, color="gray", visible=False
            )
        with gui.add_folder(texts.CALIBRATE_RESULT):
            self._lines = gui.add_html("")
            self._accept = gui.add_button(
                texts.CALIBRATE_ACCEPT, hint=texts.CALIBRATE_ACCEPT_HINT, color="green", visible=False
            )
            self._keep = gui.add_button(texts.CALIBRATE_KEEP, hint=texts.CALIBRATE_KEEP_HINT, visible=False)
        with Fold(gui, tools.desk, texts.CALIBRATE_AGAIN).inside:
            self._recording = gui.add_dropdown(texts.CALIBRATE_RECORDING, (texts.CALIBRATE_NONE,))
            self._compute = gui.add_button(texts.CALIBRATE_GO, hint=texts.CALIBRATE_HINT)
        self._bind()

    def _bind(self) -> None:
        desk, work = self._desk, self._work
        on_press(desk, self._begin, lambda client: self._armed(client, texts.CALIBRATE_BARE, work.begin))
        on_press(desk, self._print, self._send_board)
        on_press(desk, self._record, lambda client: self._armed(client, texts.CALIBRATE_STANDS, work.record_placement))
        on_press(desk, self._finish, lambda _: self._measured(work.finish))
        on_press(desk, self._abandon, self._ask_abandon)
        on_press(desk, self._accept, self._ask_accept)
        on_press(desk, self._keep, lambda _: work.keep_old())
        on_press(desk, self._compute, lambda _: self._compute_chosen())

    def _armed(self, client: viser.ClientHandle, ready: str, act: Callable[[], None]) -> None:
        if self._desk.state.job is not None:
            self._desk.say(texts.WORKING, texts.BUSY, wrong=True)
            return
        if self._station.session.snapshot().state is State.CLOSED:
            self._desk.say(texts.FAILED, texts.MACHINE_CLOSED, wrong=True)
            return
        body = f"{ready}\n\n{texts.ARM_QUESTION}"
        ask(self._desk, client, texts.ARM_TITLE, body, texts.CALIBRATE_YES, texts.ARM_NO, act)

    def _send_board(self, client: viser.ClientHandle) -> None:
        from footscan.calibration.board_sheet import draw_board

        self._desk.job(
            texts.JOB_BOARD,
            lambda progress: draw_board(DEFAULT_BOARD),
            lambda pdf: client.send_file_download(texts.BOARD_FILE, pdf, save_immediately=True),
            keeps_nothing=True,
        )

    def _ask_abandon(self, client: viser.ClientHandle) -> None:
        ask(
            self._desk,
            client,
            texts.CALIBRATE_ABANDON,
            texts.CALIBRATE_ABANDON_SURE,
            texts.CALIBRATE_ABANDON,
            texts.ARM_NO,
            self._work.abandon,
        )

    def _ask_accept(self, client: viser.ClientHandle) -> None:
        ask(
            self._desk,
            client,
            texts.CALIBRATE_ACCEPT,
            texts.CALIBRATE_ACCEPT_SURE,
            texts.CALIBRATE_ACCEPT,
            texts.ARM_NO,
            self._work.accept,
        )

    def _compute_chosen(self) -> None:
        folder = next((path for path in self._work.recordings() if path.name == self._recording.value), None)
        if folder is None:
            self._desk.say(texts.FAILED, texts.CALIBRATE_NONE, wrong=True)
            return
        self._measured(lambda measured_mm: self._work.compute(folder, measured_mm))

    def _measured(self, act: Callable[[tuple[float, float] | None], None]) -> None:
        """Go on with the lengths of the board as somebody measured them."""
        row_mm, column_mm = float(self._row.value), float(self._column.value)
        if (row_mm > 0.0) != (column_mm > 0.0):
            self._desk.say(texts.FAILED, texts.BOARD_BOTH, wrong=True)
            return
        act((row_mm, column_mm) if row_mm > 0.0 else None)

    def tick(self, snapshot: Snapshot) -> None:
        """Progress stands beside STOP."""

    def show(self, state: PageState) -> None:
        """What the desk says."""
        choice, busy, recording = state.calibration, state.job is not None, self._work.recording
        put(self._in_force, content=_box(_in_force(self._station)))
        put(self._advice, content=_box(_advice(choice, recording, self._station)))
        put(self._print, visible=not recording, disabled=busy)
        put(self._shown, content=_box(placements_html(choice)))
        put(self._begin, visible=not recording, disabled=busy)
        put(self._record, visible=recording, disabled=busy)
        put(self._finish, visible=recording, disabled=busy or not self._work.can_finish)
        put(self._abandon, visible=recording, disabled=busy)
        put(self._lines, content=_box(_result(choice)))
        put(self._accept, visible=choice.made is not None, disabled=busy)
        put(self._keep, visible=choice.made is not None, disabled=busy)
        names = tuple(path.name for path in self._work.recordings()) or (texts.CALIBRATE_NONE,)
        put_options(self._recording, names, self._recording.value if self._recording.value in names else names[0])
        put(self._compute, disabled=busy or recording or names == (texts.CALIBRATE_NONE,))


def _length(gui: viser.GuiApi, label: str, squares: int) -> viser.GuiInputHandle[float]:
    hint = texts.BOARD_HINT.format(nominal=squares * DEFAULT_BOARD.square_mm)
    return gui.add_number(label, 0.0, min=0.0, max=25000.0, step=0.01, hint=hint)


def _in_force(station: Station) -> str:
    notes = "".join(f"<li>{html.escape(doubt.sentence)}</li>" for doubt in station.doubts)
    words = f"{texts.CALIBRATE_IN_FORCE} {_made(station)}"
    return f"{words}<ul style='margin:0'>{notes}</ul>" if notes else words


def _made(station: Station) -> str:
    """Of which machine it is and when it was made; where it lies is shown on hover."""
    calibration, where = station.calibration, html.escape(station.calibration_words)
    if calibration is None or station.calibration_days() is None:
        return where
    made = datetime.fromisoformat(calibration.created).astimezone().strftime("%Y-%m-%d %H:%M")
    words = texts.CALIBRATE_MADE.format(machine=html.escape(machine_name(calibration)), day=made)
    return f'<span title="{where}">{words}</span>'


def _advice(choice: CalibrationChoice, recording: bool, station: Station) -> str:
    if not recording:
        return texts.CALIBRATE_INTRO
    number = len(choice.placements)
    simulated = f"<br><i>{texts.CALIBRATE_SIMULATED}</i>" if station.opened.put_calibration_board is not None else ""
    return f"{texts.CALIBRATE_ADVICE.format(number=number + 1, placed=html.escape(choice.advice))}{simulated}"


def placements_html(choice: CalibrationChoice) -> str:
    """What each placement showed, and whether it is enough while that still is a question."""
    lines = "".join(f"<li>{html.escape(report.sentence())}</li>" for report in choice.placements)
    expected = f"<b>{html.escape(choice.expected)}</b>" if choice.expected else ""
    enough = f"<br>{texts.CALIBRATE_ENOUGH}" if choice.enough and not choice.recorded else ""
    head = texts.CALIBRATE_RECORDED if choice.recorded else ""
    return f"{head}<ul style='margin:0;padding-left:1.2em'>{lines}</ul>{expected}{enough}" if lines else ""


def _result(choice: CalibrationChoice) -> str:
    if not choice.lines:
        return texts.CALIBRATE_EMPTY
    lines = "".join(f"<div style='margin-bottom:4px'>{html.escape(line)}</div>" for line in choice.lines)
    return f"<b>{texts.CALIBRATE_NEW}</b>{lines}" if choice.made is not None else lines


def _box(content: str) -> str:
    return f'<div style="padding:2px 1em;font-size:13.5px">{content}</div>'
