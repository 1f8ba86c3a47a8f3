"""`footscan patients ...`: people, what is kept of them, and the log."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from footscan.cli.console import STDOUT, print_json
from footscan.cli.patients_takes import (
    correct_command,
    file_command,
    foot_command,
    judge_command,
    reprocess_command,
    use_command,
)
from footscan.cli.records_options import (
    ByOption,
    DataOption,
    JsonOption,
    line_of_patient,
    line_of_take,
    opened_store,
    person,
)
from footscan.config.toml_file import write_whole
from footscan.errors import InputError
from footscan.records import FootFacts, NewPatient, Patient, RecordStore
from footscan.records.spelling import born_from_text

patients_app = typer.Typer(help="Patients, their visits and takes, and the log.", no_args_is_help=True)
PatientArgument = Annotated[int, typer.Argument(help="Number of the patient, as `list` shows it.", metavar="PATIENT")]


@patients_app.command("add")
def add_command(
    name: Annotated[str, typer.Argument(help="Name in any script.")],
    born: Annotated[str | None, typer.Option(help="Date of birth, such as 1962-03-31.")] = None,
    number: Annotated[str | None, typer.Option(help="Your own number of the patient.")] = None,
    notes: Annotated[str, typer.Option(help="Notes.")] = "",
    force: Annotated[bool, typer.Option("--force", help="Another person of the same name and birth date.")] = False,
    by: ByOption = None,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Enter a patient."""
    new = NewPatient(name, None if born is None else born_from_text(born), number, notes)
    with opened_store(data) as store:
        patient = store.add_patient(new, person(by), force=force)
    if json_only:
        print_json(_plain(patient))
    else:
        STDOUT.print(f"Patient {patient.id} added: {patient.name}")


