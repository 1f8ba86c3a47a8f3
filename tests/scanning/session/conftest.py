"""A small, quick simulated rig in virtual time: the session's code is the real one, the pictures are small."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from footscan import app
from footscan.config import RecordingInfo
from footscan.config.rig_file import Rig
from footscan.optics.calibration import Calibration
from footscan.scanning.session.control import Session
from footscan.scanning.session.plan import ScanPlan, plan_scan
from footscan.scanning.session.programs import ScanOrder, home, scan
from footscan.scanning.session.ticket import Ticket
from footscan.sim.world import World
from footscan.workflow.designs import builtin_rig
from footscan.workflow.opened_rig import OpenedRig

SMALLER = 3


def small_rig(**motion: object) -> Rig:
    """The simulated rig with a camera of a ninth of the pixels and a quick head, in virtual time."""
    rig = builtin_rig()
    quick = {
        "travel_deg": (-24.0, 380.0),
        "home_deg": -9.0,
        "speeds_deg_per_s": (30.0, 90.0),
        "acceleration_deg_per_s2": 800.0,
        "profile": (rig.motion.profile[0].model_copy(update={"angle_step_deg": 4.0}),),
    }
    world = rig.devices.world
    assert world is not None
    world = world.model_copy(update={"time": "fast", "person": "statue"})
    return replace(
        rig,
        scanner=replace(rig.scanner, camera=rig.scanner.camera.coarser(SMALLER)),
        motion=rig.motion.model_copy(update=quick | motion),
        devices=rig.devices.model_copy(update={"world": world}),
    )


@dataclass
class Bench:
    """A rig on the bench: opened, in a session, armed and homed on request."""

    opened: OpenedRig
    session: Session
    folder: Path

    @property
    def world(self) -> World:
        assert self.opened.world is not None
        return self.opened.world

    @property
    def plan(self) -> ScanPlan:
        rig = self.opened.rig
        return plan_scan(rig.motion, rig.profile(None), self.session.facts, rig.scanner)

    def ready(self) -> None:
        self.session.post_arm(no_faces_at_beam_height=True).wait(30)
        self.session.post(home).wait(60)

    def start_scan(self, plan: ScanPlan | None = None, countdown_s: float = 0.5) -> Ticket:
        self.folder.mkdir(parents=True, exist_ok=True)
        info = RecordingInfo("scan", "left", "2026-01-01T00:00:00+00:00")
        order = ScanOrder(self.folder, info, plan or self.plan, countdown_s)
        return self.session.post(lambda machine: scan(machine, order))

    def wait_until(self, holds: Callable[[], bool], at_most_s: float = 60.0) -> None:
        import time

        ends = time.monotonic() + at_most_s
        while not holds():
            assert time.monotonic() < ends, self.session.snapshot()
            time.sleep(0.002)


def opened_bench(
    folder: Path, rig: Rig | None = None, calibrated: bool = True, calibration: Calibration | None = None
) -> Bench:
    """A bench whose session runs; whoever opens it closes the session."""
    rig = rig or small_rig()
    chosen = app.open_rig(rig)
    calibration = calibration or (app.true_machine(rig).calibration if calibrated else None)
    return Bench(chosen, app.start_session(chosen, calibration), folder / "recording")


@pytest.fixture
def open_bench(tmp_path: Path) -> Iterator[Callable[..., Bench]]:
    benches: list[Bench] = []

    def opened(rig: Rig | None = None, calibrated: bool = True, calibration: Calibration | None = None) -> Bench:
        benches.append(opened_bench(tmp_path, rig, calibrated, calibration))
        return benches[-1]

    yield opened
    for bench in benches:
        bench.session.close()


@pytest.fixture
def bench(open_bench: Callable[..., Bench]) -> Bench:
    return open_bench()
