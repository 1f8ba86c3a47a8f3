"""The emulators say what the manuals say, byte for byte."""

import time
from dataclasses import replace

import cv2
import numpy as np
import pytest
import serial

from footscan.config.device_models import QsbModel
from footscan.config.io_models import AdamModel
from footscan.devices.values import ALL_OFF, Inputs, Outputs
from footscan.sim.emulators.adam import AdamEmulator
from footscan.sim.emulators.capture import SELECT_TIMEOUT_S, Abilities, EmulatedCameraPlug
from footscan.sim.emulators.panel import WiredPanel, WorldPanel
from footscan.sim.emulators.pty_line import PtyLine
from footscan.sim.emulators.qsb import BANNER, QsbEmulator

INPUTS = Inputs(0.0, estop_ok=True, home=False)


class Word:
    """A panel of plain words."""

    def __init__(self, inputs: int = 0) -> None:
        self.inputs, self.switched = inputs, []

    def switch(self, bits: int, time_s: float) -> None:
        self.switched.append((bits, time_s))

    def input_bits(self, time_s: float) -> int:
        return self.inputs


def said(device, text: bytes, time_s: float = 0.0) -> bytes:
    return b"".join(reply for _, reply in device.hear(text, time_s))


def qsb(**settings) -> QsbEmulator:
    return QsbEmulator(lambda time_s: round(42 * time_s), 0.0, **settings)


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        (b"R0E\r", b"r 0E 0000002A !\r\n"),
        (b"R03\r\n", b"r 03 0000004F !\r\n"),
        (b"R08\n", b"r 08 000001F3 !\r\n"),
        (b"R14\r", b"r 14 004D2013 !\r\n"),
        (b"W0343\r", b"w 03 00000043 !\r\n"),
        (b"W153\r", b"w150000000" + b"3!\r\n"),
        (b"W155\r", b"w150000000500000200!\n"),
        (b"W15F\r", b"w 15 0000000F 00000200 !\r\n"),
        (b"R77\r", b"x 77 00000000 !\r\n"),
        (b"r0E\r", b"x 00 00000000 !\r\n"),
        (b"R0X\x08E\r", b"r 0E 0000002A !\r\n"),
        (b"\r\n\r", b""),
    ],
)
def test_a_qsb_answers_as_its_command_list_says(line, reply):
    assert said(qsb(), line, 1.0) == reply


def test_a_stamped_sample_is_26_bytes_and_21_without_spaces():
    device = qsb()

    assert len(said(device, b"W15F\rR0E\r", 1.0)) == 2 * 26
    assert said(device, b"W155\rR0E\r", 1.0).endswith(b"r0E0000002A00000200!\n")


def test_factory_settings_wrap_the_count_at_500():
    device = qsb()
    wrapped = said(device, b"R0E\r", 20.0)
    free = said(device, b"W0343\rR0E\r", 20.0)

    assert b"r 0E %08X" % (840 % 500) in wrapped
    assert b"r 0E %08X" % 840 in free


def test_negative_counts_are_two_s_complement():
    device = QsbEmulator(lambda time_s: -round(time_s), 0.0)

    assert b"FFFFFFFD" in said(device, b"W0343\rR0E\r", 3.0)


def test_it_streams_at_its_ticks_and_stops():
    device = qsb()
    silent = device.due_s()
    said(device, b"W155\rW0343\rW0B0\rW0C2\rW0D1\rS0E\r", 1.0)
    lines = [line for _, line in device.act(1.0 + 10.5 / 512)]
    moments = [moment for moment, _ in device.act(1.0 + 20.5 / 512)]
    said(device, b"R0E\r", 1.1)

    assert silent == np.inf
    assert [int(line[11:19], 16) for line in lines] == [2, 4, 6, 8, 10]
    assert moments == pytest.approx([1.0 + tick / 512 for tick in (12, 14, 16, 18, 20)])
    assert device.due_s() == np.inf


def test_the_factory_interval_streams_nothing():
    device = qsb()

    assert said(device, b"S0E\r").startswith(b"s 0E")
    assert device.due_s() == np.inf


def test_a_threshold_keeps_a_resting_head_quiet():
    device = QsbEmulator(lambda time_s: int(time_s >= 1.0) * 5, 0.0)
    said(device, b"W0343\rW0B5\rW0C1\rS0E\r")

    assert list(device.act(0.9)) == []
    assert len(list(device.act(1.2))) == 1


