"""`footscan emulate`: a machine of emulators for another program, broken by typing."""

import sys
import tempfile
import threading
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any

import typer

from footscan import app as rig_app
from footscan.cli.console import STDERR, STDOUT
from footscan.config.rig_file import load_rig
from footscan.sim.emulators.emulated_rig import FAULTS
from footscan.sim.emulators.server import WORLD_FAULTS
from footscan.workflow.designs import builtin_config
from footscan.workflow.served_rig import ServedRig

_WORDS = "inject FAULT, mend, state, end"


def emulate(
    rig: Annotated[
        Path | None, typer.Option(help="Rig file with emulated devices; default: configs/rig-emulated.toml.")
    ] = None,
    links: Annotated[
        Path | None, typer.Option(help="Folder for the links to the ports and the files; default: a new one.")
    ] = None,
) -> None:
    """Run emulated devices behind real ports until Ctrl-C; faults are typed in."""
    chosen = load_rig(rig if rig is not None else builtin_config("rig-emulated"))
    with ExitStack() as ending:
        folder = links or Path(ending.enter_context(tempfile.TemporaryDirectory(prefix="footscan-machine-")))
        served = ending.enter_context(rig_app.serve_emulators(chosen, folder))
        _tell(served)
        threading.Thread(target=_listen, args=(served,), name="typed", daemon=True).start()
        try:
            served.server.wait()
        except KeyboardInterrupt:
            STDERR.print("ended by Ctrl-C; the ports are gone.")


def _tell(served: ServedRig) -> None:
    STDOUT.print("In a rig file:")
    for device, (key, path) in served.places.items():
        STDOUT.print(f'  [devices.{device}]  {key} = "{path}"')
    STDOUT.print("and no [devices.world]. Such a file and the simulated machine's calibration are written already:")
    STDOUT.print(f"  footscan doctor --rig {served.rig_file}")
    STDOUT.print(f"  footscan scan --rig {served.rig_file} --calibration {served.calibration_file} --side left")
    STDOUT.print(f"Type {_WORDS}. FAULT is one of {', '.join((*FAULTS, *WORLD_FAULTS))}. Ctrl-C ends it.")


def _listen(served: ServedRig) -> None:
    """Obey typed lines; where nobody can type, go on without."""
    for line in sys.stdin:
        if not line.split():
            continue
        try:
            reply = served.server.obey(line)
        except ValueError as err:
            STDERR.print(str(err))
            continue
        STDOUT.print(_spoken(reply))


def _spoken(state: dict[str, Any]) -> str:
    lasers = " and ".join(state["lasers"]) or "no"
    motor = "runs" if state["motor"] else "is off"
    since_s = state["off_since_s"]
    dark = "" if since_s is None else f"; lasers and motor have been off for {state['now_s'] - since_s:.1f} s"
    return f"{lasers} laser is on, the motor {motor}, the head stands at {state['theta_deg']:.1f} degrees{dark}"
