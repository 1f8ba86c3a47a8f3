"""A visit end to end: a scan filed for a patient, processed again, put where it belongs, with results that fit."""

from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from footscan.config import load_calibration
from footscan.config.recording_file import Load, Surface
from footscan.coordinates import Side
from footscan.errors import InputError, MeshError, QualityError
from footscan.foot.standing import PARTS
from footscan.records import Correction, Foot, FootFacts, NewTake, RecordStore, Take
from footscan.scanning.recording import Recording, open_recording
from footscan.scanning.sweep import Progress
from footscan.workflow.process import ProcessSettings, ScanResult, process_recording
from footscan.workflow.results import save_results
from footscan.workflow.scan import CALIBRATION, RECORDING, RESULTS
from footscan.workflow.visit_result import result_from_folder, settings_of_result


def _silent(done: int, total: int) -> None:
    del done, total


@dataclass(frozen=True)
class Filing:
    """What the operator says when a scan is filed; None takes the recording's word.

    Attributes:
        operator: Who scanned.
        side: Of the foot.
        load: On the foot.
        surface: What covers the skin.
        unfinished: Accept a recording that was broken off.
        process: Process the scan when it has no results that fit.
    """

    operator: str
    side: Side | None = None
    load: Load | None = None
    surface: Surface | None = None
    unfinished: bool = False
    process: bool = True


def file_scan(
    store: RecordStore,
    patient_id: int,
    place: Path,
    filing: Filing,
    calibration: Path | None = None,
    progress: Progress = _silent,
) -> Take:
    """File a scan for a patient, with its results; results that are missing or do not fit are made.

    Args:
        store: The records.
        patient_id: The patient.
        place: A scan folder (`recording/`, and if there are `results/` and `calibration.toml`), or a bare recording.
            One of the data folder's own scans is taken over, any other is copied.
        filing: What the operator says.
        calibration: The machine's calibration; None takes the scan folder's.
        progress: Told of frames done.

    Raises:
        InputError: No such patient, the recording cannot be read, nobody said the side, or it is filed already.
        StorageError: The disk is full or cannot be written.
        FootscanError: As `process_recording`; the take is filed all the same.
    """
    scan = _scan_at(place)
    if calibration is None and scan.calibration.is_file():
        calibration = scan.calibration
    recording = open_recording(scan.recording)
    said = _said(recording, filing)
    result = result_from_folder(scan.results) if (scan.results / "scan.json").is_file() else None
    if result is None and filing.process and calibration is None:
        raise InputError(f"{place} has no results and no {CALIBRATION}; give the machine's file with --calibration.")
    if calibration is not None:
        load_calibration(calibration)
    results = None if result is None else scan.results
    take = store.file_take(patient_id, said, scan.recording, result, results, calibration, unfinished=filing.unfinished)
    take = _declare_missing(store, take, recording.info.subject.absent, filing.operator)
    if filing.process and (take.result is None or take.stale):
        return reprocess_take(store, take.id, filing.operator, progress=progress)
    return take


@dataclass(frozen=True)
class _Scan:
    """Where the parts of a scan lie; results and calibration need not be there."""

    recording: Path
    results: Path
    calibration: Path


def _scan_at(place: Path) -> _Scan:
    if (place / RECORDING).is_dir():
        return _Scan(place / RECORDING, place / RESULTS, place / CALIBRATION)
    nowhere = place / ".no-scan-folder"
    return _Scan(place, nowhere, nowhere)


def _said(recording: Recording, filing: Filing) -> NewTake:
    info, subject = recording.info, recording.info.subject
    side = filing.side or info.side
    if side == "none":
        raise InputError(f"{recording.folder} does not say which foot it shows; say it with --side left or right.")
    return NewTake(
        side=side,
        operator=filing.operator,
        recorded=datetime.fromisoformat(info.created).astimezone(),
        load=filing.load or subject.load,
        surface=filing.surface or subject.surface,
        load_kg=subject.load_kg,
        surface_mm=subject.surface_mm,
        wedge_mm=subject.wedge_mm,
        machine=recording.scanner.machine_id or recording.scanner.name,
    )


