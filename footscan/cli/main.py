"""`footscan ...`: the commands, and how errors end: one clear sentence on standard error and an exit status."""

import os
import sys
import traceback
from typing import Any

import typer

from footscan.cli.lazy import LazyCommands
from footscan.errors import FootscanError

app = typer.Typer(
    name="footscan",
    cls=LazyCommands,
    help="Laser foot scanner: scan, measure, customise.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)


@app.callback()
def _commands() -> None:
    """Laser foot scanner: scan, measure, customise."""


_UsageError = typer.BadParameter.__bases__[0]
"""Of whatever copy of Click this Typer uses."""


def run() -> None:
    """Run the command line; exit status 0 done, 2 wrong use or bad input, 3 device trouble, 4 refused by a gate."""
    os.environ.setdefault("OPENCV_LOG_LEVEL", "ERROR")  # its warnings are told in our own words
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
