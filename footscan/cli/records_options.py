"""Options that the commands on the records share, and opening the store."""

import getpass
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from footscan.errors import InputError
from footscan.records import Patient, RecordStore, Take, data_folder

DataOption = Annotated[Path | None, typer.Option(help="Data folder; default: FOOTSCAN_DATA or the user's.")]
ByOption = Annotated[str | None, typer.Option(help="Who does this; default: the user of this computer.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]


@contextmanager
def opened_store(data: Path | None) -> Generator[RecordStore]:
    """The records of the data folder.

    Raises:
        RecordsError: Another program's database, a newer one, a damaged one, or one kept busy.
        StorageError: The data folder cannot be written.
    """
    with RecordStore(data_folder(data)) as store:
        yield store


def person(by: str | None) -> str:
    """Who does this.

    Raises:
        InputError: Nobody said, and the computer does not know its user.
    """
    if by is not None:
        return by
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):
        raise InputError("this computer does not say who uses it; say it with --by NAME.") from None


def line_of_patient(patient: Patient) -> str:
    """One line for a list."""
    born = "no birth date" if patient.born is None else f"born {patient.born.isoformat()}"
    number = "" if patient.number is None else f"  number {patient.number}"
    return f"{patient.id:5}  {patient.name}  {born}{number}"


def line_of_take(take: Take) -> str:
    """One line for a list: what it is, what it is worth, what to do."""
    words = [f"take {take.id:4}", f"{take.said.side:5}", f"no. {take.number}", f"load {take.said.load}"]
    words += [f"surface {take.said.surface}", take.verdict.replace("_", " ")]
    words += [f"({take.verdict_remark})"] if take.verdict_remark else []
    words += ["IN USE"] if take.in_use else []
    words += [] if take.finished else ["broken off"]
    if take.result is None:
        words.append("not processed")
    elif take.result.refused:
        words.append(f"no foot: {take.result.refused}")
    else:
        values = {value.name: value for value in take.result.measurements}
        length = values["foot_length"].value if "foot_length" in values else None
        words += [f"foot length {length:.1f} mm"] if length is not None else []
    words += [f"STALE: footscan patients reprocess {take.id}"] if take.stale else []
    return "  ".join(words)
