"""How long the page takes, what it costs a scan, and whether it grows: measured in a real browser."""

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from playwright.sync_api import Browser

from footscan.config.rig_file import Rig
from footscan.errors import QualityError
from footscan.gui import texts
from footscan.gui.door import Address, url_of
from footscan.gui.page import Page
from footscan.gui.serve import open_page
from footscan.gui.visitor import Visitor
from footscan.records import NewPatient
from footscan.scanning.session.states import FrameCount, LiveCount

_WAIT_S = 600.0
_PATIENCE_S = 1e6
_FIRST_WORDS = "() => /is starting|is being opened|controls? the machine/.test(document.body.innerText)"
_EVERYTHING = """names => {
  const has = role => [...document.querySelectorAll(role)].map(element => element.innerText.trim());
  const tabs = has('[role=tab]'), buttons = has('button');
  return names.tabs.every(name => tabs.includes(name)) && buttons.includes(names.stop)
    && /[Cc]ontrols? the machine/.test(document.body.innerText)
    && document.querySelector('[data-footscan=state]') != null;
}"""
"""Camera panel, all tabs, STOP, the state line of the open machine, and who controls: asked in one go, cheaply."""
_POLL_MS = 30
_LATENCY = """async ([key, wantsWhite]) => {
  const image = document.querySelector('img[src^="blob:"]');
  const canvas = document.createElement('canvas'); canvas.width = 96; canvas.height = 82;
  const context = canvas.getContext('2d', {willReadFrequently: true});
  const white = () => { context.drawImage(image, 0, 0, 96, 82);
    return context.getImageData(0, 0, 96, 82).data.some((v, i) => i % 4 == 0 && v > 100); };
  const thumb = document.querySelector('[data-footscan-thumb]');
  const begun = performance.now();
  thumb.dispatchEvent(new KeyboardEvent('keydown', {key, code: key, bubbles: true}));
  while (performance.now() - begun < 20000) {
    await new Promise(go => setTimeout(go, 2));
    if (image.complete && image.naturalWidth && white() == wantsWhite) return performance.now() - begun;
  }
  return -1;
}"""


@dataclass(frozen=True)
class Start:
    """Seconds from the command to its address, to its first words in a browser, to all its controls; of a bare page."""

    address_s: float
    words_s: float
    visible_s: float
    bare_s: float


def time_start(browser: Browser, repeats: int) -> Iterator[Start]:
    """Start the command as a person does every morning, and look until everything is there and can be used.

    The records are there already: a first start that nobody counts has made them, and what it had to compile.
    """
    with tempfile.TemporaryDirectory() as data:
        _start_once(browser, data)
        for _ in range(repeats):
            yield Start(*_start_once(browser, data), _bare_page(browser))


def _start_once(browser: Browser, data: str) -> tuple[float, float, float]:
    words = [sys.executable, "-m", "footscan.cli.main", "serve", "--port", "0", "--data", data, "--no-browser"]
    begun_s = time.perf_counter()
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as served:
        try:
            url = _url_said(served)
            address_s = time.perf_counter() - begun_s
            tab = browser.new_page()
            tab.goto(url)
            tab.wait_for_function(_FIRST_WORDS, polling=_POLL_MS)
            words_s = time.perf_counter() - begun_s
            tabs = (texts.CAMERA, texts.TAB_PATIENT, texts.TAB_SCAN, texts.TAB_INSPECT, texts.TAB_LAST)
            everything = {"tabs": [*tabs, texts.TAB_CALIBRATE, texts.TAB_SYSTEM], "stop": texts.STOP}
            tab.wait_for_function(_EVERYTHING, arg=everything, polling=_POLL_MS, timeout=1000.0 * _WAIT_S)
            visible_s = time.perf_counter() - begun_s
            tab.close()
        finally:
            served.terminate()
    return address_s, words_s, visible_s


def _url_said(served: "subprocess.Popen[str]") -> str:
    assert served.stdout is not None
    for line in served.stdout:
        url = next((word for word in line.split() if word.startswith("http://")), "")
        if url:
            return url
    raise QualityError("the page did not start; run footscan serve to see why.")


_BARE = """import time, viser
server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
server.gui.add_button("ready")
print(f"http://127.0.0.1:{server.get_port()}", flush=True)
time.sleep(600)"""


def _bare_page(browser: Browser) -> float:
    """The same for a page of viser with one button: what no page of it can be faster than."""
    begun_s = time.perf_counter()
    with subprocess.Popen([sys.executable, "-c", _BARE], stdout=subprocess.PIPE, text=True) as served:
        try:
            tab = browser.new_page()
            tab.goto(_url_said(served))
            tab.get_by_role("button", name="ready").wait_for()
            bare_s = time.perf_counter() - begun_s
            tab.close()
        finally:
            served.terminate()
    return bare_s


