"""A whole simulated scan, as frames in memory or as a recording on disk with its truth beside it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import cycle
from pathlib import Path

import numpy as np

from footscan.config import RecordingInfo, Subject, save_calibration, scanner_toml
from footscan.config.recording_file import RecordingSide
from footscan.coordinates import LASER_NAMES, Floats, Frame, Ints, LaserName
from footscan.errors import StorageError
from footscan.optics.scanner import Sweep
from footscan.scanning.recorder import RecordingWriter
from footscan.scanning.recording import FrameLaser
from footscan.sim.artefacts import Artefact, save_artefact
from footscan.sim.machine import TrueMachine, world_from_board
from footscan.sim.motion import HeadMotion, SweepPlan, plan_motion, sample_encoder
from footscan.sim.obstacles import Part, join_parts
from footscan.sim.picture import DEFAULT_PICTURE, Painter, PictureSettings
from footscan.sim.surface import Surface, trimesh_from_surface
from footscan.sim.visibility import count_sheets

DEFAULT_PLAN = SweepPlan()


@dataclass(frozen=True)
class SimulatedFrame:
    """A frame with its stamp and, which no real machine knows, the head angle at its exposure."""

    frame: Frame
    time_s: float
    laser: FrameLaser
    sweep: Sweep
    theta_rad: float


@dataclass(frozen=True)
class SimulatedScan:
    """A scan about to happen: who turns how, before what.

    Attributes:
        machine: The true machine.
        surface: What stands on its board, in world millimetres.
        motion: The head's way.
        plan: What it was planned from.
        picture: Light and sensor.
        seed: Of speckle and noise.
        obstacles: What else stands in the machine: seen and casting shadow, but no part of the truth.
    """

    machine: TrueMachine
    surface: Surface
    motion: HeadMotion
    plan: SweepPlan
    picture: PictureSettings
    seed: int
    obstacles: tuple[Part, ...] = ()

    def frames(self) -> Iterator[SimulatedFrame]:
        """Take the frames, one at a time."""
        surface, tone = join_parts(self.surface, self.obstacles)
        painter = Painter(self.machine.calibration, surface, self.picture, self.seed, tone)
        number = 0
        for (lasers, sweep), exposure_s in zip(_sweeps(self.machine, self.plan), self.motion.exposure_s, strict=True):
            thetas = self.motion.theta_at(exposure_s)
            order = _laser_order(lasers, len(exposure_s), self.plan.unlit_every)
            for moment, theta, laser in zip(exposure_s.tolist(), thetas.tolist(), order, strict=True):
                frame = painter.paint(theta, None if laser == "none" else laser, number)
                yield SimulatedFrame(frame, moment + self.machine.calibration.latency_s, laser, sweep, theta)
                number += 1

    def counts(self) -> tuple[Floats, Ints]:
        """The encoder's samples: times `(n,)` (s) and counts `(n,)`."""
        return sample_encoder(self.motion, self.machine.calibration.encoder, self.plan)

    @property
    def frame_count(self) -> int:
        """Frames of all sweeps."""
        return sum(len(exposure_s) for exposure_s in self.motion.exposure_s)


def prepare_scan(
    machine: TrueMachine,
    surface: Surface,
    plan: SweepPlan = DEFAULT_PLAN,
    picture: PictureSettings = DEFAULT_PICTURE,
    seed: int = 0,
    obstacles: tuple[Part, ...] = (),
) -> SimulatedScan:
    """Set up a scan: the ccw sweep with its laser first, then the other way. `surface` stands on z = 0.

    With alternating lasers there is the ccw sweep only.

    Raises:
        InputError: A plan that no machine can run.
    """
    board = world_from_board(machine.calibration.floor)
    motion = plan_motion(tuple(sweep for _, sweep in _sweeps(machine, plan)), plan, seed)
    beside = tuple(Part(part.surface.moved(board), part.tone) for part in obstacles)
    return SimulatedScan(machine, surface.moved(board), motion, plan, picture, seed, beside)


def simulate_recording(
    folder: Path,
    scan: SimulatedScan,
    side: RecordingSide = "none",
    notes: str = "",
    created: str | None = None,
    with_seen: bool = False,
    progress: Callable[[int, int], None] | None = None,
    artefact: Artefact | None = None,
    subject: Subject | None = None,
) -> None:
    """Run a scan into a new recording folder, with `truth-calibration.toml` and `truth.stl` beside the frames.

    Args:
        folder: Made if it does not exist.
        scan: What to record.
        side: Of the foot.
        notes: For recording.toml.
        created: RFC 3339 moment; now if not given.
        with_seen: Also write `truth-seen.npy`: how many sheets, 0 to 2, can light and show each face of `truth.stl`.
        progress: Called with the frames done and all frames.
        artefact: What is known about the artefact on the board, for artefact.toml.
        subject: What is known about the person, for recording.toml.

    Raises:
        RecordingError: The folder already holds a recording.
        StorageError: The folder cannot be written.
    """
    created = created or datetime.now(UTC).isoformat(timespec="seconds")
    info = RecordingInfo("scan", side, created, notes, subject or Subject())
    make_folder(folder)
    with RecordingWriter(folder, info, scanner_toml(scan.machine.scanner)) as writer:
        if artefact is not None:
            save_artefact(artefact, folder)
        writer.add_counts(*scan.counts())
        for done, taken in enumerate(scan.frames(), start=1):
            writer.add_frame(taken.frame, taken.time_s, taken.laser, taken.sweep)
            if progress is not None:
                progress(done, scan.frame_count)
    save_calibration(replace(scan.machine.calibration, created=created), folder / "truth-calibration.toml")
    trimesh_from_surface(scan.surface).export(folder / "truth.stl")
    if with_seen:
        everything, _ = join_parts(scan.surface, scan.obstacles)
        sheets = count_sheets(scan.machine.calibration, everything, scan.picture)
        np.save(folder / "truth-seen.npy", sheets[: len(scan.surface.faces)])


def _sweeps(machine: TrueMachine, plan: SweepPlan) -> list[tuple[tuple[LaserName, ...], Sweep]]:
    """The sweeps in their order, each with its lasers."""
    if plan.alternating:
        return [(LASER_NAMES, "ccw")]
    lasers = sorted(machine.scanner.lasers, key=lambda laser: laser.sweep == "cw")
    return [((laser.name,), laser.sweep) for laser in lasers]


def _laser_order(lasers: tuple[LaserName, ...], frames: int, unlit_every: int) -> list[FrameLaser]:
    """Which laser lights each frame of a sweep; an unlit frame does not break the turn of the lasers."""
    order: list[FrameLaser] = []
    turn = cycle(lasers)
    for number in range(1, frames + 1):
        unlit = unlit_every > 0 and number % unlit_every == 0
        order.append("none" if unlit else next(turn))
    return order


def make_folder(folder: Path) -> None:
    """Make a folder, or say why it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as err:
        raise StorageError(f"{folder} could not be made ({err.strerror}); choose another place.") from err
