"""A page over a simulated machine in paced time, and a real browser that looks at it."""

import importlib.util
from collections.abc import Callable, Generator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from footscan.config.rig_file import Rig
from footscan.gui.door import Address
from footscan.gui.page import Page
from footscan.gui.serve import open_page
from footscan.gui.state import CameraChoice
from footscan.records import NewPatient
from footscan.workflow.demo_patients import add_demo_patients
from footscan.workflow.designs import builtin_rig
from footscan.workflow.visit import Filing, file_scan
from tests.gui.until import until

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext

    from footscan.gui.visitor import Visitor as Operator

PACE = 3.0
PATIENCE_S = 20.0 * PACE
"""Of the machine's clock. A browser on a busy computer without a graphics card may be silent for seconds."""


def still_rig(pace: float, profile: str) -> Rig:
    """The simulated machine with one profile alone, somebody who stands still on it, in paced time."""
    rig = builtin_rig()
    assert rig.devices.world is not None
    world = rig.devices.world.model_copy(update={"time": "paced", "pace": pace, "person": "statue"})
    motion = rig.motion.model_copy(update={"profile": (rig.profile(profile),)})
    return replace(rig, motion=motion, devices=rig.devices.model_copy(update={"world": world}))


@dataclass(frozen=True)
class Served:
    """A page that is being served."""

    page: Page
    data: Path

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.page.server.get_port()}"

    def log(self) -> str:
        return (self.data / "page.log").read_text()


Serve = Callable[..., AbstractContextManager[Served]]


@pytest.fixture(scope="session")
def serve() -> Serve:
    @contextmanager
    def serving(
        data: Path, patience_s: float = PATIENCE_S, pace: float = PACE, profile: str = "quick"
    ) -> Generator[Served]:
        with open_page(still_rig(pace, profile), data, Address(port=0), patience_s) as page:
            add_demo_patients(page.station.store)
            yield Served(page, data)

    return serving


@pytest.fixture(scope="session")
def served(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> Generator[Served]:
    """One page for all browser tests that do not end it; each takes a patient of its own."""
    with serve(tmp_path_factory.mktemp("page")) as page:
        yield page


@pytest.fixture(scope="session")
def measured_patient(served: Served, small_scan: Path) -> str:
    """The name of a patient with one measured left foot in use."""
    store, name = served.page.station.store, "Mette Measured"
    patient = store.add_patient(NewPatient(name), "a test")
    filing = Filing("a test", "left", "bipedal", "bare")
    take = file_scan(store, patient.id, small_scan, filing, small_scan / "truth-calibration.toml")
    store.judge_take(take.id, "accepted", "a test")
    store.use_take(take.id, "a test")
    return name


@pytest.fixture(scope="session")
def chromium() -> Generator["Browser"]:
    if importlib.util.find_spec("playwright") is None:
        pytest.skip("playwright is not installed")
    from footscan.gui.headless import find_chromium, open_chromium

    if find_chromium() is None:
        pytest.skip("no Chromium is installed; `make test` installs it where it may")
    with open_chromium() as browser:
        yield browser


@pytest.fixture(scope="session")
def olga(chromium: "Browser", served: Served) -> Generator["Operator"]:
    """One browser that controls the page, for all tests that leave it open."""
    from footscan.gui.visitor import Visitor

    context = _context(chromium, 1280, 800)
    visitor = Visitor(context.new_page(), served.url)
    visitor.is_known("Olga Operator")
    yield visitor
    context.close()


@pytest.fixture
def me(olga: "Operator", served: Served) -> "Operator":
    """That browser, whatever a test before has left behind: a button held down, a question, a job, a threshold."""
    desk = served.page.desk
    olga.begins_afresh()
    if desk.state.job is not None:
        desk.stop()
        until(lambda: desk.state.job is None)
    desk.post(lambda: desk.change(camera=CameraChoice()))
    until(lambda: desk.state.camera == CameraChoice())
    return olga


@pytest.fixture
def operator(chromium: "Browser") -> Generator[Callable[..., "Operator"]]:
    from footscan.gui.visitor import Visitor

    with ExitStack() as stack:

        def opens(url: str, width: int = 1280, height: int = 800) -> "Operator":
            context = _context(chromium, width, height)
            stack.callback(context.close)
            return Visitor(context.new_page(), url)

        yield opens


def _context(chromium: "Browser", width: int, height: int) -> "BrowserContext":
    from footscan.gui.headless import keep_calm

    context = chromium.new_context(viewport={"width": width, "height": height}, accept_downloads=True)
    keep_calm(context)
    return context
