"""The fault drill: break a scan in every way we know and see when the outputs fall, what is told, what is kept."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np

from footscan.config import RecordingInfo
from footscan.config.rig_file import Rig
from footscan.config.toml_file import read_toml, toml_bytes, write_whole
from footscan.errors import DeviceError, FootscanError, QualityError
from footscan.optics.camera import Camera
from footscan.optics.tables import LightTable
from footscan.scanning.frames import UnusableFrameError, read_frame
from footscan.scanning.recording import open_recording
from footscan.scanning.session.control import Session, SessionSetup, Ticket
from footscan.scanning.session.plan import plan_scan
from footscan.scanning.session.programs import ScanOrder, home, scan
from footscan.sim.module_twin import ModuleTwin
from footscan.sim.world import Trouble, World
from footscan.workflow.drill_faults import FailAt, FailingCamera, FailingEncoder, FailingTable
from footscan.workflow.opened_rig import OpenedRig

TARGET_S = 0.3
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
SIGNALS = ("SIGTERM", "kill -9")
CASES = (*WORLD_TROUBLES, *(f"exception in the {name}" for name in THREADS), *ENDINGS, *SIGNALS)

_PATIENCE_S = 90.0


@dataclass(frozen=True)
class DrillResult:
    """One case.

    Attributes:
        case: What was broken.
        off_after_s: From the fault to lasers and motor off, as the world saw it.
        told: What the person reads.
        captured: Frames that had come in, named or kept; None where the program is no longer there to be asked.
        named: Frames kept plus frames rejected by name; the same.
        kept: Whole frames in the recording on disk.
        unlisted: Picture files beyond those listed in frames.csv; 1 may be half-written by a killed program.
    """

    case: str
    off_after_s: float
    told: str
    captured: int | None
    named: int | None
    kept: int
    unlisted: int

    @property
    def well(self) -> bool:
        """Off in time, told, and every captured frame still there."""
        return (
            0.0 <= self.off_after_s <= TARGET_S
            and bool(self.told)
            and self.captured == self.named
            and self.kept > 0
            and self.unlisted <= 1
        )


@dataclass(frozen=True)
class Drill:
    """What a drill needs: the rig in virtual time, and how it is opened (which only `app` knows)."""

    rig: Rig
    open_rig: Callable[[Rig], OpenedRig]
    setup: SessionSetup
    seed: int
    folder: Path

    def run(self, cases: tuple[str, ...] = CASES) -> Iterator[DrillResult]:
        """One case after the other.

        Raises:
            QualityError: A case did not end by itself.
        """
        for number, case in enumerate(cases):
            random = np.random.default_rng([self.seed, number])
            place = self.folder / case.replace(" ", "-")
            place.mkdir(parents=True)
            yield self._signal(case, random, place) if case in SIGNALS else self._fault(case, random, place)

    def _fault(self, case: str, random: np.random.Generator, place: Path) -> DrillResult:
        opened = self.open_rig(self.rig)
        fail = FailAt(opened.devices.clock)
        session = self._session(opened, case, fail)
        session.start()
        try:
            return self._break(case, session, opened.world, fail, random, place)
        finally:
            session.close()

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
        world: World | None,
        fail: FailAt,
        random: np.random.Generator,
        place: Path,
    ) -> DrillResult:
        assert world is not None
        frames_before = int(random.integers(10, 120))
        if case == "full disk":
            _fill_disk(place, frames_before)
        ticket = self._start(session, place)
        _wait(lambda: session.snapshot().frames.kept >= min(frames_before, 10), case)
        at_s = session.clock.now_s() + float(random.uniform(0.05, 2.0))
        at_s = self._strike(case, session, world, fail, at_s)
        told = _told(ticket, case)
        _wait(lambda: world.off_since_s is not None and session.settled, case)
        off_s, frames = world.off_since_s, session.snapshot().frames
        assert off_s is not None
        kept, unlisted = _on_disk(place)
        at_s = _time_of_next_frame(place, session.facts.frames_per_s) if case == "full disk" else at_s
        named = frames.kept + sum(frames.rejected.values())
        return DrillResult(case, off_s - at_s, told, frames.captured, named, kept, unlisted)

    def _start(self, session: Session, place: Path) -> Ticket:
        session.post_arm(no_faces_at_beam_height=True).wait(_PATIENCE_S)
        session.post(home).wait(_PATIENCE_S)
        plan = plan_scan(self.rig.motion, self.rig.profile(None), session.facts, self.rig.scanner)
        info = RecordingInfo("scan", "left", "2026-01-01T00:00:00+00:00", "fault drill")
        order = ScanOrder(place, info, plan, countdown_s=0.2)
        return session.post(lambda machine: scan(machine, order))

    def _strike(self, case: str, session: Session, world: World, fail: FailAt, at_s: float) -> float:
        for trouble in WORLD_TROUBLES:
            if trouble == case:
                world.inject(trouble, at_s)
                return at_s
        if case.startswith("exception"):
            fail.at_s = at_s
            return at_s
        if case == "page closed":
            session.watch(at_s - session.clock.now_s())
            return at_s
        if case == "full disk":
            return at_s
        _wait(lambda: session.clock.now_s() >= at_s, case)
        at_s = session.clock.now_s()
        if case == "cancel":
            session.post_cancel()
        else:
            session.close()
        return at_s

    def _signal(self, case: str, random: np.random.Generator, place: Path) -> DrillResult:
        """A scan in a process of its own, in real time, ended by a signal; its module's twin lives here."""
        socket = place / "twin"
        rig = self._mirrored_rig(place, socket)
        command = [sys.executable, "-m", "footscan.cli.main", "scan", "--side", "left", "--yes", "--countdown", "0"]
        command += ["--rig", str(rig), "--out", str(place)]
        with ModuleTwin(socket) as twin, (place / "said").open("w") as said:
            program = subprocess.Popen(
                command, stderr=said, stdout=said, env=os.environ | {"FOOTSCAN_DATA": str(place)}
            )
            try:
                _wait(lambda: len(twin.outputs.lasers) > 0 and (place / "recording/frames/000010.png").exists(), case)
                time.sleep(float(random.uniform(0.1, 3.0)))
                at_s = time.monotonic()
                program.send_signal(signal.SIGTERM if case == "SIGTERM" else signal.SIGKILL)
                _wait(lambda: twin.off_since_s is not None, case)
                off_s = twin.off_since_s
                program.wait(_PATIENCE_S)
            finally:
                program.kill()
        assert off_s is not None
        kept, unlisted = _on_disk(place / "recording")
        told = (
            "broken off; footscan scans lists it with the command that processes it"
            if case == "kill -9"
            else (place / "said").read_text().strip().splitlines()[-1]
        )
        return DrillResult(case, off_s - at_s, told, None, None, kept, unlisted)

    def _mirrored_rig(self, place: Path, socket: Path) -> Path:
        table = read_toml(self.rig.path)
        table["devices"]["world"] |= {"mirror": str(socket), "time": "real"}
        write_whole(place / "rig.toml", toml_bytes(table))
        return place / "rig.toml"


