"""`footscan scan` and `footscan scans`."""

import shlex
import signal
from collections.abc import Generator
from contextlib import ExitStack, contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

import typer

from footscan import app as rig_app
from footscan.cli.console import STDERR, STDOUT, print_json, progress_bar
from footscan.cli.process import tell_results
from footscan.cli.records_options import DataOption, opened_store, person
from footscan.cli.rig_option import RigOption, chosen_rig
from footscan.config import Subject, load_calibration
from footscan.config.io_models import AdamModel
from footscan.config.recording_file import Load
from footscan.config.recording_file import Surface as CoverKind
from footscan.config.rig_file import Rig
from footscan.coordinates import Side
from footscan.errors import ConfigError, FootscanError, InputError, InterlockError, QualityError
from footscan.optics.calibration import Calibration
from footscan.records.data_folder import SCANS, data_folder
from footscan.scanning.session.control import Session
from footscan.scanning.session.plan import plan_scan
from footscan.scanning.session.states import Snapshot, State
from footscan.workflow.calibration_log import doubts, machine_name, read_log
from footscan.workflow.opened_rig import OpenedRig
from footscan.workflow.process import ProcessSettings
from footscan.workflow.scan import (
    RECORDING,
    RESULTS,
    ScanSettings,
    find_scans,
    measure_recorded,
    prepare_machine,
    process_words,
    record_scan,
    refuse_findings,
    refuse_used_folder,
    scan_folder,
)
from footscan.workflow.visit import Filing, file_scan

FACES = "Is nobody's face at beam height, and may the lasers and the motor be switched on?"


def scan_command(
    side: Annotated[Side, typer.Option(help="Side of the foot.")],
    patient: Annotated[int | None, typer.Option(help="Number of the patient to file the scan for.")] = None,
    load: Annotated[Load, typer.Option(help="Load on the foot.")] = "unknown",
    surface: Annotated[CoverKind, typer.Option(help="What covers the skin.")] = "unknown",
    wedge: Annotated[
        float | None, typer.Option(help="Height in mm of a wedge under the middle of the heel.", min=0, max=100)
    ] = None,
    rig: RigOption = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for recording and results; default: the data folder.")
    ] = None,
    data: DataOption = None,
    profile: Annotated[str | None, typer.Option(help="Profile of the rig file; default: its first.")] = None,
    calibration: Annotated[
        Path | None, typer.Option(help="calibration.toml; default: the one in force in the data folder.")
    ] = None,
    countdown: Annotated[float, typer.Option(help="Seconds between Start and the first beam.", min=0, max=30)] = 3.0,
    button: Annotated[bool, typer.Option("--button", help="Begin when the button on the machine is pressed.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="I have looked: no face is at beam height.")] = False,
    fast: Annotated[bool, typer.Option("--fast", help="Simulated machine: do not wait for the wall clock.")] = False,
    json_only: Annotated[bool, typer.Option("--json", help="Print scan.json and nothing else.")] = False,
) -> None:
    """Scan one foot without a screen and measure it."""
    if patient is not None:
        with opened_store(data) as store:
            store.patient(patient)  # a wrong number is told before anybody steps on
    machine_rig = chosen_rig(rig, fast)
    if button:
        _refuse_without_button(machine_rig)
    in_force = _calibration(machine_rig, calibration, data_folder(data), json_only)
    folder = out if out is not None else scan_folder(data_folder(data) / SCANS, side)
    refuse_used_folder(folder)
    subject = Subject(load=load, surface=surface, wedge_mm=wedge)
    with opened_rig_session(machine_rig, side, in_force) as (_, session):
        plan = plan_scan(machine_rig.motion, _profile(machine_rig, profile), session.facts, machine_rig.scanner)
        process = ProcessSettings(side=side)
        settings = ScanSettings(folder, side, plan, subject, countdown_s=countdown, by_button=button, process=process)
        if not json_only:
            STDOUT.print(plan.sentence())
        _confirm(yes)
        with _what_is_kept(folder):
            _sweep(session, settings, in_force, json_only)
    with _what_is_kept(folder), progress_bar("frames", quiet=json_only) as progress:
        report = measure_recorded(settings, in_force, progress)
    if json_only:
        print_json(report)
    else:
        tell_results(report, folder / RESULTS)
    if patient is not None:
        _file(data, patient, folder)


def _file(data: Path | None, patient: int, folder: Path) -> None:
    with opened_store(data) as store:
        take = file_scan(store, patient, folder, Filing(person(None)))
    STDERR.print(f"Filed as take {take.id} of patient {patient}: see `footscan patients show {patient}`.")


def _sweep(session: Session, settings: ScanSettings, calibration: Calibration, quiet: bool) -> None:
    session.post_arm(no_faces_at_beam_height=True).wait()
    teller = _Teller(quiet)
    findings = prepare_machine(session, settings, teller)
    for finding in findings:
        if not finding.blocking:  # the others are the error that ends it
            STDERR.print(f"{finding.cause}: {finding.sentence}")
    refuse_findings(findings)
    record_scan(session, settings, calibration, teller)


@contextmanager
def _what_is_kept(folder: Path) -> Generator[None]:
    """Whatever ends a scan: where its frames are, and how they become a foot."""
    try:
        yield
    except (FootscanError, KeyboardInterrupt):
        if any((folder / RECORDING / "frames").glob("*.png")):
            STDERR.print(f"What was captured is in {folder}; measure it with: {shlex.join(process_words(folder))}")
        raise


@contextmanager
def opened_rig_session(rig: Rig, side: Side, calibration: Calibration | None) -> Generator[tuple[OpenedRig, Session]]:
    """A rig and a session over its devices; everything is off at the end, however it ends, SIGTERM included."""
    with _signals_end(), ExitStack() as closing:
        opened = rig_app.open_rig(rig, side)
        closing.callback(opened.give_back)
        session = rig_app.start_session(opened, calibration)
        closing.callback(session.close)
        closing.callback(_ignore_signals)  # first of the three: the last frames are being written, no hurry now
        try:
            yield opened, session
        except KeyboardInterrupt:
            raise InterlockError("stopped by Ctrl-C; lasers and motor are off, what was captured is kept.") from None


@contextmanager
def _signals_end() -> Generator[None]:
    """SIGTERM ends what is inside like an error; afterwards both signals do what they did before."""

    def end(number: int, frame: object) -> None:
        raise InterlockError("stopped by SIGTERM; lasers and motor are off, what was captured is kept.")

    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _ignore_signals() -> None:
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, signal.SIG_IGN)


