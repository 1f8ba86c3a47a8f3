"""`footscan doctor`."""

from typing import Annotated

import typer

from footscan import app as rig_app
from footscan.cli.console import STDOUT, print_json
from footscan.cli.records_options import DataOption
from footscan.cli.rig_option import RigOption, chosen_rig
from footscan.devices.diagnosis import Finding
from footscan.errors import DeviceError
from footscan.records.data_folder import SCANS, data_folder
from footscan.workflow.doctor import examine_computer

_MARKS = {"good": "ok     ", "remark": "remark ", "trouble": "TROUBLE"}


def doctor(
    rig: RigOption = None,
    data: DataOption = None,
    json_only: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Check every device, the calibration and the disk, and say in words what is wrong; nothing is switched on."""
    chosen = chosen_rig(rig, fast=False)
    folder = data_folder(data)
    found: list[Finding] = []

    def tell(finding: Finding) -> None:
        found.append(finding)
        if not json_only:
            STDOUT.print(f"{_MARKS[finding.grade]} {finding.device:12} {finding.sentence}")

    in_force, word = rig_app.calibration_in_force(chosen, folder)
    for finding in examine_computer(folder, folder / SCANS, in_force, word):
        tell(finding)
    for finding in rig_app.examine_devices(chosen):
        tell(finding)
    troubles = [finding for finding in found if finding.grade == "trouble"]
    if json_only:
        print_json({"rig": str(chosen.path), "findings": [vars(finding) for finding in found]})
    elif not troubles:
        STDOUT.print("Everything is in order.")
    if troubles:
        more = f" ({len(troubles) - 1} more of such trouble)" if len(troubles) > 1 else ""
        raise DeviceError(f"{troubles[0].device}: {troubles[0].sentence}{more}")
