"""`footscan calibrate --rig`: the guided procedure at the machine."""

from collections.abc import Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import typer

from footscan.cli.console import STDERR, STDOUT
from footscan.cli.scan import FACES, opened_rig_session
from footscan.config import DEFAULT_BOARD, load_board
from footscan.config.rig_file import Rig
from footscan.errors import InterlockError, PoorFitError, QualityError
from footscan.scanning.session.control import Session
from footscan.scanning.session.states import Snapshot, State
from footscan.workflow.guided_calibration import ENOUGH_MM, GuidedCalibration, PlacementReport
from footscan.workflow.opened_rig import OpenedRig

_AGAIN = 2
"""So often the one placement may be repeated."""
_PARKED = "the head is parked, motor and lasers are off"


@dataclass(frozen=True)
class GuidedChoices:
    """What the technician chose.

    Attributes:
        board: board.toml; None for the default board.
        stops: Head angles per placement.
        placements: At most so many.
        yes: Nobody has to be asked: a simulated machine, or somebody who has looked.
        passing: The first good placement is also passed on the move, which a calibration needs.
    """

    board: Path | None
    stops: int
    placements: int
    yes: bool
    passing: bool = True


def record_guided(rig: Rig, folder: Path, choices: GuidedChoices) -> None:
    """Lead through a calibration recording at a machine; ends when the expected error is small enough.

    Raises:
        DeviceError: A device is in trouble, or nobody confirmed that the machine may move; what was recorded is kept.
        QualityError: All placements are recorded and it is still not enough, or more of them would not help.
    """
    with _begun(rig, folder, choices, "guided calibration of") as (opened, guided):
        try:
            enough = _record_placements(opened, guided, choices)
        except PoorFitError:
            guided.finish()
            raise
        guided.finish()
    if not enough:
        raise QualityError(
            f"{choices.placements} placements are recorded in {folder} and the expected error is still above "
            f"{ENOUGH_MM:g} mm; look at what each placement said, and record again with the board placed differently."
        )


def record_one_placement(rig: Rig, folder: Path, choices: GuidedChoices) -> None:
    """One placement and the bare footboard: enough to align lasers or to re-check a calibration.

    Raises:
        DeviceError: A device is in trouble, or nobody confirmed that the machine may move.
        QualityError: The board was found from nowhere.
    """
    with _begun(rig, folder, choices, "one placement at") as (opened, guided):
        report = _record_placement(opened, guided, choices)
        for _ in range(_AGAIN):
            if report.why:
                report = _record_placement(opened, guided, choices)
        guided.finish()
    if report.why:
        raise QualityError(f"{report.sentence()}.")


@contextmanager
def _begun(rig: Rig, folder: Path, choices: GuidedChoices, what: str) -> Generator[tuple[OpenedRig, GuidedCalibration]]:
    """A guided recording with the bare footboard in it."""
    board = DEFAULT_BOARD if choices.board is None else load_board(choices.board)
    with opened_rig_session(rig, "left", None) as (opened, session):
        guided = GuidedCalibration(session, folder, board, choices.stops, _Teller())
        _put(opened, None, "Clear the footboard: nothing may stand on it.")
        _confirm(choices)
        _arm(session)
        guided.begin(f"{what} {rig.scanner.name}")
        _arm(session)
        guided.record_empty()
        yield opened, guided


def _record_placements(opened: OpenedRig, guided: GuidedCalibration, choices: GuidedChoices) -> bool:
    for _ in range(choices.placements):
        _record_placement(opened, guided, choices)
        error_mm, sentence = guided.expected_error_mm()
        STDOUT.print(f"{sentence[:1].upper()}{sentence[1:]}")
        if error_mm is not None and error_mm <= ENOUGH_MM:
            return True
    return False


def _record_placement(opened: OpenedRig, guided: GuidedCalibration, choices: GuidedChoices) -> PlacementReport:
    """The next placement, and the pass by it that shows how late frames are stamped, if that is still missing."""
    _put(opened, guided.next_place, f"Place the board ({len(guided.reports) + 1}): {guided.advice}. Step back.")
    _confirm(choices)
    _arm(guided.session)
    report = guided.record_placement()
    STDOUT.print(f"{report.sentence()}.")
    if choices.passing and guided.needs_pass:
        STDOUT.print("The head now turns past the board and back, to see how late frames are stamped.")
        _arm(guided.session)
        guided.record_pass()
    return report


def _put(opened: OpenedRig, place: int | None, words: str) -> None:
    STDOUT.print(words)
    if opened.put_calibration_board is not None:
        opened.put_calibration_board(place)
        STDOUT.print("(simulated: done)")


def _confirm(choices: GuidedChoices) -> None:
    """One answer covers everything up to the next time that somebody comes near the machine."""
    confirmed = choices.yes
    if not confirmed:
        with suppress(typer.Abort):  # nobody is there to answer
            confirmed = typer.confirm(f"Done? {FACES}", default=False, err=True)
    if not confirmed:
        raise InterlockError("not confirmed: lasers and motor stay off; what was recorded is kept.")


def _arm(session: Session) -> None:
    session.post_arm(no_faces_at_beam_height=True).wait()


class _Teller:
    """Says each new state once."""

    def __init__(self) -> None:
        self._state: State | None = None

    def __call__(self, snapshot: Snapshot) -> None:
        if snapshot.state is not self._state and snapshot.state is not State.CONNECTED:
            parked = snapshot.state is State.PARKED  # its words invite somebody onto the board
            STDERR.print(_PARKED if parked else snapshot.message or snapshot.state.value)
        self._state = snapshot.state