def scans_command(data: DataOption = None, json_only: Annotated[bool, typer.Option("--json")] = False) -> None:
    """List the scans of the data folder; those broken off or not yet processed say how to go on."""
    found = find_scans(data_folder(data) / SCANS)
    if json_only:
        print_json({"scans": [{**vars(item), "folder": str(item.folder)} for item in found]})
        return
    if not found:
        STDOUT.print(f"No scans in {data_folder(data) / SCANS}; make one with: footscan scan --side left")
    for item in found:
        state = "whole" if item.finished else "BROKEN OFF, what was captured is kept"
        STDOUT.print(f"{item.created}  {item.side:5}  {item.frames:4} frames, {state}  {item.folder}")
        if item.trouble:
            STDOUT.print(f"  cannot be read: {item.trouble}")
        elif not item.processed:
            STDOUT.print(f"  not processed yet: {shlex.join(process_words(item.folder))}")


def _refuse_without_button(rig: Rig) -> None:
    io = rig.devices.io
    if not isinstance(io, AdamModel):
        raise InputError("--button is for a machine with a button; nobody can press that of a simulated one.")
    if io.inputs.button is None:
        raise InputError(
            f"{rig.path}: no button is wired; name its input in [devices.io.inputs], or leave --button out."
        )


def _profile(rig: Rig, name: str | None) -> Any:
    try:
        return rig.profile(name)
    except ValueError as err:
        raise InputError(f"{err}; choose one of these.") from None


def _calibration(rig: Rig, given: Path | None, data: Path, quiet: bool) -> Calibration:
    if given is not None:
        return load_calibration(given)
    in_force, word = rig_app.calibration_in_force(rig, data)
    if in_force is None:
        raise ConfigError(f"{word}. Calibrate the machine, or give a file with --calibration.")
    if not quiet:
        STDOUT.print(word)
    _say_doubts(data, in_force)
    return in_force


def _say_doubts(data: Path, calibration: Calibration) -> None:
    """A reminder before a scan; what an intervention or a failed check has made invalid refuses it.

    Raises:
        QualityError: The calibration in force is no longer valid.
    """
    events = read_log(data, machine_name(calibration))
    found = doubts(calibration, events, datetime.now(UTC)) if events else []
    for doubt in found:
        STDERR.print(f"Reminder: {doubt.sentence}")
    blocking = [doubt.sentence for doubt in found if doubt.blocking]
    if blocking:
        raise QualityError(
            f"the calibration in force is not valid: {'; '.join(blocking)}. To scan nevertheless, name it with "
            "--calibration."
        )


def _confirm(yes: bool) -> None:
    if yes:
        return
    confirmed = False
    with suppress(typer.Abort):  # nobody is there to answer
        confirmed = typer.confirm(FACES, default=False, err=True)
    if not confirmed:
        raise InterlockError("not confirmed: lasers and motor stay off; look, then answer y, or give --yes.")


class _Teller:
    """Says each new state and message once."""

    def __init__(self, quiet: bool) -> None:
        self._quiet = quiet
        self._said: tuple[State, str] | None = None

    def __call__(self, snapshot: Snapshot) -> None:
        told = (snapshot.state, snapshot.message)
        if told != self._said and not self._quiet:
            left = f" ({snapshot.remaining_s:.0f} s)" if snapshot.state is State.SCANNING else ""
            STDERR.print(f"{snapshot.message or snapshot.state.value}{left}")
        self._said = told
