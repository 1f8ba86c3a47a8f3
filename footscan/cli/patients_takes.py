"""`footscan patients file|foot|correct|reprocess|judge|use`: scans of a patient."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from footscan.cli.console import STDOUT, progress_bar
from footscan.cli.process import parse_threshold
from footscan.cli.records_options import ByOption, DataOption, line_of_take, opened_store, person
from footscan.config.recording_file import Load
from footscan.config.recording_file import Surface as CoverKind
from footscan.coordinates import Side
from footscan.errors import InputError, QualityError
from footscan.records import Correction, FootFacts, RecordStore, Take, Verdict
from footscan.workflow.process import ProcessSettings
from footscan.workflow.visit import Filing, correct_take, declare_foot, file_scan, reprocess_take
from footscan.workflow.visit_result import settings_of_result

TakeArgument = Annotated[int, typer.Argument(help="Number of the take, as `show` says it.", metavar="TAKE")]
CalibrationOption = Annotated[Path | None, typer.Option(help="calibration.toml; default: the one kept.")]


def file_command(
    scan: Annotated[Path, typer.Argument(help="Scan folder, as `footscan scans` lists it, or a recording.")],
    patient: Annotated[int, typer.Option(help="Number of the patient.")],
    side: Annotated[Side | None, typer.Option(help="Side of the foot; default: the recording's.")] = None,
    load: Annotated[Load | None, typer.Option(help="Load on the foot; default: the recording's.")] = None,
    surface: Annotated[CoverKind | None, typer.Option(help="What covers the skin; default: the recording's.")] = None,
    calibration: Annotated[
        Path | None, typer.Option(help="calibration.toml of the machine; default: the scan folder's.")
    ] = None,
    unfinished: Annotated[bool, typer.Option("--unfinished", help="Accept a scan that was broken off.")] = False,
    process: Annotated[bool, typer.Option(help="Process the scan when it has no results that fit.")] = True,
    by: ByOption = None,
    data: DataOption = None,
) -> None:
    """File a scan for a patient. A scan of the data folder is taken over, any other is copied."""
    filing = Filing(person(by), side, load, surface, unfinished, process)
    with opened_store(data) as store, progress_bar("frames", quiet=False) as progress:
        take = file_scan(store, patient, scan, filing, calibration, progress)
    _tell(take)


def foot_command(
    visit: Annotated[int, typer.Argument(help="Number of the visit.", metavar="VISIT")],
    side: Annotated[Side, typer.Option(help="Side of the foot.")],
    missing: Annotated[list[str] | None, typer.Option(help="A missing part, such as toe_1; repeatable.")] = None,
    dressings: Annotated[str | None, typer.Option(help="What covers it and where.")] = None,
    deformity: Annotated[str | None, typer.Option(help="Declared deformity.")] = None,
    not_scanned: Annotated[str | None, typer.Option(help="Why this foot is not scanned.")] = None,
    by: ByOption = None,
    data: DataOption = None,
) -> None:
    """Say what is missing, dressed or deformed on a foot; what is not given stays. Takes it changes are processed."""
    with opened_store(data) as store, progress_bar("frames", quiet=False) as progress:
        known = next((foot.facts for foot in store.feet(visit) if foot.side == side), FootFacts())
        given = {"dressings": dressings, "deformity": deformity, "not_scanned": not_scanned}
        said = {name: text for name, text in given.items() if text is not None}
        parts = known.missing if missing is None else tuple(part for part in missing if part)
        facts = replace(known, missing=parts, **said)
        declare_foot(store, visit, side, facts, person(by), progress)
    STDOUT.print(f"Visit {visit}, {side} foot: noted.")


def correct_command(
    take: TakeArgument,
    reason: Annotated[str, typer.Option(help="Why; it stays in the log.")],
    patient: Annotated[int | None, typer.Option(help="The right patient.")] = None,
    side: Annotated[Side | None, typer.Option(help="The right side.")] = None,
    load: Annotated[Load | None, typer.Option(help="The right load.")] = None,
    surface: Annotated[CoverKind | None, typer.Option(help="What really covered the skin.")] = None,
    by: ByOption = None,
    data: DataOption = None,
) -> None:
    """Put right a wrong patient, side, load or surface; what no longer fits is processed again."""
    right = Correction(patient, side, load, surface)
    if right == Correction():
        raise InputError("nothing to correct was given; say --patient, --side, --load or --surface.")
    with opened_store(data) as store, progress_bar("frames", quiet=False) as progress:
        _tell(correct_take(store, take, right, reason, person(by), progress))


def reprocess_command(
    take: TakeArgument,
    threshold: Annotated[str | None, typer.Option(help="auto or a grey value; default: as before.")] = None,
    calibration: CalibrationOption = None,
    reason: Annotated[str, typer.Option(help="Why; it stays in the log.")] = "",
    by: ByOption = None,
    data: DataOption = None,
) -> None:
    """Process a take again without the patient; earlier results stay."""
    with opened_store(data) as store, progress_bar("frames", quiet=False) as progress:
        settings = _with_threshold(store, take, threshold)
        who = person(by)
        done = reprocess_take(store, take, who, reason, settings=settings, calibration=calibration, progress=progress)
    _tell(done)


def _with_threshold(store: RecordStore, take_id: int, threshold: str | None) -> ProcessSettings | None:
    if threshold is None:
        return None
    result = store.take(take_id).result
    settings = ProcessSettings() if result is None else settings_of_result(result)
    return replace(settings, sweep=replace(settings.sweep, threshold=parse_threshold(threshold)))


def judge_command(
    take: TakeArgument,
    verdict: Annotated[Verdict, typer.Argument(help="accepted, with_remark or repeat.")],
    remark: Annotated[str, typer.Option(help="Needed for with_remark and repeat.")] = "",
    by: ByOption = None,
    data: DataOption = None,
) -> None:
    """Say what a take is worth."""
    with opened_store(data) as store:
        STDOUT.print(line_of_take(store.judge_take(take, verdict, person(by), remark)))


def use_command(take: TakeArgument, by: ByOption = None, data: DataOption = None) -> None:
    """Mark a take as the one in use for its foot and load."""
    with opened_store(data) as store:
        STDOUT.print(line_of_take(store.use_take(take, person(by))))


def _tell(take: Take) -> None:
    """Say what became of a take; a foot that cannot be measured is the gate's word, exit status 4."""
    STDOUT.print(f"patient {take.patient_id}  {line_of_take(take)}")
    if take.result is not None and take.result.refused:
        raise QualityError(take.result.refused)
