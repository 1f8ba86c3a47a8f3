"""The guided calibration on a rig: a technician places the board; the software drives, looks, says what is missing.

Every face drives it the same way, from a thread of its own (the calls below wait for the machine):

```
guided = GuidedCalibration(session, folder, board, tell=show)   # show(snapshot): state, message, progress 0..1
session.post_arm(...)  before each of the three calls that move the head
guided.begin(notes)                  homes the head, opens the recording
guided.record_empty()                the bare footboard
report = guided.record_placement()   what was found, or report.why not; as often as needed
guided.record_pass()                 past the last board, once
error_mm, sentence = guided.expected_error_mm()   None while something is missing, which the sentence names
guided.finish()                      then run_calibration(folder, ...), align_recording or recheck_recording
guided.cancel()                      from any other thread: lasers and motor off, the waiting call raises DeviceError
```

What was recorded is kept whatever ends it. `PLACEMENTS` has the words for each placement, `ENOUGH_MM` when to stop.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from footscan.calibration.calibrate import calibrate_recording
from footscan.calibration.charuco import BoardFinder, why_not_found
from footscan.calibration.gates import LIMITS
from footscan.calibration.joint import USUAL
from footscan.calibration.uncertainty import expected_error_mm
from footscan.config import Board, RecordingInfo, board_toml
from footscan.config.toml_file import write_whole
from footscan.errors import InputError, QualityError
from footscan.optics.calibration import theta_from_encoder
from footscan.scanning.frames import read_frame
from footscan.scanning.recording import FrameRecord, Recording, open_recording
from footscan.scanning.session.control import Session, Ticket
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
        why: Why it was found from nowhere; empty otherwise.
    """

    setup: str
    stops: int
    angles_rad: tuple[float, ...]
    corners: int
    why: str = ""

    def sentence(self) -> str:
        """For the technician."""
        if self.why:
            return f"placement {self.setup}: the board was not found: {self.why}"
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
    """

    session: Session
    folder: Path
    board: Board
    stops: int = 16
    tell: Callable[[Snapshot], None] = lambda snapshot: None
    reports: list[PlacementReport] = field(default_factory=list)

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
        setup = str(len(self.reports))
        self._stops(setup)
        report = self._look(setup)
        self.reports.append(report)
        return report

    def record_pass(self) -> None:
        """Past the board of the last placement and back.

        Raises:
            InputError: The board of the last placement was found from nowhere.
            DeviceError: A device is in trouble, or the machine is not armed.
        """
        last = self.reports[-1]
        if not last.angles_rad:
            raise InputError(f"placement {last.setup} shows no board to pass; place it again.")
        low, high = np.deg2rad(self.session.setup.motion.sweep_deg)
        middle = float(np.clip(_mean_angle(last.angles_rad), low + _PASS_RAD, high - _PASS_RAD))
        order = PassOrder(last.setup, middle - _PASS_RAD, middle + _PASS_RAD)
        self._follow(self.session.post(lambda machine: record_pass(machine, order)))

    def expected_error_mm(self) -> tuple[float | None, str]:
        """What a calibration from the recording so far would promise, or None and what is missing."""
        good = [report for report in self.reports if report.angles_rad]
        if len(good) < FEWEST_PLACEMENTS:
            return None, f"{len(good)} good placements so far, at least {FEWEST_PLACEMENTS} are needed"
        self._written()
        try:
            result = calibrate_recording(open_recording(self.folder), self.board, USUAL, LIMITS)
        except (InputError, QualityError) as err:
            return None, f"not yet: {err}"
        error_mm = max(float(np.sqrt(np.mean(e**2))) for e in expected_error_mm(result.joint.fit).values())
        return error_mm, f"expected error {error_mm:.3f} mm in the working volume, {ENOUGH_MM:g} mm is enough"

    def finish(self) -> None:
        """Close the recording.

        Raises:
            StorageError: Its last frames could not be written.
        """
        self._follow(self.session.post(lambda machine: machine.keeper.end()))
        while not self.session.settled:
            failure = self.session.writing_failure
            if failure is not None:
                raise failure
            time.sleep(_LOOK_S)

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
        why = "" if found else why_not_found(self.board, frames)
        return PlacementReport(setup, len(records), angles, sum(len(corners.number) for _, corners in found), why)

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


def _mean_angle(angles_rad: tuple[float, ...]) -> float:
    turns = np.exp(1j * np.array(angles_rad)).mean()
    return float(np.angle(turns) % (2.0 * np.pi))
