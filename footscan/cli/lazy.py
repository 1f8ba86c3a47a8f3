"""Commands that are imported when they are asked for: none waits for what the others need."""

import importlib
from typing import Any

import typer
from typer.core import TyperGroup

PLACES = {
    "serve": "footscan.cli.serve:serve",
    "process": "footscan.cli.process:process",
    "info": "footscan.cli.info:info",
    "measure": "footscan.cli.measure:measure_command",
    "section": "footscan.cli.measure:section_command",
    "scan": "footscan.cli.scan:scan_command",
    "scans": "footscan.cli.scan:scans_command",
    "doctor": "footscan.cli.doctor:doctor",
    "emulate": "footscan.cli.emulate:emulate",
    "simulate": "footscan.cli.simulate:simulate",
    "board": "footscan.cli.calibrate:board",
    "calibrate": "footscan.cli.calibrate:calibrate",
    "accept": "footscan.cli.calibrate:accept",
    "demo": "footscan.cli.simulate:demo",
    "screenshots": "footscan.cli.screenshots:screenshots",
    "support-bundle": "footscan.cli.support:support_bundle",
    "bench": "footscan.cli.bench:bench_app",
    "calibration": "footscan.cli.calibration:calibration_app",
    "drill": "footscan.cli.drill:drill_app",
    "study": "footscan.cli.study:study_app",
    "patients": "footscan.cli.patients:patients_app",
    "lasts": "footscan.cli.lasts:lasts_app",
}
"""Command -> module and name of its function or group, in the order of `footscan --help`."""


class LazyCommands(TyperGroup):
    """The commands of `PLACES`, and those that were registered as usual."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names, in the order of `--help`."""
        return [*PLACES, *(name for name in super().list_commands(ctx) if name not in PLACES)]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Import a command; None when there is no such one."""
        if cmd_name not in PLACES:
            return super().get_command(ctx, cmd_name)
        module, name = PLACES[cmd_name].split(":")
        made = getattr(importlib.import_module(module), name)
        if isinstance(made, typer.Typer):
            made.info.name = cmd_name
            return typer.main.get_group(made)
        alone = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
        alone.command(cmd_name)(made)
        return typer.main.get_command(alone)
