"""A program that is killed cannot switch anything off; the module does."""

import signal
import subprocess
import sys
import time

import pytest

from footscan.config.io_models import AdamModel

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


@pytest.mark.parametrize(("dialect", "baud"), [("adam4055", 115200), ("i7060", 9600)])
def test_lasers_and_motor_of_a_killed_program_go_off(plug_io, dialect, baud):
    io = plug_io(dialect=dialect, baud=baud, checksum=True)
    with start(io.model) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "on\n"
        time.sleep(0.5)
        on = io.panel.outputs
        program.send_signal(signal.SIGKILL)
        killed_s = time.monotonic()
        program.wait()
    time.sleep(1.0)
    off = io.panel.history[-1]

    assert on.laser_right
    assert on.motor_run
    assert not off.outputs.dangerous
    assert 0.0 < off.time_s - killed_s < 1.2