def _declare_missing(store: RecordStore, take: Take, absent: tuple[str, ...], by: str) -> Take:
    """What the recording says is missing is declared of the foot, unless a person has spoken of it already."""
    foot = next(foot for foot in store.feet(take.visit_id) if foot.id == take.foot_id)
    if absent and not foot.facts.missing:
        store.declare_foot(take.visit_id, foot.side, replace(foot.facts, missing=absent), by)
    return store.take(take.id)


def reprocess_take(
    store: RecordStore,
    take_id: int,
    by: str,
    reason: str = "",
    *,
    settings: ProcessSettings | None = None,
    calibration: Path | None = None,
    progress: Progress = _silent,
) -> Take:
    """Process a take again, without the patient; the new result counts, earlier ones stay.

    Side, load, surface, missing parts and landmarks by hand are always those of the records. A result in which no foot
    can be measured is filed too, with `refused` saying why.

    Args:
        store: The records.
        take_id: The take.
        by: Who wants it.
        reason: Why.
        settings: Threshold, filters and the like; None takes those of the latest result.
        calibration: Another calibration; None takes the one of the latest result.
        progress: Told of frames done.

    Raises:
        InputError: No such take, or no calibration is kept with it.
        FootscanError: As `process_recording`; nothing is filed then.
    """
    take = store.take(take_id)
    calibration = calibration or store.calibration_file(take_id)
    if calibration is None:
        raise InputError(f"take {take_id} was filed without a calibration; give the machine's with --calibration.")
    machine = load_calibration(calibration)
    if settings is None:
        settings = ProcessSettings() if take.result is None else settings_of_result(take.result)
    settings = _as_recorded(take, settings)
    with store.workspace() as place:
        named = place / f"take-{take_id}-{take.said.side}"  # reports are titled by the folder's name
        named.symlink_to(store.recording_folder(take_id).resolve())
        made = process_recording(open_recording(named), machine, settings, progress)
        _save(made, settings, place / RESULTS)
        result = result_from_folder(place / RESULTS)
        return store.file_result(take_id, result, place / RESULTS, calibration, by, reason)


def _as_recorded(take: Take, settings: ProcessSettings) -> ProcessSettings:
    return replace(
        settings,
        side=take.said.side,
        load=take.said.load,
        surface=take.said.surface,
        absent=take.missing,
        landmarks={mark.name: mark.xyz_world for mark in take.landmarks},
    )


def _save(made: ScanResult, settings: ProcessSettings, folder: Path) -> None:
    """Write the results; a refusal is one of them, because scan.json says it."""
    try:
        save_results(made, settings, folder)
    except (MeshError, QualityError):
        if not (folder / "scan.json").is_file():
            raise


def correct_take(
    store: RecordStore, take_id: int, right: Correction, reason: str, by: str, progress: Progress = _silent
) -> Take:
    """Put right a wrong patient, side, load or surface, and process again what no longer fits.

    Raises:
        InputError: As `RecordStore.correct_take`, or the take has no calibration to be processed with.
        FootscanError: As `process_recording`; the correction stands, and the take stays `stale` until it is processed.
    """
    take = store.correct_take(take_id, right, reason, by)
    return reprocess_take(store, take_id, by, reason, progress=progress) if take.stale else take


def declare_foot(
    store: RecordStore, visit_id: int, side: Side, facts: FootFacts, by: str, progress: Progress = _silent
) -> Foot:
    """Say what is missing, dressed or deformed on a foot; takes it changes are processed again.

    Raises:
        InputError: No such visit, or a missing part that has no name in `PARTS`.
        FootscanError: As `process_recording`; the declaration stands.
    """
    for part in facts.missing:
        if part not in PARTS:
            raise InputError(f"the missing part is {part!r}; allowed are {', '.join(PARTS)}.")
    foot = store.declare_foot(visit_id, side, facts, by)
    for take in store.takes(visit_id):
        if take.foot_id == foot.id and take.stale:
            reprocess_take(store, take.id, by, "missing parts were declared", progress=progress)
    return foot