def test_a_restart_forgets_everything_and_says_so():
    device = qsb()
    said(device, b"W155\rW0343\rW0C1\rS0E\r", 1.0)
    device.reset(2.0)

    assert [line for _, line in device.act(2.0)] == [BANNER]
    assert said(device, b"R03\r", 2.0) == b"r 03 0000004F !\r\n"
    assert said(device, b"R0E\r", 3.0) == b"r 0E 0000002A !\r\n"


def test_a_fast_crystal_ticks_fast():
    device = qsb(ppm=1000.0)
    said(device, b"W0C1\rS0E\r")
    list(device.act(999 / 512 + 1e-5))

    assert device.due_s() == pytest.approx(1001 / 512 / 1.001)


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        (b"#010011\r", b">\r"),
        (b"#011201\r", b">\r"),
        (b"$016\r", b"!002200\r"),
        (b"$015\r", b"!011\r"),
        (b"$01M\r", b"!014055\r"),
        (b"$012\r", b"!01400A00\r"),
        (b"$01X0000A00\r", b">\r"),
        (b"$01X1\r", b"!000000\r"),
        (b"$01X2\r", b"!00\r"),
        (b"$01Z\r", b"?01\r"),
        (b"$026\r", b""),
        (b"~01310A\r", b""),
        (b"$01", b""),
    ],
)
def test_an_adam_answers_as_its_manual_says(line, reply):
    assert said(AdamEmulator("adam4055", Word(0x22)), line) == reply


def test_outputs_are_read_back_with_the_inputs():
    device = AdamEmulator("adam4055", Word(0x22))

    assert said(device, b"#010011\r$016\r") == b">\r!112200\r"
    assert said(device, b"#011400\r$016\r") == b">\r!012200\r"
    assert said(device, b"#**\r#010000\r$014\r") == b">\r!1012200\r"


def test_a_reset_is_told_once():
    device = AdamEmulator("adam4055", Word())

    assert said(device, b"$015\r$015\r") == b"!011\r!010\r"
    device.reset(1.0)
    assert said(device, b"$015\r$015\r") == b"!011\r!010\r"


def test_checksums_are_wanted_and_given():
    device = AdamEmulator("adam4055", Word(), with_checksum=True)

    assert said(device, b"#01000347\r") == b">3E\r"
    assert said(device, b"$016BB\r") == b"!03000044\r"
    assert said(device, b"$016\r$016BC\r") == b""


def test_an_adam_trips_after_silence_and_any_word_feeds_it():
    panel = Word()
    device = AdamEmulator("adam4055", panel)
    said(device, b"$01X0000A00\r#010003\r", 0.0)
    said(device, b"$016\r", 0.9)
    due_s = device.due_s()
    device.act(2.0)

    assert due_s == pytest.approx(1.9)
    assert panel.switched == [(3, 0.0), (0, pytest.approx(1.9))]
    assert said(device, b"$01X2\r", 2.0) == b"!01\r"


def test_a_dcon_module_trips_unless_it_hears_the_hosts_word():
    panel = Word()
    device = AdamEmulator("i7060", panel)

    assert said(device, b"~01310A\r#010003\r~012\r", 0.0) == b"!01\r>\r!010A\r"
    assert said(device, b"~**\r", 0.8) == b""
    said(device, b"$016\r", 1.7)
    device.act(1.85)
    assert panel.switched[-1] == (0, pytest.approx(1.8))
    assert said(device, b"~010\r", 2.0) == b"!0104\r"
    assert said(device, b"#010003\r", 2.0) == b"!\r"
    device.reset(3.0)
    assert said(device, b"~010\r#010003\r~011\r", 3.0) == b"!0104\r!\r!01\r"
    assert said(device, b"~010\r#010003\r", 3.0) == b"!0100\r>\r"


def test_a_relay_module_has_four_outputs():
    panel = Word()
    said(AdamEmulator("i7060", panel), b"#0100FF\r")

    assert panel.switched == [(0x0F, 0.0)]


def test_a_module_without_power_says_nothing_and_has_nothing_on():
    panel = Word()
    device = AdamEmulator("adam4055", panel)
    said(device, b"#010003\r")
    device.lose_power(1.0)

    assert said(device, b"$016\r", 1.1) == b""
    assert panel.switched[-1] == (0, 1.0)


def test_a_pulled_cable_does_not_stop_the_modules_own_watchdog():
    panel = Word()
    device = AdamEmulator("adam4055", panel)
    line = PtyLine(device)
    said(device, b"$01X0000100\r#010003\r", time.monotonic())
    line.unplug()
    time.sleep(0.3)
    line.close()

    assert panel.switched[-1][0] == 0


