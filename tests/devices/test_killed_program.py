"""A program that is killed cannot switch anything off; the module does."""

import signal
import subprocess
import sys
import time

import pytest

from footscan.config.io_models import AdamModel
from footscan.devices.values import Outputs

DRIVING = """
import sys, time
from footscan.config.io_models import AdamModel
from footscan.devices.adam_io import AdamIo
from footscan.devices.values import Outputs
module = AdamIo(AdamModel.model_validate_json(sys.argv[1], strict=False))
module.arm_watchdog(0.3)
module.set_outputs(Outputs(laser_right=True, laser_left=True, motor_run=True))
print("on", flush=True)
while True:
    module.read_inputs()
    module.feed_watchdog()
    time.sleep(0.01)
"""


def start(model: AdamModel) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", DRIVING, model.model_dump_json()]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def killed_while_on(io) -> tuple[Outputs, float] | None:
    """What was on when the program was killed, and when that was; None if the module had tripped before.

    The program may be held up by a busy computer for longer than its watchdog allows: then nothing is on to be seen.
    """
    with start(io.model) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "on\n"
        on = io.panel.outputs
        killed_s = time.monotonic()
        program.send_signal(signal.SIGKILL)
        program.wait()
    return (on, killed_s) if on.dangerous and io.panel.history[-1].time_s < killed_s else None


@pytest.mark.parametrize(("dialect", "baud"), [("adam4055", 115200), ("i7060", 9600)])
def test_lasers_and_motor_of_a_killed_program_go_off(plug_io, dialect, baud):
    io = plug_io(dialect=dialect, baud=baud, checksum=True)
    on, killed_s = next(seen for _ in range(6) if (seen := killed_while_on(io)) is not None)
    ends_s = time.monotonic() + 20.0
    while io.panel.outputs.dangerous and time.monotonic() < ends_s:
        time.sleep(0.02)
    off = io.panel.history[-1]

    assert on.laser_right
    assert on.motor_run
    assert not off.outputs.dangerous
    assert 0.0 < off.time_s - killed_s < 1.2  # as the emulator notes it: its own watchdog, 0.3 s
