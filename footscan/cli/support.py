"""`footscan support-bundle`: a file to send to whoever helps."""

from pathlib import Path
from typing import Annotated

import typer

from footscan.cli.console import STDOUT
from footscan.config.rig_file import load_rig
from footscan.records.data_folder import data_folder
from footscan.workflow.support_bundle import save_support_bundle


def support_bundle(
    out: Annotated[Path, typer.Option(help="ZIP file to write.")] = Path("footscan-support.zip"),
    rig: Annotated[Path | None, typer.Option(help="Rig file of the machine.")] = None,
    data: Annotated[Path | None, typer.Option(help="Data folder; default: FOOTSCAN_DATA or the user's own.")] = None,
) -> None:
    """Pack versions, rig, calibrations, drift and the machine's log for support; nothing about patients goes in."""
    members = save_support_bundle(data_folder(data), out, None if rig is None else load_rig(rig))
    STDOUT.print(f"{out}: {', '.join(members)}. No patient data; look into it before you send it.")
