"""A scan in a process of its own, ended by a signal: what switches the outputs, or its twin, lives in this one."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from footscan.config.rig_file import Rig
from footscan.config.toml_file import read_toml, toml_bytes, write_whole
from footscan.errors import DeviceError, QualityError
from footscan.sim.module_twin import ModuleTwin
from footscan.workflow.drill_result import TARGET_S, WATCHDOG_TARGET_S, DrillResult, frames_on_disk
from footscan.workflow.served_rig import ServedRig

SIGNALS = ("SIGTERM", "kill -9")
PATIENCE_S = 90.0
_LOOK_S = 0.02  # the emulators need this process's time; they note the moments themselves
_AFTER_KILL = "broken off; footscan scans lists it with the command that processes it"


@dataclass(frozen=True)
class Outside:
    """A machine that outlives the program which drives it.

    Attributes:
        options: Of `footscan scan`, to reach it.
        shines: A laser is on.
        off_since_s: Since when lasers and motor have been off, None while one is on.
        kill_target_s: How soon they must be off once nobody drives it.
    """

    options: tuple[str, ...]
    shines: Callable[[], bool]
    off_since_s: Callable[[], float | None]
    kill_target_s: float = TARGET_S


@contextmanager
def mirrored(rig: Rig, place: Path) -> Generator[Outside]:
    """The simulated machine of the program, with a twin of its output module here."""
    table = read_toml(rig.path)
    table["devices"]["world"] |= {"mirror": str(place / "twin"), "time": "real"}
    write_whole(place / "rig.toml", toml_bytes(table))
    with ModuleTwin(place / "twin") as twin:
        yield Outside(
            ("--rig", str(place / "rig.toml")), lambda: len(twin.outputs.lasers) > 0, lambda: twin.off_since_s
        )


def outside(served: ServedRig) -> Outside:
    """A machine of emulators, whose world lives here."""
    world = served.world
    options = ("--rig", str(served.rig_file), "--calibration", str(served.calibration_file))
    return Outside(options, lambda: len(world.outputs().lasers) > 0, lambda: world.off_since_s, WATCHDOG_TARGET_S)


def signalled(case: str, machine: Outside, random: np.random.Generator, place: Path) -> DrillResult:
    """Start a scan, wait for its frames, end it, and look.

    Raises:
        DeviceError: It ended by itself.
        QualityError: It did not begin, or its outputs stayed on.
    """
    command = [sys.executable, "-m", "footscan.cli.main", "scan", "--side", "left", "--yes", "--countdown", "0"]
    command += [*machine.options, "--out", str(place)]
    with (place / "said").open("w") as said:
        program = subprocess.Popen(command, stderr=said, stdout=said, env=os.environ | {"FOOTSCAN_DATA": str(place)})
        try:
            wait_for(lambda: _scanning(program, machine, place), case, _LOOK_S)
            time.sleep(float(random.uniform(0.1, 3.0)))
            at_s = time.monotonic()
            program.send_signal(signal.SIGTERM if case == "SIGTERM" else signal.SIGKILL)
            wait_for(lambda: machine.off_since_s() is not None, case, _LOOK_S)
            off_s = machine.off_since_s()
            program.wait(PATIENCE_S)
        finally:
            program.kill()
    assert off_s is not None
    kept, unlisted = frames_on_disk(place / "recording")
    killed = case == "kill -9"
    told = _AFTER_KILL if killed else _last_line(place)
    target_s = machine.kill_target_s if killed else TARGET_S
    return DrillResult(case, off_s - at_s, told, None, None, kept, unlisted, target_s)


def wait_for(holds: Callable[[], bool], case: str, every_s: float = 0.002) -> None:
    """Until something holds.

    Raises:
        QualityError: It took too long.
    """
    ends_s = time.monotonic() + PATIENCE_S
    while not holds():
        if time.monotonic() > ends_s:
            raise QualityError(f"drill {case!r}: what was waited for did not come within {PATIENCE_S:g} s.")
        time.sleep(every_s)


def _scanning(program: "subprocess.Popen[bytes]", machine: Outside, place: Path) -> bool:
    if program.poll() is not None:
        raise DeviceError(f"the scan to be ended by a signal ended by itself: {_last_line(place)}")
    return machine.shines() and (place / "recording/frames/000010.png").exists()


def _last_line(place: Path) -> str:
    return ((place / "said").read_text().strip().splitlines() or ["it said nothing"])[-1]