def test_a_line_takes_the_time_of_its_speed_and_garbles_other_speeds():
    line = PtyLine(AdamEmulator("adam4055", Word(), baud=9600))
    with serial.Serial(line.port, 9600, timeout=1.0) as port:
        began_s = time.monotonic()
        port.write(b"$016\r")
        answer = port.read_until(b"\r")
        took_s = time.monotonic() - began_s
    with serial.Serial(line.port, 115200, timeout=0.1) as port:
        port.write(b"$016\r")
        garbled = port.read(20)
    line.close()

    assert answer == b"!000000\r"
    assert took_s > 13 * 10 / 9600
    assert b"!" not in garbled


def test_a_port_keeps_its_name_when_it_is_plugged_in_again(tmp_path):
    line = PtyLine(AdamEmulator("adam4055", Word()), link=tmp_path / "ports" / "io")
    first = (tmp_path / "ports/io").exists()
    line.unplug()
    gone = (tmp_path / "ports/io").is_symlink()
    line.plug()
    with serial.Serial(line.port, 115200, timeout=1.0) as port:
        port.write(b"$01M\r")
        answer = port.read_until(b"\r")
    line.close()

    assert (first, gone) == (True, False)
    assert answer == b"!014055\r"


def test_what_nobody_reads_is_dropped_and_counted():
    line = PtyLine(AdamEmulator("adam4055", Word()))
    line._line._deliver(b"x" * 500_000)
    line.close()

    assert 300_000 < line.dropped_bytes < 500_000


def wired() -> AdamModel:
    outputs = {"laser_left": 0, "laser_right": 1, "motor_run": 2, "motor_reverse": 3, "speed": [5, 4]}
    table = {"kind": "adam", "dialect": "adam4055", "port": "emulated", "outputs": outputs}
    return AdamModel.model_validate(table | {"inputs": {"estop_ok": 0, "home": 7, "inverted": ["home"]}})


def test_a_world_gets_outputs_and_gives_inputs():
    class SmallWorld:
        got = ALL_OFF

        def set_outputs(self, outputs: Outputs) -> None:
            self.got = outputs

        def inputs(self) -> Inputs:
            return INPUTS

    world = SmallWorld()
    panel = WorldPanel(world, wired())
    panel.switch(0b100110, 0.0)

    assert world.got == Outputs(laser_right=True, motor_run=True, speed_step=1)
    assert panel.input_bits(0.0) == 0b10000001


def test_a_panel_remembers_every_change():
    panel = WiredPanel(wired(), INPUTS)
    panel.switch(0b010, 1.0)
    panel.switch(0b000, 2.0)
    panel.inputs = replace(INPUTS, home=True)

    assert [change.outputs.laser_right for change in panel.history] == [True, False]
    assert panel.input_bits(3.0) == 1


def test_a_camera_that_is_pulled_fails_at_once_and_stays_open():
    plug = EmulatedCameraPlug(lambda time_s: np.zeros((4, 6), np.uint8), Abilities(((6, 4),)))
    capture = plug.open("emulated")
    good = capture.grab()
    plug.unplug()

    assert good
    assert not capture.grab()
    assert capture.isOpened()
    assert not plug.open("emulated").isOpened()


def test_a_frozen_camera_costs_the_select_time_out():
    plug = EmulatedCameraPlug(lambda time_s: np.zeros((4, 6), np.uint8), Abilities(((6, 4),)))
    capture = plug.open("emulated")
    plug.frozen.set()
    began_s = time.monotonic()

    assert not capture.grab()
    assert time.monotonic() - began_s >= SELECT_TIMEOUT_S


def test_width_and_height_apply_as_a_pair():
    plug = EmulatedCameraPlug(lambda time_s: np.zeros((4, 6), np.uint8), Abilities(((640, 480), (6, 4))))
    capture = plug.open("emulated")
    capture.set(cv2.CAP_PROP_FRAME_WIDTH, 6)
    half = capture.get(cv2.CAP_PROP_FRAME_WIDTH)
    capture.set(cv2.CAP_PROP_FRAME_HEIGHT, 4)

    assert half == 640
    assert capture.get(cv2.CAP_PROP_FRAME_WIDTH) == 6


def test_the_qsb_model_knows_what_fits_its_line():
    assert QsbModel(kind="qsb", port="emulated").samples_per_s == 512
    with pytest.raises(ValueError, match="interval_ticks = 12"):
        QsbModel(kind="qsb", port="emulated", baud=9600)
