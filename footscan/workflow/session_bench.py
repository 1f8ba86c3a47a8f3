"""How many frames a second the session keeps: pictures made beforehand, everything else as in a scan, in real time."""

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np

from footscan.config import RecordingInfo
from footscan.config.rig_file import Rig
from footscan.coordinates import Floats, Frame
from footscan.devices.clock import Clock
from footscan.devices.values import CameraFacts, CameraFrame
from footscan.errors import CameraLostError
from footscan.optics.tables import LightTable
from footscan.scanning.session.assembly import SessionSetup
from footscan.scanning.session.control import Session
from footscan.scanning.session.plan import ScanPlan, plan_scan
from footscan.scanning.session.programs import ScanOrder, home, scan
from footscan.scanning.session.states import FrameCount, LiveCount
from footscan.sim.picture import Painter
from footscan.workflow.opened_rig import OpenedRig

_PICTURES = 24


class ReplayCamera:
    """A camera that delivers pictures made beforehand, at any rate."""

    def __init__(self, frames: list[Frame], facts: CameraFacts, latency_s: float, clock: Clock) -> None:
        self._frames, self._facts, self._latency_s, self._clock = frames, facts, latency_s, clock
        self._began_s: float | None = None
        self._number = 0
        self._closed = False

    def facts(self) -> CameraFacts:
        """As told."""
        return self._facts

    def start(self) -> None:
        """Let frames come."""
        self._began_s = self._clock.now_s()

    def read(self, timeout_s: float) -> CameraFrame:
        """The next picture when it is due; a slow reader finds the missed ones gone.

        Raises:
            CameraLostError: Not started or closed.
        """
        if self._began_s is None or self._closed:
            raise CameraLostError("the replayed camera is not running.")
        period_s = 1.0 / self._facts.frames_per_s
        ripe = int((self._clock.now_s() - self._began_s) / period_s) - 3  # as many as a driver keeps
        number = max(self._number, ripe)
        due_s = self._began_s + number * period_s
        self._clock.wait(due_s, lambda: self._closed)
        self._number = number + 1
        return CameraFrame(self._frames[number % len(self._frames)], due_s + self._latency_s, number)

    def close(self) -> None:
        """No more pictures."""
        self._closed = True


class SlowTable:
    """A calibration table whose reader is held up: a computer that is too slow for the live view."""

    def __init__(self, table: LightTable, clock: Clock, slowed_s: float) -> None:
        self._table, self._clock, self._slowed_s = table, clock, slowed_s
        self.world_from_light = table.world_from_light

    def lookup(self, uv: Floats) -> Floats:
        """As the table, late."""
        self._clock.wait(self._clock.now_s() + self._slowed_s)
        return self._table.lookup(uv)


@dataclass(frozen=True)
class SessionBench:
    """One scan at one rate: what became of the frames, and the rate at which all of them were on disk."""

    frames_per_s: float
    frames: FrameCount
    live: LiveCount
    sustained_per_s: float


def bench_session(
    rig: Rig, opened: OpenedRig, setup: SessionSetup, frames_per_s: float, slowed_s: float = 0.0
) -> SessionBench:
    """Two sweeps with frames at a given rate, in real time.

    Args:
        rig: Of simulated devices.
        opened: The same, opened.
        setup: With a calibration.
        frames_per_s: Of the camera.
        slowed_s: How long processing for the live view is held up at each frame, on purpose.

    Raises:
        DeviceError: The machine stopped.
    """
    assert setup.calibration is not None
    real = opened.devices.camera.facts()
    facts = replace(real, frames_per_s=frames_per_s)
    clock = opened.devices.clock
    camera = ReplayCamera(_pictures(opened), facts, setup.calibration.latency_s, clock)
    if slowed_s and setup.tables is not None:
        tables = {name: cast("LightTable", SlowTable(table, clock, slowed_s)) for name, table in setup.tables.items()}
        setup = replace(setup, tables=tables)
    session = Session(replace(opened.devices, camera=camera), setup)
    session.start()
    try:
        session.post_arm(no_faces_at_beam_height=True).wait()
        session.post(home).wait()
        profile = rig.motion.profile[0].model_copy(update={"lasers": "one-after-the-other", "angle_step_deg": 15.0})
        plan = plan_scan(rig.motion, profile, facts, rig.scanner)
        seconds, frames = _timed_scan(session, plan)
        _wait_for(lambda: session.live is None or session.live.thread.idle)
        live = LiveCount() if session.live is None else session.live.count()
    finally:
        session.close()
    return SessionBench(frames_per_s, frames, live, frames.captured / seconds)


def _timed_scan(session: Session, plan: ScanPlan) -> tuple[float, FrameCount]:
    with tempfile.TemporaryDirectory(prefix="footscan-bench-", ignore_cleanup_errors=True) as folder:
        info = RecordingInfo("scan", "left", "2026-01-01T00:00:00+00:00", "bench")
        order = ScanOrder(Path(folder), info, plan, countdown_s=0.0)
        ticket = session.post(lambda machine: scan(machine, order))
        _wait_for(lambda: session.snapshot().frames.captured > 0)
        began_s = time.perf_counter()
        _wait_for(lambda: (Path(folder) / "manifest.sha256").exists() or ticket.done)
        seconds = time.perf_counter() - began_s
        ticket.wait()
        return seconds, session.snapshot().frames


def _pictures(opened: OpenedRig) -> list[Frame]:
    assert opened.world is not None
    world = opened.world
    painter = Painter(world.machine.calibration, world.standing.surface, world.settings.picture)
    angles = np.linspace(0.0, 2.0 * np.pi, _PICTURES, endpoint=False)
    return [painter.paint(float(theta), "right", number) for number, theta in enumerate(angles)]


def _wait_for(holds: Callable[[], bool]) -> None:
    while not holds():
        time.sleep(0.005)
