"""`footscan lasts export`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from footscan.cli.console import STDOUT, print_json, progress_bar
from footscan.cli.lasts_library import opened_library
from footscan.cli.records_options import DataOption, JsonOption
from footscan.workflow.lasts_export import ExportWish, export_last, last_to_export

Format = Literal["stl", "obj", "ply", "3dm", "step", "iges", "dxf", "json", "pdf"]
_OUT = "File to write; its ending says the kind: stl obj ply 3dm step iges dxf json, or pdf for the sheet alone."


def add_export_commands(app: typer.Typer) -> None:
    """Register the command of this file."""
    app.command("export")(export_command)


def export_command(
    what: Annotated[str, typer.Argument(metavar="ID_OR_DIR", help="Id of the library, or a folder of customise.")],
    out: Annotated[Path, typer.Option(help=_OUT)],
    kind: Annotated[Format | None, typer.Option("--format", help="Kind, where the ending does not say it.")] = None,
    stub: Annotated[bool, typer.Option("--stub", help="Give the chuck stub back: joined in stl and ply.")] = False,
    stub_apart: Annotated[bool, typer.Option("--stub-apart", help="The stub as a body of its own.")] = False,
    engrave: Annotated[str, typer.Option(help="Text cut 0.6 mm into the cone top: order, side, size.")] = "",
    sheet: Annotated[Literal["a3", "a4"] | None, typer.Option(help="Also the last maker's sheet at 1:1.")] = None,
    order: Annotated[str, typer.Option(help="Order number for sheet and file heads; no patient's name.")] = "",
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Write a last for mill, CAD or bench: the real side, mm, with its datum; checked as it is written."""
    path = out if kind is None else out.with_name(f"{out.name.removesuffix(out.suffix)}.{kind}")
    wish = ExportWish(stub or stub_apart, stub_apart, engrave, sheet, order)
    with progress_bar("exporting", quiet=json_only):
        done = export_last(last_to_export(opened_library(data), what, wish.stub), path, wish)
    if json_only:
        print_json({"files": [str(file) for file in done.files], "found": list(done.found)})
        return
    for file in done.files:
        STDOUT.print(str(file))
    for words in done.found:
        STDOUT.print(words)
