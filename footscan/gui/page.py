"""The page: camera on the left, 3-D in the middle; STOP, the machine's state and the task tabs on the right."""

import logging
import threading
import time
from collections.abc import Callable

import viser

from footscan.gui import texts
from footscan.gui.binding import ask, on_press
from footscan.gui.desk import Desk
from footscan.gui.gate import guard
from footscan.gui.heartbeat import PATIENCE_S, Heartbeat
from footscan.gui.keys import ANSWER_S, Keys
from footscan.gui.logbook import Logbook
from footscan.gui.panel_camera import CameraPanel
from footscan.gui.panel_machine import MachinePanel
from footscan.gui.readiness import Loader
from footscan.gui.station import Station
from footscan.gui.tab import Tab, Tools
from footscan.gui.tab_calibrate import CalibrateTab
from footscan.gui.tab_inspect import InspectTab
from footscan.gui.tab_last import LastTab
from footscan.gui.tab_patient import PatientTab
from footscan.gui.tab_scan import ScanTab
from footscan.gui.tab_system import SystemTab
from footscan.gui.view_foot import FootView
from footscan.gui.visit import PatientWork
from footscan.gui.visit_calibrate import CalibrationWork
from footscan.gui.visit_result import ResultWork
from footscan.gui.visit_scan import ScanWork
from footscan.scanning.session.states import BUSY

TICKS_PER_S = 12.0
TABS: tuple[tuple[str, Callable[[Tools], Tab]], ...] = (
    (texts.TAB_PATIENT, PatientTab),
    (texts.TAB_SCAN, ScanTab),
    (texts.TAB_INSPECT, InspectTab),
    (texts.TAB_LAST, LastTab),
    (texts.TAB_CALIBRATE, CalibrateTab),
    (texts.TAB_SYSTEM, SystemTab),
)
"""Without icons: all six names stand in one row."""
_CAMERA_PX, _TASKS_PX = 340.0, 430.0
_LAST = 1e9
"""The tabs come after what each browser is told of its own."""
_LOG = logging.getLogger(__name__)


