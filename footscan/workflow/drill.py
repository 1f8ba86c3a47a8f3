"""The fault drill: break a scan in every way we know and see when the outputs fall, what is told, what is kept."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np

from footscan.config import RecordingInfo
from footscan.config.rig_file import Rig
from footscan.errors import DeviceError, FootscanError, QualityError
from footscan.optics.tables import LightTable
from footscan.scanning.session.assembly import SessionSetup
from footscan.scanning.session.control import Session
from footscan.scanning.session.plan import plan_scan
from footscan.scanning.session.programs import ScanOrder, home, scan
from footscan.scanning.session.ticket import Ticket
from footscan.sim.emulators.emulated_rig import FAULTS, Fault
from footscan.sim.world import Trouble
from footscan.workflow.drill_faults import FailAt, FailingCamera, FailingEncoder, FailingTable
from footscan.workflow.drill_result import (
    TARGET_S,
    WATCHDOG_TARGET_S,
    DrillResult,
    fill_disk,
    frames_on_disk,
    time_of_next_frame,
)
from footscan.workflow.drill_signals import PATIENCE_S, SIGNALS, mirrored, outside, signalled, wait_for
from footscan.workflow.opened_rig import OpenedRig
from footscan.workflow.served_rig import ServedRig

WORLD_TROUBLES: tuple[Trouble, ...] = (
    "camera-frozen",
    "encoder-silent",
    "encoder-jump",
    "stall",
    "estop",
    "io-silent",
    "io-reset",
)
THREADS = ("grab thread", "keeper thread", "live thread", "control thread")
ENDINGS = ("cancel", "page closed", "program closed", "full disk")
_EVERYWHERE = (*(f"exception in the {name}" for name in THREADS), *ENDINGS, *SIGNALS)
CASES = (*WORLD_TROUBLES, *_EVERYWHERE)
EMULATED_CASES = (*FAULTS, "encoder-jump", "stall", "estop", *_EVERYWHERE)
_DEVICE_FAULTS: dict[str, Fault] = {fault: fault for fault in FAULTS}
_TROUBLES: dict[str, Trouble] = {trouble: trouble for trouble in WORLD_TROUBLES}
_UNREACHABLE = ("io-unplugged", "io-silent")
_FEWEST_FRAMES = 10
_ATTEMPTS = 4


def cases_of(rig: Rig) -> tuple[str, ...]:
    """Every case that a rig's devices can be broken in."""
    return EMULATED_CASES if rig.devices.emulated else CASES