def time_threshold(browser: Browser, rig: Rig, repeats: int) -> list[float]:
    """Milliseconds from a key on the threshold slider to the new binary picture in the browser."""
    with tempfile.TemporaryDirectory() as data, _quiet_page(rig, Path(data)) as page:
        tab = browser.new_page(viewport={"width": 1280, "height": 800})
        me = Visitor(tab, url_of(page.server, Address(port=0)))
        me.presses("Binary")
        me.slider(texts.THRESHOLD).evaluate("thumb => thumb.setAttribute('data-footscan-thumb', '1')")
        me.slider(texts.THRESHOLD).press("End")
        tab.wait_for_timeout(2000)
        taken: list[float] = []
        for number in range(repeats):
            key, white = ("Home", True) if number % 2 == 0 else ("End", False)
            taken.append(float(tab.evaluate(_LATENCY, [key, white])))
            tab.wait_for_timeout(300)
        tab.close()
    return taken


def count_frames(browser: Browser | None, rig: Rig) -> tuple[FrameCount, LiveCount]:
    """What became of the frames of one scan, with the page open in a browser or without one."""
    with tempfile.TemporaryDirectory() as data, _quiet_page(rig, Path(data)) as page:
        tab = None if browser is None else browser.new_page(viewport={"width": 1280, "height": 800})
        if tab is not None:
            Visitor(tab, url_of(page.server, Address(port=0))).goes_to(texts.TAB_SCAN)
        scan_once(page, _new_patient(page))
        snapshot = page.station.session.snapshot()
        if tab is not None:
            tab.close()
    return snapshot.frames, snapshot.live


def grow(rig: Rig, scans: int, say: Callable[[int, float], None]) -> None:
    """Scan, measure and file again and again in one page; `say` is told the number and this process's memory (MB)."""
    with tempfile.TemporaryDirectory() as data, _quiet_page(rig, Path(data)) as page:
        for number in range(scans):
            scan_once(page, _new_patient(page))
            say(number + 1, _memory_mb())


def scan_once(page: Page, patient_id: int) -> None:
    """Check, scan, measure and file through the page's own commands, as its buttons post them.

    Raises:
        QualityError: No take came of it.
    """
    desk, tools = page.desk, page.tools
    _do(page, lambda: tools.patients.choose(patient_id))
    _do(page, tools.scan.arm)
    _do(page, tools.scan.check)
    _do(page, tools.scan.start)
    if desk.state.take is None:
        raise QualityError(f"the scan brought nothing: {desk.state.note or desk.state.findings}")


def _do(page: Page, command: Callable[[], None]) -> None:
    """Post a command and wait until nothing that came of it runs any more."""
    page.desk.post(command)
    gives_up_s = time.monotonic() + _WAIT_S
    while not page.desk.idle:
        if time.monotonic() > gives_up_s:
            raise QualityError(f"the page still works after {_WAIT_S:g} s; the computer is too busy for this.")
        time.sleep(0.02)


def _new_patient(page: Page) -> int:
    page.desk.post(lambda: page.tools.patients.set_operator("bench"))
    store = page.station.store
    return store.add_patient(NewPatient(f"Bench {time.monotonic_ns()}"), "bench").id


def _quiet_page(rig: Rig, data: Path):
    return open_page(rig, data, Address(port=0), _PATIENCE_S)


def _memory_mb() -> float:
    """Resident memory of this process now."""
    with Path("/proc/self/statm").open(encoding="ascii") as stream:
        return int(stream.read().split()[1]) * resource.getpagesize() / 1e6


def small_rig(rig: Rig) -> Rig:
    """The simulated machine in virtual time: a quarter of the pixels, the fewest frames a foot can be measured from."""
    assert rig.devices.world is not None
    world = rig.devices.world.model_copy(update={"time": "paced", "pace": 100.0, "person": "statue"})
    coarse = rig.motion.profile[0].model_copy(update={"name": "coarse", "angle_step_deg": 7.5})
    speeds = (*rig.motion.speeds_deg_per_s[:2], 60.0)
    motion = rig.motion.model_copy(update={"profile": (coarse,), "frames_per_s": 8.0, "speeds_deg_per_s": speeds})
    scanner = replace(rig.scanner, camera=rig.scanner.camera.coarser(2))
    return replace(rig, scanner=scanner, motion=motion, devices=rig.devices.model_copy(update={"world": world}))


def real_time_rig(rig: Rig) -> Rig:
    """The simulated machine by the wall clock, which loses frames when the computer is too busy."""
    assert rig.devices.world is not None
    world = rig.devices.world.model_copy(update={"time": "real"})
    return replace(rig, devices=rig.devices.model_copy(update={"world": world}))


def busy_now() -> str:
    """How busy this computer is, for whoever reads the figures."""
    return f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"