class Page:
    """Everything that is shown, over an open server; `start` it once its station is open, then `close`."""

    def __init__(self, server: viser.ViserServer, station: Station, patience_s: float = PATIENCE_S) -> None:
        self.server, self.station = server, station
        self.log = Logbook(station.data / "page.log")
        self.keys = Keys(self.log.write, time.monotonic)
        self.desk = Desk(self._say, self._stop)
        self._finished, self._news = threading.Event(), threading.Event()
        self._banners: dict[int, viser.GuiHtmlHandle] = {}
        self._buttons: dict[int, viser.GuiButtonHandle] = {}
        self._open = False
        guard(server.gui, self._may, self._refused)  # before there is anything that could be pressed
        self._build()
        self._heartbeat = Heartbeat(station, self._holder, patience_s)
        self._ticker = threading.Thread(name="page", target=self._tick_on, daemon=True)
        self._loader = Loader()
        server.on_client_connect(self._come)
        server.on_client_disconnect(self._go)

    def start(self) -> None:
        """The station is open: let people in, and keep everything up to date."""
        self._open = True
        self.desk.start()
        self.desk.post(lambda: self.tools.patients.find(""))
        self._heartbeat.start()
        self._ticker.start()
        self._loader.start()

    def close(self) -> None:
        """End all threads; the server and the station are closed by who opened them."""
        self.station.session.post_cancel(texts.CLOSING)
        self._finished.set()
        self._heartbeat.finish()
        self._loader.finish()
        self.desk.close()
        for thread in (self._ticker, self._heartbeat, self._loader):
            if thread.is_alive():
                thread.join(5.0)

    def _stop(self) -> None:
        self.station.session.post_cancel(texts.STOPPED_BY)

    def _build(self) -> None:
        server, desk, station, gui = self.server, self.desk, self.station, self.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(0, 96, 128))
        self.view = FootView(server, station)
        self.calibration = CalibrationWork(desk, station)
        scan, result = ScanWork(desk, station, self.view, self.calibration), ResultWork(desk, station)
        patients = PatientWork(desk, station)
        self.tools = Tools(server, desk, station, self.view, self.log, patients, scan, result, self.calibration)
        camera = gui.add_panel()
        with camera.add_tab(texts.CAMERA, viser.Icon.CAMERA):
            self.camera = CameraPanel(server, desk, station, scan)
        self.machine = MachinePanel(server, desk, station)
        self._tabs = self._add_tabs(gui.add_tab_group(order=_LAST))
        gui.main_panel.dock_right()
        gui.main_panel.set_width(_TASKS_PX)
        camera.dock_left()
        camera.set_width(_CAMERA_PX)
        for part in (self.camera, *self._tabs):
            desk.listen(part.show)
        desk.listen(lambda state: self._news.set())  # a moved slider is seen at once, not with the next tick

    def _add_tabs(self, group: viser.GuiTabGroupHandle) -> list[Tab]:
        tabs: list[Tab] = []
        for label, make in TABS:
            with group.add_tab(label):
                tabs.append(make(self.tools))
        return tabs

    def _tick_on(self) -> None:
        while not self._finished.is_set():
            self._news.wait(1.0 / TICKS_PER_S)
            self._news.clear()
            try:
                self._tick()
            except Exception:  # noqa: BLE001 - the picture of a moment must not end all pictures
                _LOG.exception("tick of the page")

    def _tick(self) -> None:
        snapshot = self.station.session.snapshot()
        if self.keys.wait_out(self._busy()):
            self._show_keys()
        self.machine.tick(snapshot)
        self.log.note_state(snapshot)
        for tab in self._tabs:
            tab.tick(snapshot)
        if self.server.get_clients():
            self.camera.tick()
            self.view.tick(snapshot)

    def _busy(self) -> bool:
        return self.station.session.snapshot().state in BUSY or self.desk.state.job is not None

    def _holder(self) -> viser.ClientHandle | None:
        holder = self.keys.holder
        return None if holder is None else self.server.get_clients().get(holder)

    def _may(self, client: int, uuid: str) -> bool:
        """Whoever controls may use everything; STOP is for everybody."""
        return self._open and (client == self.keys.holder or uuid == self.machine.stop._impl.uuid)  # pyright: ignore

    def _refused(self, client: int, why: str) -> None:
        self.log.write(f"browser {client} sent what was not taken: {why}")
        handle = self.server.get_clients().get(client)
        if handle is not None:
            watching = texts.ONLY_WATCHING if self._open else texts.STILL_OPENING
            body = watching if why == "watching" else texts.REFUSED_VALUE
            handle.add_notification(texts.FAILED, body, color="orange", auto_close_seconds=6.0)

    def _say(self, title: str, body: str, wrong: bool) -> None:
        self.log.write(f"{title}: {body}" if wrong else title)
        holder = self._holder()
        if holder is not None:
            colour, seconds = ("red", 15.0) if wrong else ("green", 5.0)
            holder.add_notification(title, body, color=colour, auto_close_seconds=seconds)

    async def _come(self, client: viser.ClientHandle) -> None:
        guard(client.gui, lambda number, uuid: True, self._refused)
        self.keys.come(client.client_id)
        self.desk.post(lambda: self._greet(client))

    async def _go(self, client: viser.ClientHandle) -> None:
        self.keys.go(client.client_id)
        self._banners.pop(client.client_id, None)
        self._buttons.pop(client.client_id, None)
        self.desk.post(self._show_keys)

    def _greet(self, client: viser.ClientHandle) -> None:
        """Each browser has its own words on who controls, and its own button to ask for it."""
        self._banners[client.client_id] = client.gui.add_html("")
        button = client.gui.add_button(texts.TAKE_OVER, icon=viser.Icon.KEY)
        self._buttons[client.client_id] = button
        on_press(self.desk, button, self._take_over)
        self._show_keys()

    def _take_over(self, client: viser.ClientHandle) -> None:
        number = client.client_id
        if self.keys.ask(number):
            self._show_keys()
            return
        holder = self._holder()
        if holder is None or number == self.keys.holder:
            return
        asked = texts.TAKE_OVER_ASKED.format(seconds=ANSWER_S)
        body = f"{asked} {texts.TAKE_OVER_BUSY}" if self._busy() else asked
        client.add_notification(texts.TAKE_OVER, body, auto_close_seconds=ANSWER_S)
        ask(
            self.desk,
            holder,
            texts.TAKE_OVER_TITLE,
            texts.TAKE_OVER_BODY.format(seconds=ANSWER_S),
            texts.GIVE,
            texts.KEEP,
            lambda: self._answer(holder.client_id, True),
            lambda: self._answer(holder.client_id, False),
        )

    def _answer(self, holder: int, give: bool) -> None:
        asking = self.keys.asking
        self.keys.answer(holder, give)
        asker = None if asking is None else self.server.get_clients().get(asking.client)
        if asker is not None and not give:
            asker.add_notification(texts.TAKE_OVER, texts.TAKE_OVER_REFUSED, color="orange", auto_close_seconds=8.0)
        self._show_keys()

    def _show_keys(self) -> None:
        holder = self.keys.holder
        for number, banner in list(self._banners.items()):
            words = texts.YOU_CONTROL if number == holder else texts.YOU_WATCH
            words = texts.NOBODY_CONTROLS if holder is None else words
            banner.content = f'<div style="padding:2px 1em 6px;font-size:12.5px">{words}</div>'
            self._buttons[number].visible = number != holder