def _failing(table: LightTable, fail: FailAt) -> LightTable:
    return cast("LightTable", FailingTable(table, fail))  # it has what the live view uses


def _fill_disk(place: Path, frame: int) -> None:
    """Writing this frame meets a full disk: the kernel's own ENOSPC, from /dev/full."""
    (place / "frames").mkdir()
    (place / f"frames/{frame:06d}.png").symlink_to("/dev/full")


def _told(ticket: Ticket, case: str) -> str:
    try:
        if not ticket.wait(_PATIENCE_S):
            raise QualityError(f"drill {case!r}: the scan did not end within {_PATIENCE_S:g} s.")
    except FootscanError as err:
        return str(err)
    return ""


def _wait(holds: Callable[[], bool], case: str) -> None:
    ends_s = time.monotonic() + _PATIENCE_S
    while not holds():
        if time.monotonic() > ends_s:
            raise QualityError(f"drill {case!r}: what was waited for did not come within {_PATIENCE_S:g} s.")
        time.sleep(0.002)


def _on_disk(folder: Path) -> tuple[int, int]:
    """Whole frames listed in a recording, and picture files that are not listed."""
    recording = open_recording(folder)
    whole = sum(1 for record in recording.frames if _readable(recording.path(record), recording.scanner.camera))
    if whole < len(recording.frames):
        raise DeviceError(f"{folder}: {len(recording.frames) - whole} listed frames cannot be read.")
    files = [path for path in (folder / "frames").iterdir() if not path.is_symlink()]
    return whole, len(files) - len(recording.frames)


def _readable(path: Path, camera: Camera) -> bool:
    try:
        read_frame(path, camera)
    except UnusableFrameError:
        return False
    return True


def _time_of_next_frame(folder: Path, frames_per_s: float) -> float:
    return open_recording(folder).frames[-1].time_s + 1.0 / frames_per_s
