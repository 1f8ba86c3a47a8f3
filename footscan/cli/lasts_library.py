"""`footscan lasts add | list | show | grade | mirror`."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from footscan.cli.console import STDOUT, print_json, progress_bar
from footscan.cli.records_options import DataOption, JsonOption
from footscan.coordinates import Side
from footscan.records import data_folder
from footscan.shoelast.dimensions import DEFINITIONS
from footscan.shoelast.grade import grade, mirror
from footscan.shoelast.last_library import BUILT_IN, LastEntry, LastLibrary
from footscan.workflow.lasts_import import import_last

Unit = Literal["mm", "cm", "m", "in"]
LASTS = "lasts"
IdArgument = Annotated[str, typer.Argument(metavar="ID", help="As `footscan lasts list` shows it.")]


def opened_library(data: Path | None) -> LastLibrary:
    """The lasts of the data folder."""
    return LastLibrary(data_folder(data) / LASTS)


def add_library_commands(app: typer.Typer) -> None:
    """Register the commands of this file."""
    app.command("add")(add_command)
    app.command("list")(list_command)
    app.command("show")(show_command)
    app.command("grade")(grade_command)
    app.command("mirror")(mirror_command)


def add_command(
    place: Annotated[Path, typer.Argument(metavar="FILE_OR_DIR", help="STL, OBJ, PLY, 3DM, STEP, IGES, or a folder.")],
    side: Annotated[Side, typer.Option(help="Side of the last.")],
    unit: Annotated[Unit | None, typer.Option(help="Unit of the file; 3DM, STEP and IGES state it themselves.")] = None,
    name: Annotated[str | None, typer.Option(help="For people; default: the file's name.")] = None,
    size: Annotated[float | None, typer.Option(help="Paris points, if known.")] = None,
    fitting: Annotated[str, typer.Option(help="Width, as the maker writes it.")] = "",
    style: Annotated[str, typer.Option(help="men, women, therapeutic or a word of your own.")] = "",
    pitch: Annotated[float | None, typer.Option(help="Heel height in mm; default: level under the ball.")] = None,
    replaces: Annotated[str | None, typer.Option(help="Id of a kept last that this is a newer version of.")] = None,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Import a last into the library: repaired, laid into its frame, measured; what was changed is listed."""
    library = opened_library(data)
    with progress_bar("importing", quiet=json_only):
        shoelast = import_last(
            place, side=side, unit=unit, name=name, size_eu=size, fitting=fitting, style=style, pitch_mm=pitch
        )
        entry = library.add(shoelast, str(place.resolve()), replaces)
    if json_only:
        print_json(entry_json(entry))
        return
    STDOUT.print(f"{entry.id}, version {entry.version}")
    _print_entry(entry)


def list_command(
    side: Annotated[Side | None, typer.Option(help="Only this side.")] = None,
    style: Annotated[str | None, typer.Option(help="Only this style.")] = None,
    own: Annotated[bool, typer.Option("--own", help="Leave the built-in family out.")] = False,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """List the lasts: your own and the built-in family."""
    library = opened_library(data)
    found = [
        entry
        for entry in library.entries(built_in=not own)
        if side in (None, entry.side) and style in (None, entry.style)
    ]
    if json_only:
        print_json({"lasts": [entry_json(entry) for entry in found]})
        return
    for entry in found:
        STDOUT.print(_row(entry))
    built_in = sum(entry.source == BUILT_IN for entry in found)
    STDOUT.print(f"{len(found)} lasts: {len(found) - built_in} of your own in {library.folder}, {built_in} built in")


def show_command(last_id: IdArgument, data: DataOption = None, json_only: JsonOption = False) -> None:
    """Dimensions, versions and remarks of one last."""
    library = opened_library(data)
    entry = library.entry(last_id)
    versions = library.versions(last_id)
    if json_only:
        print_json(entry_json(entry) | {"versions": list(versions)})
        return
    _print_entry(entry)
    STDOUT.print(f"Versions: {', '.join(map(str, versions)) or '1 (built in)'}")


def grade_command(
    last_id: IdArgument,
    size: Annotated[float | None, typer.Option(help="Paris points wanted.")] = None,
    widths: Annotated[float, typer.Option(help="Width fittings up (+) or down (-).")] = 0.0,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Make the last in another size or width; its pitch and toe spring stay. The result is a last of its own."""
    library = opened_library(data)
    with progress_bar("grading", quiet=json_only):
        graded = grade(library.load(last_id), size, widths)
        entry = library.add(graded, f"graded from {last_id}")
    _told(entry, json_only)


def mirror_command(last_id: IdArgument, data: DataOption = None, json_only: JsonOption = False) -> None:
    """Make the last of the other foot."""
    library = opened_library(data)
    _told(library.add(mirror(library.load(last_id)), f"mirrored from {last_id}"), json_only)


def _told(entry: LastEntry, json_only: bool) -> None:
    if json_only:
        print_json(entry_json(entry))
        return
    STDOUT.print(f"{entry.id}, version {entry.version}")
    _print_entry(entry)


def entry_json(entry: LastEntry) -> dict[str, Any]:
    """Plain content for `--json`."""
    return asdict(entry) | {"dimensions": dict(entry.dimensions), "remarks": list(entry.remarks)}


def _row(entry: LastEntry) -> str:
    size = "-" if entry.size_eu is None else f"EU {entry.size_eu:g}"
    found = entry.dimensions
    numbers = f"stick {found['stick_length']:6.1f}  ball {found['ball_girth']:6.1f}  pitch {found['pitch']:5.1f}"
    return f"{entry.id:40} {entry.side:5} {size:8} {entry.fitting:4} {numbers}"


def _print_entry(entry: LastEntry) -> None:
    size = "size unknown" if entry.size_eu is None else f"EU {entry.size_eu:g} {entry.fitting}"
    STDOUT.print(f"{entry.name}: {entry.side} last, {size}, {entry.style or 'style unknown'}; from {entry.source}")
    for name, value in entry.dimensions.items():
        unit = "cm3" if name == "volume" else "mm"
        STDOUT.print(f"{name:22}{value:9.2f} {unit:4} {DEFINITIONS[name]}")
    for remark in entry.remarks:
        STDOUT.print(f"Remark: {remark}")
