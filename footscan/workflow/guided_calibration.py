"""The guided calibration on a rig: a technician places the board; the software drives, looks, says what is missing.

Every face drives it the same way, from a thread of its own (the calls below wait for the machine):

```
guided = GuidedCalibration(session, folder, board, tell=show)   # show(snapshot): state, message, progress 0..1
session.post_arm(...)  before each of the calls that move the head
guided.begin(notes)                  homes the head, opens the recording
guided.record_empty()                the bare footboard
guided.advice                        where the board belongs next
report = guided.record_placement()   what was found, or report.why not; as often as needed
guided.record_pass()                 past the last board, when guided.needs_pass
error_mm, sentence = guided.expected_error_mm()   None while something is missing, which the sentence names
guided.finish()                      then run_calibration(folder, ...), align_recording or recheck_recording
guided.cancel()                      from any other thread: lasers and motor off, the waiting call raises DeviceError
```

What was recorded is kept whatever ends it. A placement in which no board was found, or that a refusal asks to repeat,
is left out, and its place is advised again. `ENOUGH_MM` is when to stop.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from footscan.calibration.calibrate import calibrate_recording
from footscan.calibration.charuco import BoardFinder, why_not_found
from footscan.calibration.intake import FEWEST_VIEWS
from footscan.calibration.uncertainty import expected_error_mm
from footscan.config import Board, RecordingInfo, board_toml
from footscan.config.toml_file import write_whole
from footscan.coordinates import Frame
from footscan.errors import InputError, PoorFitError
from footscan.optics.calibration import theta_from_encoder
from footscan.scanning.frames import read_frame
from footscan.scanning.recorder import leave_out_setups
from footscan.scanning.recording import FrameRecord, Recording, open_recording
from footscan.scanning.session.control import Session
from footscan.scanning.session.programs import home
from footscan.scanning.session.states import Snapshot
from footscan.scanning.session.stops import (
    PassOrder,
    StopsOrder,
    begin_calibration,
    even_stops,
    record_pass,
    record_stops,
)
from footscan.scanning.session.ticket import Ticket

EMPTY = "empty"
PLACEMENTS = (
    "almost upright, its print towards the camera at home, the middle over the axis",
    "leaning back by half a right angle, its print to the left as seen from the camera at home",
    "leaning back a little, its print away from the camera at home",
    "almost flat, its print to the right",
    "upright near the edge of the footboard, its print half left of the camera at home, turned a little in its plane",
    "leaning back, its print half right and away from the camera, near the other edge",
)
"""Six placements that fix everything: four headings, three leans, middle and edge of the working volume."""
FEWEST_PLACEMENTS = 4
ENOUGH_MM = 0.03
_PASS_RAD = float(np.deg2rad(50.0))
_LOOK_S = 0.02


@dataclass(frozen=True)
class PlacementReport:
    """What the frames of one placement show.

    Attributes:
        setup: Its name.
        stops: Head angles looked from.
        angles_rad: Those from which the board was found.
        corners: Found in all of them.
        why: Why it is no good; empty otherwise.
        place: Which of the advised places it was.
    """

    setup: str
    stops: int
    angles_rad: tuple[float, ...]
    corners: int
    why: str = ""
    place: int = 0

    def sentence(self) -> str:
        """For the technician."""
        if self.why:
            return f"placement {self.setup} does not count: {self.why}. Place the board there again"
        return (
            f"placement {self.setup}: found from {len(self.angles_rad)} of {self.stops} head angles, "
            f"{self.corners} corners"
        )


@dataclass
class GuidedCalibration:
    """A calibration recording in the making; the session has no calibration, or an old one.

    Attributes:
        session: Over the rig's devices; armed by the technician before each call that moves the head.
        folder: Of the recording.
        board: The one in use.
        stops: Head angles per placement.
        tell: Told the machine's state while it works.
        reports: So far.
        left_out: Placements that were no good; their pictures stay in the folder.
        passed: The placement that was passed on the move.
    """

    session: Session
    folder: Path
    board: Board
    stops: int = 16
    tell: Callable[[Snapshot], None] = lambda snapshot: None
    reports: list[PlacementReport] = field(default_factory=list)
    left_out: set[str] = field(default_factory=set)
    passed: str | None = None

    @property
    def good(self) -> list[PlacementReport]:
        """Placements that count."""
        return [report for report in self.reports if report.setup not in self.left_out]

    @property
    def next_place(self) -> int:
        """Number of the first place in which no good placement stood yet."""
        taken = {report.place for report in self.good}
        return next(place for place in range(len(taken) + 1) if place not in taken)

    @property
    def advice(self) -> str:
        """Where the board belongs next."""
        return PLACEMENTS[self.next_place % len(PLACEMENTS)]

    @property
    def needs_pass(self) -> bool:
        """The last placement is good, and none that counts was passed on the move yet."""
        return self.passed is None and bool(self.good) and self.reports[-1] is self.good[-1]

    def begin(self, notes: str) -> None:
        """Open the recording and home the head.

        Raises:
            RecordingError: The folder already holds a recording.
            DeviceError: A device is in trouble, or the machine is not armed.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        self._follow(self.session.post(home))
        info = RecordingInfo("calibration", "none", datetime.now(UTC).isoformat(timespec="seconds"), notes)
        if not (self.folder / "recording.toml").exists():  # an earlier recording keeps its board
            write_whole(self.folder / "board.toml", board_toml(self.board))
        self._follow(self.session.post(lambda machine: begin_calibration(machine, self.folder, info)))

    def record_empty(self) -> None:
        """The bare footboard from all stops.

        Raises:
            DeviceError: A device is in trouble, or the machine is not armed.
        """
        self._stops(EMPTY)

    def record_placement(self) -> PlacementReport:
        """The board as it stands now, from all stops; what was found, or why not.

        Raises:
            DeviceError: A device is in trouble, or the machine is not armed.
        """
        setup = str(len(self.reports) + 1)
        self._stops(setup)
        report = self._look(setup)
        self.reports.append(report)
        if report.why:
            self.left_out.add(setup)
        return report

    def record_pass(self) -> None:
        """Past the board of the last placement and back.

        Raises:
            InputError: The last placement is no good.
            DeviceError: A device is in trouble, or the machine is not armed.
        """
        last = self.reports[-1]
        if last.setup in self.left_out:
            raise InputError(f"placement {last.setup} shows no board to pass; place it again.")
        low, high = np.deg2rad(self.session.setup.motion.sweep_deg)
        middle = float(np.clip(_mean_angle(last.angles_rad), low + _PASS_RAD, high - _PASS_RAD))
        order = PassOrder(last.setup, middle - _PASS_RAD, middle + _PASS_RAD)
        self._follow(self.session.post(lambda machine: record_pass(machine, order)))
        self.passed = last.setup

    def expected_error_mm(self) -> tuple[float | None, str]:
        """What a calibration from the recording so far would promise, or None and what is missing.

        Raises:
            PoorFitError: Neither repeating a placement nor more of them would help: the machine or the board is at
                fault.
        """
        good = len(self.good)
        if good < FEWEST_PLACEMENTS:
            return None, f"{_counted(good)} so far, at least {FEWEST_PLACEMENTS} are needed"
        self._written()
        recording = open_recording(self.folder)
        kept = tuple(record for record in recording.frames if record.setup not in self.left_out)
        try:
            result = calibrate_recording(replace(recording, frames=kept), self.board)
        except PoorFitError as err:
            if err.repeat:
                return None, self._leave_out(err)
            if not err.more:
                raise
            return None, f"not yet: {err}"
        except InputError as err:
            return None, f"not yet: {err}"
        error_mm = max(float(np.sqrt(np.mean(e**2))) for e in expected_error_mm(result.joint.fit).values())
        return error_mm, f"expected error {error_mm:.3f} mm in the working volume, {ENOUGH_MM:g} mm is enough"

    def _leave_out(self, refusal: PoorFitError) -> str:
        self.left_out.add(refusal.repeat)
        if self.passed == refusal.repeat:
            self.passed = None
        return f"placement {refusal.repeat} is left out: {refusal} {_counted(len(self.good))} left"

    def finish(self) -> None:
        """Close the recording, without the placements that were no good.

        Raises:
            StorageError: Its last frames could not be written.
        """
        self._follow(self.session.post(lambda machine: machine.keeper.end()))
        while not self.session.settled:
            failure = self.session.writing_failure
            if failure is not None:
                raise failure
            time.sleep(_LOOK_S)
        if self.left_out:
            leave_out_setups(self.folder, self.left_out)

    def cancel(self) -> None:
        """Stop what is going on, from any thread: lasers and motor go off, the call that waits raises `DeviceError`."""
        self.session.post_cancel("stopped by the technician")

    def _stops(self, setup: str) -> None:
        order = StopsOrder(setup, even_stops(self.stops))
        self._follow(self.session.post(lambda machine: record_stops(machine, order)))
        self._written()

    def _look(self, setup: str) -> PlacementReport:
        recording = open_recording(self.folder)
        records = [record for record in recording.frames if record.setup == setup and record.laser == "none"]
        frames = [read_frame(recording.path(record), recording.scanner.camera) for record in records]
        finder = BoardFinder(self.board)
        found = [
            (record, corners) for record, frame in zip(records, frames, strict=True) if (corners := finder.find(frame))
        ]
        angles = tuple(self._angle(recording, record) for record, _ in found)
        why = self._why(frames, len(found))
        corners = sum(len(corners.number) for _, corners in found)
        return PlacementReport(setup, len(records), angles, corners, why, self.next_place)

    def _why(self, frames: list[Frame], found: int) -> str:
        """Why a placement is no good; empty if it is."""
        if not found:
            return f"the board was not found: {why_not_found(self.board, frames)}"
        if found < FEWEST_VIEWS:
            return f"the board was found from {found} head angle only, at least {FEWEST_VIEWS} are needed"
        return ""

    def _angle(self, recording: Recording, record: FrameRecord) -> float:
        count = np.interp(record.time_s, recording.encoder.time_s, recording.encoder.count)
        return float(theta_from_encoder(np.array([count]), self.session.setup.scanner.encoder)[0])

    def _written(self) -> None:
        """Wait until every frame so far is on disk."""
        while not self.session.all_written:
            failure = self.session.writing_failure
            if failure is not None:
                raise failure
            time.sleep(_LOOK_S)

    def _follow(self, ticket: Ticket) -> None:
        while not ticket.done:
            self.tell(self.session.snapshot())
            time.sleep(_LOOK_S)
        ticket.wait()
        self.tell(self.session.snapshot())


def _counted(placements: int) -> str:
    return f"{placements} good placement{'' if placements == 1 else 's'}"


def _mean_angle(angles_rad: tuple[float, ...]) -> float:
    turns = np.exp(1j * np.array(angles_rad)).mean()
    return float(np.angle(turns) % (2.0 * np.pi))
