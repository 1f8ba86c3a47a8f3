"""Scans of a test body at a machine, for acceptance and the daily check."""

from dataclasses import replace
from pathlib import Path

import typer

from footscan.cli.console import STDERR, STDOUT
from footscan.cli.scan import FACES, opened_rig_session
from footscan.config.artefact_file import Artefact, artefact_toml, load_artefact
from footscan.config.rig_file import Rig
from footscan.config.toml_file import write_whole
from footscan.errors import InputError, InterlockError
from footscan.optics.calibration import Calibration
from footscan.scanning.session.plan import plan_scan
from footscan.scanning.session.states import Snapshot, State
from footscan.sim.artefacts import build_artefact
from footscan.workflow.scan import (
    RECORDING,
    ScanSettings,
    prepare_machine,
    record_scan,
    refuse_findings,
    refuse_used_folder,
)

USUAL_BODY = "ball-bar"
_OF_FEET = ("no foot", "foot partly out of view", "foot off centre")
"""What the check before a scan finds where no foot stands."""


def record_body(rig: Rig, folder: Path, calibration: Calibration, artefact_file: Path | None, yes: bool) -> Path:
    """Scan a test body; returns the folder of the recording, which holds its artefact.toml.

    Raises:
        InputError: Nobody said what the body is.
        QualityError: The check before the scan found something that would spoil it.
        DeviceError: A device is in trouble, or nobody confirmed that the machine may move.
    """
    artefact = _artefact(rig, artefact_file)
    refuse_used_folder(folder)
    STDOUT.print(f"Put the {artefact.kind} on the footboard, its middle near the axis. Step back.")
    if not yes and not typer.confirm(f"Done? {FACES}", default=False, err=True):
        raise InterlockError("not confirmed: lasers and motor stay off.")
    write_whole(folder / RECORDING / "artefact.toml", artefact_toml(artefact))
    with opened_rig_session(_with_body(rig, artefact), "left", calibration) as (_, session):
        plan = plan_scan(rig.motion, rig.profile(None), session.facts, rig.scanner)
        settings = ScanSettings(folder, "left", plan, notes=_notes(rig, artefact), countdown_s=0.0)
        session.post_arm(no_faces_at_beam_height=True).wait()
        teller = _Teller()
        refuse_findings([f for f in prepare_machine(session, settings, teller) if f.cause not in _OF_FEET])
        return record_scan(session, settings, calibration, teller)


def _artefact(rig: Rig, path: Path | None) -> Artefact:
    """What stands there: by its file, or on a simulated machine the usual ball bar."""
    if path is not None:
        return load_artefact(path)
    if rig.devices.world is None:
        raise InputError("say with --artefact what the test body is (kind, diameters_mm, spacing_mm).")
    body = build_artefact(USUAL_BODY)
    return Artefact("ball-bar", body.diameters_mm, body.spacing_mm, "of the simulated machine")


def _notes(rig: Rig, artefact: Artefact) -> str:
    """For recording.toml: acceptance says of what its figures are."""
    return f"{'test body' if rig.devices.world is None else 'simulated test body'}: {artefact.kind}"


def _with_body(rig: Rig, artefact: Artefact) -> Rig:
    """The body on a simulated footboard, at rest; a real rig is what it is."""
    if rig.devices.world is None:
        return rig
    world = rig.devices.world.model_copy(update={"object": artefact.kind, "person": "statue"})
    return replace(rig, devices=rig.devices.model_copy(update={"world": world}))


class _Teller:
    """Says each new state once."""

    def __init__(self) -> None:
        self._state: State | None = None

    def __call__(self, snapshot: Snapshot) -> None:
        if snapshot.state is not self._state and snapshot.state in (State.HOMING, State.CHECKING, State.SCANNING):
            STDERR.print(snapshot.state.value)
        self._state = snapshot.state
