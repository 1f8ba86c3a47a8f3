from collections.abc import Callable
from pathlib import Path

import pytest

from footscan.config.io_models import AdamModel
from footscan.config.rig_file import load_rig
from footscan.errors import ConfigError
from footscan.workflow.designs import builtin_config

RIGS = ["rig-qsb-adam", "rig-dcon", "rig-emulated", "sim"]
Edit = Callable[[str, str, str], Path]


@pytest.fixture
def edited(tmp_path) -> Edit:
    def edit(name: str, old: str, new: str) -> Path:
        text = builtin_config(name).read_text()
        assert old in text
        path = tmp_path / f"{name}.toml"
        path.write_text(text.replace(old, new, 1))
        return path

    return edit


@pytest.mark.parametrize("name", RIGS)
def test_the_rigs_we_ship_are_valid(name):
    rig = load_rig(builtin_config(name))

    assert rig.devices.emulated == (name == "rig-emulated")
    assert rig.devices.simulated == (name == "sim")


def test_wiring_is_read_by_name():
    io = load_rig(builtin_config("rig-emulated")).devices.io

    assert isinstance(io, AdamModel)
    assert io.outputs.channels["speed1"] == 5
    assert io.watchdog == "adam"
    assert io.inputs.channels == {"estop_ok": 0, "home": 1, "button": 2}


@pytest.mark.parametrize(
    ("name", "old", "new", "says"),
    [
        (
            "rig-emulated",
            'kind = "qsb"',
            'kind = "hctl"',
            '"devices.encoder.kind" is "hctl", allowed is "simulated", "qsb"',
        ),
        ("rig-emulated", "checksum = true", "chksum = true", 'devices.io.chksum" is unknown'),
        ("rig-emulated", 'port = "emulated"\nbaud', 'port = "COM3"\nbaud', "a path such as /dev/serial/by-id/"),
        ("rig-emulated", "[devices.world]", "[devices.wrld]", 'devices.wrld" is unknown'),
        ("rig-emulated", 'time = "real"', 'time = "fast"', "emulated devices speak at their real speed"),
        ("rig-emulated", "buzzer = 7", "buzzer = 8", "buzzer is on output 8, adam4055 has outputs 0 to 7"),
        ("rig-emulated", "buzzer = 7", "buzzer = 6", "lamp and buzzer share output 6"),
        ("rig-emulated", "button = 2", 'button = 2\ninverted = ["laser"]', "inverted"),
        ("rig-emulated", "speed = [4, 5]", "speed = [4]", "3 speeds_deg_per_s need 2 speed outputs, 1 are wired"),
        ("rig-emulated", "frames_per_s = 25.0", "frames_per_s = 12.5", "12.5 must be a whole number for a V4L2 camera"),
        ("rig-emulated", "exposure_s = 0.004", "exposure_s = 0.05", "longer than a frame at 25 frames/s"),
        (
            "rig-dcon",
            "motor_reverse = 3",
            "motor_reverse = 4",
            "motor_reverse is on output 4, i7060 has outputs 0 to 3",
        ),
        ("rig-dcon", "counting", "baud = 38400\ncounting", "512 samples/s do not fit through 38400 baud"),
        ("rig-dcon", 'fourcc = "YUYV"', 'fourcc = "MJPG"\nconvert = false', "MJPG"),
        ("rig-dcon", 'fourcc = "YUYV"', 'fourcc = "GREY"\nchannel = "red"', "needs a colour fourcc"),
        ("rig-dcon", "baud = 9600", "baud = 9601", "9601"),
        (
            "rig-dcon",
            "usb-FTDI_USB-RS485_Cable_AB0CDEFG-if00-port0",
            "usb-US_Digital_USB__-__QSB_12345-if00-port0",
            "two devices are on",
        ),
        ("rig-dcon", "address = 1", "address = 1\nparity = 2", 'key "devices.io.parity" is unknown'),
        ("rig-dcon", 'dialect = "i7060"', 'dialect = "i7"', "key \"devices.io.dialect\" is 'i7'"),
        ("rig-dcon", 'kind = "qsb"', "", 'key "devices.encoder'),
        ("sim", "[devices.world]", "[devices.io.outputs]\nlamp = 1\n[devices.world]", "unknown"),
    ],
)
def test_a_mistake_is_one_sentence(edited: Edit, name, old, new, says):
    path = edited(name, old, new)

    with pytest.raises(ConfigError) as caught:
        load_rig(path)
    assert says in str(caught.value)
    assert len(str(caught.value)) < 600


def test_emulated_devices_need_a_world(edited: Edit):
    text = builtin_config("rig-emulated").read_text()
    path = edited("rig-emulated", text[text.index("[devices.world]") :], "")

    with pytest.raises(ConfigError, match=r"no \[devices.world\] for it to live in"):
        load_rig(path)


def test_an_inverted_output_that_is_not_wired_is_a_mistake(edited: Edit):
    path = edited("rig-dcon", "motor_reverse = 3", 'motor_reverse = 3\ninverted = ["lamp"]')

    with pytest.raises(ConfigError, match="not wired: lamp"):
        load_rig(path)


def test_lasers_and_motor_cannot_be_inverted(edited: Edit):
    path = edited("rig-dcon", "motor_reverse = 3", 'motor_reverse = 3\ninverted = ["laser_right"]')

    with pytest.raises(ConfigError, match="inverted"):
        load_rig(path)