@dataclass(frozen=True)
class Drill:
    """What a drill needs: a rig in virtual time or of emulators, and how it is opened (which only `app` knows)."""

    rig: Rig
    open_rig: Callable[[Rig], OpenedRig]
    serve: Callable[[Rig, Path], AbstractContextManager[ServedRig]]
    setup: SessionSetup
    seed: int
    folder: Path

    def run(self, cases: tuple[str, ...]) -> Iterator[DrillResult]:
        """One case after the other.

        Raises:
            QualityError: A case did not end by itself.
        """
        for number, case in enumerate(cases):
            random = np.random.default_rng([self.seed, number])
            yield self._case(case, random, self.folder / case.replace(" ", "-"))

    def _case(self, case: str, random: np.random.Generator, folder: Path) -> DrillResult:
        """Emulators and signals need real time: what a busy computer broke before the drill did is begun again."""
        error: FootscanError | None = None
        for spoiled in range(_ATTEMPTS if self.rig.devices.emulated or case in SIGNALS else 1):
            place = folder / str(spoiled)
            place.mkdir(parents=True)
            try:
                result = self._signal(case, random, place) if case in SIGNALS else self._fault(case, random, place)
            except DeviceError as err:
                error = err
                continue
            if result.off_after_s >= 0.0:
                return replace(result, spoiled=spoiled)
        raise QualityError(f"drill {case!r}: the scan ended before it was broken ({error or 'everything was off'}).")

    def _signal(self, case: str, random: np.random.Generator, place: Path) -> DrillResult:
        if not self.rig.devices.emulated:
            with mirrored(self.rig, place) as machine:
                return signalled(case, machine, random, place)
        with self.serve(self.rig, place / "machine") as served:
            return signalled(case, outside(served), random, place)

    def _fault(self, case: str, random: np.random.Generator, place: Path) -> DrillResult:
        opened = self.open_rig(self.rig)
        fail = FailAt(opened.devices.clock)
        session = self._session(opened, case, fail)
        session.start()
        try:
            return self._break(case, session, opened, fail, random, place)
        finally:
            session.close()
            opened.give_back()

    def _session(self, opened: OpenedRig, case: str, fail: FailAt) -> Session:
        devices, tables = opened.devices, self.setup.tables
        if case in ("exception in the grab thread", "exception in the keeper thread"):
            devices = replace(devices, camera=FailingCamera(devices.camera, fail, breaks="grab" in case))
        if case == "exception in the keeper thread":
            tables = None  # the live view would stumble over the same frame first
        if case == "exception in the control thread":
            devices = replace(devices, encoder=FailingEncoder(devices.encoder, fail))
        if case == "exception in the live thread" and tables is not None:
            tables = {name: _failing(table, fail) for name, table in tables.items()}
        return Session(devices, replace(self.setup, tables=tables))

    def _break(
        self,
        case: str,
        session: Session,
        opened: OpenedRig,
        fail: FailAt,
        random: np.random.Generator,
        place: Path,
    ) -> DrillResult:
        world = opened.world
        assert world is not None
        frames_before = int(random.integers(_FEWEST_FRAMES, 120))
        if case == "full disk":
            fill_disk(place, frames_before)
        ticket = self._start(session, place)
        wait_for(lambda: session.snapshot().frames.kept >= _FEWEST_FRAMES or ticket.done, case)
        if ticket.done and case != "full disk":
            ticket.wait()
        at_s = session.clock.now_s() + float(random.uniform(0.05, 2.0))
        at_s = self._strike(case, session, opened, fail, at_s)
        told = _told(ticket, case)
        wait_for(lambda: world.off_since_s is not None and session.settled, case)
        off_s, frames = world.off_since_s, session.snapshot().frames
        assert off_s is not None
        kept, unlisted = frames_on_disk(place)
        at_s = time_of_next_frame(place, session.facts.frames_per_s) if case == "full disk" else at_s
        named = frames.kept + sum(frames.rejected.values())
        return DrillResult(case, off_s - at_s, told, frames.captured, named, kept, unlisted, self._target_s(case))

    def _start(self, session: Session, place: Path) -> Ticket:
        session.post_arm(no_faces_at_beam_height=True).wait(PATIENCE_S)
        session.post(home).wait(PATIENCE_S)
        plan = plan_scan(self.rig.motion, self.rig.profile(None), session.facts, self.rig.scanner)
        info = RecordingInfo("scan", "left", "2026-01-01T00:00:00+00:00", "fault drill")
        order = ScanOrder(place, info, plan, countdown_s=0.2)
        return session.post(lambda machine: scan(machine, order))

    def _strike(self, case: str, session: Session, opened: OpenedRig, fail: FailAt, at_s: float) -> float:
        """Let it happen at a moment; returns when it really did."""
        if case == "full disk":
            return at_s
        if case.startswith("exception"):
            fail.at_s = at_s
            return at_s
        if case == "page closed":
            session.watch(at_s - session.clock.now_s())
            return at_s
        if case not in ENDINGS:
            return _injected(case, opened, at_s)
        wait_for(lambda: session.clock.now_s() >= at_s, case)
        at_s = session.clock.now_s()
        if case == "cancel":
            session.post_cancel()
        else:
            session.close()
        return at_s

    def _target_s(self, case: str) -> float:
        return WATCHDOG_TARGET_S if self.rig.devices.emulated and case in _UNREACHABLE else TARGET_S


def _injected(case: str, opened: OpenedRig, at_s: float) -> float:
    clock, emulated, world = opened.devices.clock, opened.emulated, opened.world
    assert world is not None
    fault = _DEVICE_FAULTS.get(case)
    if emulated is None or fault is None:
        world.inject(_TROUBLES[case], at_s)
        return at_s
    wait_for(lambda: clock.now_s() >= at_s, case)
    struck_s = clock.now_s()
    emulated.inject(fault)
    return struck_s


def _failing(table: LightTable, fail: FailAt) -> LightTable:
    return cast("LightTable", FailingTable(table, fail))  # it has what the live view uses


def _told(ticket: Ticket, case: str) -> str:
    try:
        if not ticket.wait(PATIENCE_S):
            raise QualityError(f"drill {case!r}: the scan did not end within {PATIENCE_S:g} s.")
    except FootscanError as err:
        return str(err)
    return ""