@patients_app.command("list")
def list_command(
    typed: Annotated[str, typer.Argument(help="Part of the name, own number or birth date.")] = "",
    limit: Annotated[int, typer.Option(help="At most so many.", min=1, max=100_000)] = 50,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Find patients by what is typed; case and accents do not matter."""
    with opened_store(data) as store:
        found = store.find_patients(typed, limit)
    if json_only:
        print_json({"patients": [_plain(patient) for patient in found]})
        return
    for patient in found:
        STDOUT.print(line_of_patient(patient))
    if len(found) == limit:
        STDOUT.print(f"The first {limit}; type more of the name, or ask for more with --limit.")
    if not found:
        STDOUT.print("Nobody found; `footscan patients add NAME` enters a patient.")


@patients_app.command("show")
def show_command(patient_id: PatientArgument, data: DataOption = None, json_only: JsonOption = False) -> None:
    """A patient with visits, feet and takes."""
    with opened_store(data) as store:
        patient = store.patient(patient_id)
        if json_only:
            print_json(_plain(patient) | {"visits": _visits(store, patient_id)})
            return
        STDOUT.print(line_of_patient(patient).strip())
        if patient.notes:
            STDOUT.print(patient.notes)
        _tell_visits(store, patient_id)


def _tell_visits(store: RecordStore, patient_id: int) -> None:
    visits = store.visits(patient_id)
    for visit in visits:
        STDOUT.print(f"visit {visit.id} on {visit.day.isoformat()}, {visit.operator}")
        for foot in store.feet(visit.id):
            words = _words_of_foot(foot.facts)
            if words:
                STDOUT.print(f"  {foot.side} foot  {words}")
        for take in store.takes(visit.id):
            STDOUT.print(f"  {line_of_take(take)}")
    if not visits:
        STDOUT.print("No visit yet; `footscan scan`, then `footscan patients file SCAN --patient N`.")


def _words_of_foot(facts: FootFacts) -> str:
    named = {"missing": ", ".join(facts.missing), "dressings": facts.dressings, "deformity": facts.deformity}
    named["not scanned"] = facts.not_scanned
    return "; ".join(f"{what}: {text}" for what, text in named.items() if text)


def _visits(store: RecordStore, patient_id: int) -> list[dict[str, Any]]:
    return [
        {
            "id": visit.id,
            "day": visit.day.isoformat(),
            "feet": [{"side": foot.side, **vars(foot.facts)} for foot in store.feet(visit.id)],
            "takes": [
                {
                    "id": take.id,
                    "side": take.said.side,
                    "number": take.number,
                    "load": take.said.load,
                    "surface": take.said.surface,
                    "verdict": take.verdict,
                    "in_use": take.in_use,
                    "stale": take.stale,
                    "recording": str(store.recording_folder(take.id)),
                    "results": None if take.result is None else str(store.results_folder(take.result.id)),
                    "refused": None if take.result is None else take.result.refused,
                }
                for take in store.takes(visit.id)
            ],
        }
        for visit in store.visits(patient_id)
    ]


@patients_app.command("edit")
def edit_command(
    patient_id: PatientArgument,
    name: Annotated[str | None, typer.Option(help="The right name.")] = None,
    born: Annotated[str | None, typer.Option(help="The right date of birth; empty for unknown.")] = None,
    number: Annotated[str | None, typer.Option(help="Your own number; empty for none.")] = None,
    notes: Annotated[str | None, typer.Option(help="Notes, in place of the old ones.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Another person of the same name and birth date.")] = False,
    by: ByOption = None,
    data: DataOption = None,
) -> None:
    """Change what is kept of a person; what is not given stays."""
    if name is None and born is None and number is None and notes is None:
        raise InputError("nothing to change was given; say --name, --born, --number or --notes.")
    with opened_store(data) as store:
        old = store.patient(patient_id)
        new = NewPatient(
            old.name if name is None else name,
            old.born if born is None else born_from_text(born) if born else None,
            old.number if number is None else number,
            old.notes if notes is None else notes,
        )
        STDOUT.print(line_of_patient(store.edit_patient(patient_id, new, person(by), force=force)).strip())


@patients_app.command("delete")
def delete_command(
    patient_id: PatientArgument,
    reason: Annotated[str, typer.Option(help="Why; it stays in the log.")],
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask.")] = False,
    by: ByOption = None,
    data: DataOption = None,
) -> None:
    """Remove a patient with all visits, takes and files, for good; the log stays and holds no name."""
    with opened_store(data) as store:
        patient, visits = store.patient(patient_id), store.visits(patient_id)
        takes = sum(len(store.takes(visit.id)) for visit in visits)
        question = f"Delete {patient.name} with {len(visits)} visits and {takes} takes, for good?"
        if not yes and not typer.confirm(question, default=False, err=True):
            raise InputError("not confirmed; nothing was deleted.")
        store.delete_patient(patient_id, reason, person(by))
    STDOUT.print(f"Patient {patient_id} deleted.")


@patients_app.command("export")
def export_command(
    patient_id: PatientArgument,
    out: Annotated[Path | None, typer.Option(help="File to write; default: standard output.")] = None,
    purpose: Annotated[str, typer.Option(help="What for; it stays in the log.")] = "",
    by: ByOption = None,
    data: DataOption = None,
) -> None:
    """Everything kept of one patient as JSON. The log says who took it."""
    if out is not None and out.exists():
        raise InputError(f"{out} is there already; choose another name, nothing is overwritten.")
    with opened_store(data) as store:
        content = store.export_patient(patient_id, person(by), purpose)
    if out is None:
        print_json(content)
        return
    write_whole(out, (json.dumps(content, indent=1, ensure_ascii=False) + "\n").encode())
    out.chmod(0o600)
    STDOUT.print(f"Patient {patient_id} written to {out}; it holds personal data.")


@patients_app.command("log")
def log_command(
    patient_id: Annotated[int | None, typer.Argument(help="Of one patient, also a deleted one.")] = None,
    limit: Annotated[int, typer.Option(help="The latest so many lines.", min=1, max=1_000_000)] = 100,
    data: DataOption = None,
) -> None:
    """The log, the latest line first. Nobody can change it."""
    with opened_store(data) as store:
        for entry in store.audit(patient_id, limit):
            patient = "" if entry.patient_id is None else f"patient {entry.patient_id}, "
            subject = patient if entry.subject in patient else f"{patient}{entry.subject}"
            why = f" ({entry.reason})" if entry.reason else ""
            detail = f"  {json.dumps(dict(entry.detail))}" if entry.detail else ""
            STDOUT.print(
                f"{entry.at:%Y-%m-%d %H:%M:%S}  {entry.by}: {entry.action}, {subject.rstrip(', ')}{why}{detail}"
            )


@patients_app.command("leftovers")
def leftovers_command(
    remove: Annotated[str | None, typer.Option(help="Name of a leftover to remove for good.")] = None,
    reason: Annotated[str, typer.Option(help="Why it is removed; it stays in the log.")] = "",
    by: ByOption = None,
    data: DataOption = None,
) -> None:
    """Copies that a killed program left behind; none belongs to a take, and its source was not given up."""
    with opened_store(data) as store:
        if remove is not None:
            store.remove_leftover(remove, reason, person(by))
            STDOUT.print(f"Removed {remove}.")
            return
        found = store.find_leftovers()
        for leftover in found:
            STDOUT.print(f"{leftover.kind}  {leftover.size_bytes / 1e6:.1f} MB  {leftover.folder}")
    if found:
        STDOUT.print("Remove one with: footscan patients leftovers --remove NAME --reason WHY")
    else:
        STDOUT.print("No leftovers.")


@patients_app.command("check")
def check_command(data: DataOption = None) -> None:
    """Check the database and read every kept file again."""
    with opened_store(data) as store:
        problems = store.check_records()
    for problem in problems:
        STDOUT.print(problem)
    if problems:
        raise InputError(f"{len(problems)} problems in the records; see above.")
    STDOUT.print("The records are whole.")


def _plain(patient: Patient) -> dict[str, Any]:
    born = None if patient.born is None else patient.born.isoformat()
    created = patient.created.isoformat()
    return {"id": patient.id, "name": patient.name, "born": born, "number": patient.number,
            "notes": patient.notes, "created": created}  # fmt: skip


patients_app.command("file")(file_command)
patients_app.command("foot")(foot_command)
patients_app.command("correct")(correct_command)
patients_app.command("reprocess")(reprocess_command)
patients_app.command("judge")(judge_command)
patients_app.command("use")(use_command)
