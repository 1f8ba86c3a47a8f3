"""`footscan ...`: the commands, and how errors end: one clear sentence on standard error and an exit status."""

import os
import sys
import traceback
from typing import Any

import cv2
import typer

from footscan.cli.bench import bench_app
from footscan.cli.calibrate import accept, board, calibrate
from footscan.cli.calibration import calibration_app
from footscan.cli.doctor import doctor
from footscan.cli.drill import drill_app
from footscan.cli.emulate import emulate
from footscan.cli.info import info
from footscan.cli.lasts import lasts_app
from footscan.cli.measure import measure_command, section_command
from footscan.cli.patients import patients_app
from footscan.cli.process import process
from footscan.cli.scan import scan_command, scans_command
from footscan.cli.screenshots import screenshots
from footscan.cli.serve import serve
from footscan.cli.simulate import demo, simulate
from footscan.cli.study import study_app
from footscan.cli.support import support_bundle
from footscan.errors import FootscanError

app = typer.Typer(
    name="footscan",
    help="Laser foot scanner: scan, measure, customise.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)
app.command()(serve)
app.command()(process)
app.command()(info)
app.command("measure")(measure_command)
app.command("section")(section_command)
app.command("scan")(scan_command)
app.command("scans")(scans_command)
app.command()(doctor)
app.command()(emulate)
app.command()(simulate)
app.command()(board)
app.command()(calibrate)
app.command()(accept)
app.command()(demo)
app.command("support-bundle")(support_bundle)
app.command()(screenshots)
app.add_typer(bench_app, name="bench")
app.add_typer(calibration_app, name="calibration")
app.add_typer(drill_app, name="drill")
app.add_typer(study_app, name="study")
app.add_typer(patients_app, name="patients")
app.add_typer(lasts_app, name="lasts")


_UsageError = typer.BadParameter.__bases__[0]
"""Of whatever copy of Click this Typer uses."""


def run() -> None:
    """Run the command line; exit status 0 done, 2 wrong use or bad input, 3 device trouble, 4 refused by a gate."""
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)  # its warnings are told in our own words
    try:
        sys.exit(app(prog_name="footscan", standalone_mode=False))
    except FootscanError as err:
        print(f"footscan: {err}", file=sys.stderr)
        sys.exit(err.exit_status)
    except typer.Abort:
        print("footscan: stopped by Ctrl-C, or nobody answered the question.", file=sys.stderr)
        sys.exit(2)
    except Exception as err:  # noqa: BLE001  the last line of defence: nobody should have to read a traceback
        if isinstance(err, _UsageError):
            _tell_usage(err)
            sys.exit(2)
        if os.environ.get("FOOTSCAN_DEBUG"):
            traceback.print_exc()
        what = f"{type(err).__name__}: {err}"
        print(f"footscan: internal error ({what}). Set FOOTSCAN_DEBUG=1, repeat, and report it.", file=sys.stderr)
        sys.exit(1)


def _tell_usage(err: Any) -> None:
    """What is wrong with a command line, and where its options are explained; without arguments, the help."""
    if type(err).__name__ == "NoArgsIsHelpError":
        err.show()
        return
    what = (
        " ".join(str(err.format_message()).split())
        .removeprefix("Invalid value: ")
        .replace("Value error, ", "")
        .rstrip(".")
    )
    command = err.ctx.command_path if err.ctx is not None else "footscan"
    print(f"footscan: {what}. `{command} --help` lists what is allowed.", file=sys.stderr)


if __name__ == "__main__":
    run()
