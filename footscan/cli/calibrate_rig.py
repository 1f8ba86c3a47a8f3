"""`footscan calibrate --rig`: the guided procedure at the machine."""

from dataclasses import dataclass
from pathlib import Path

import typer

from footscan.calibration.board_sheet import DEFAULT_BOARD
from footscan.cli.console import STDERR, STDOUT
from footscan.cli.scan import FACES, opened_rig_session
from footscan.config import load_board
from footscan.config.rig_file import Rig
from footscan.errors import InterlockError, QualityError
from footscan.scanning.session.control import Session
from footscan.scanning.session.states import Snapshot, State
from footscan.workflow.guided_calibration import ENOUGH_MM, FEWEST_PLACEMENTS, PLACEMENTS, GuidedCalibration
from footscan.workflow.opened_rig import OpenedRig


@dataclass(frozen=True)
class GuidedChoices:
    """What the technician chose.

    Attributes:
        board: board.toml; None for the default board.
        stops: Head angles per placement.
        placements: At most so many.
        yes: Nobody has to be asked: a simulated machine, or somebody who has looked.
    """

    board: Path | None
    stops: int
    placements: int
    yes: bool


def record_guided(rig: Rig, folder: Path, choices: GuidedChoices) -> None:
    """Lead through a calibration recording at a machine; ends when the expected error is small enough.

    Raises:
        DeviceError: A device is in trouble, or nobody confirmed that the machine may move; what was recorded is kept.
        QualityError: All placements are recorded and it is still not enough.
    """
    board = DEFAULT_BOARD if choices.board is None else load_board(choices.board)
    with opened_rig_session(rig, "left", None) as (opened, session):
        guided = GuidedCalibration(session, folder, board, choices.stops, _Teller())
        _put(opened, None, "Clear the footboard: nothing may stand on it.", choices)
        _arm(session, choices)
        guided.begin(f"guided calibration of {rig.scanner.name}")
        _arm(session, choices)
        guided.record_empty()
        enough = _record_placements(opened, guided, choices)
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
    board = DEFAULT_BOARD if choices.board is None else load_board(choices.board)
    with opened_rig_session(rig, "left", None) as (opened, session):
        guided = GuidedCalibration(session, folder, board, choices.stops, _Teller())
        _put(opened, None, "Clear the footboard: nothing may stand on it.", choices)
        _arm(session, choices)
        guided.begin(f"one placement at {rig.scanner.name}")
        _arm(session, choices)
        guided.record_empty()
        _put(opened, 0, f"Place the board {PLACEMENTS[0]}. Step back.", choices)
        _arm(session, choices)
        report = guided.record_placement()
        guided.finish()
    if report.why:
        raise QualityError(f"{report.sentence()}.")
    STDOUT.print(report.sentence())


def _record_placements(opened: OpenedRig, guided: GuidedCalibration, choices: GuidedChoices) -> bool:
    for number in range(choices.placements):
        advice = PLACEMENTS[number % len(PLACEMENTS)]
        _put(opened, number, f"Place the board ({number + 1}): {advice}. Step back.", choices)
        _arm(guided.session, choices)
        report = guided.record_placement()
        STDOUT.print(report.sentence())
        if number == 0:
            _arm(guided.session, choices)
            guided.record_pass()
        error_mm, sentence = guided.expected_error_mm()
        STDOUT.print(sentence)
        if error_mm is not None and error_mm <= ENOUGH_MM and number + 1 >= FEWEST_PLACEMENTS:
            return True
    return False


def _put(opened: OpenedRig, setup: int | None, words: str, choices: GuidedChoices) -> None:
    STDOUT.print(words)
    if opened.put_calibration_board is not None:
        opened.put_calibration_board(setup)
        STDOUT.print("(simulated: done)")
    elif not choices.yes:
        typer.prompt("Press Enter when it is done", default="", show_default=False, err=True)


def _arm(session: Session, choices: GuidedChoices) -> None:
    if not choices.yes and not typer.confirm(FACES, default=False, err=True):
        raise InterlockError("not confirmed: lasers and motor stay off; what was recorded is kept.")
    session.post_arm(no_faces_at_beam_height=True).wait()


class _Teller:
    """Says each new state once."""

    def __init__(self) -> None:
        self._state: State | None = None

    def __call__(self, snapshot: Snapshot) -> None:
        if snapshot.state is not self._state:
            STDERR.print(snapshot.message or snapshot.state.value)
        self._state = snapshot.state
