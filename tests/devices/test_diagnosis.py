import os
from pathlib import Path

import numpy as np
import pytest
import serial

from footscan.config.device_models import FileCameraModel, V4l2CameraModel
from footscan.config.io_models import AdamModel
from footscan.devices.diagnosis import Finding, camera_findings, encoder_findings, io_findings, port_findings
from footscan.devices.pictures import View
from footscan.devices.port_trouble import holders_words
from footscan.sim.emulators.capture import Abilities, EmulatedCameraPlug
from tests.devices.conftest import IO_TABLE


@pytest.fixture(autouse=True)
def fewer_probes(monkeypatch):
    monkeypatch.setattr("footscan.devices.probing.BAUDS", (115200, 9600, 230400))
    monkeypatch.setattr("footscan.devices.probing._ADDRESSES", tuple(range(6)))


def words(findings: list[Finding], grade: str) -> str:
    return " | ".join(finding.sentence for finding in findings if finding.grade == grade)


def test_a_good_encoder_is_said_to_be_good(plug_qsb):
    findings = list(encoder_findings(plug_qsb().model()))

    assert [finding.grade for finding in findings] == ["good"]
    assert "QSB-D number 1234, firmware 19: 51" in findings[0].sentence


def test_a_file_that_is_no_serial_port_is_named_as_such_for_both_devices(plug_qsb, plug_io):
    model = plug_qsb().model().model_copy(update={"port": "/dev/zero"})
    module = plug_io().model.model_copy(update={"port": "/dev/null"})

    assert words(list(encoder_findings(model)), "trouble").startswith("/dev/zero is no serial port; give the path")
    assert words(list(io_findings(module)), "trouble").startswith("/dev/null is no serial port; give the path")


def test_an_encoder_at_another_baud_rate_is_found(plug_qsb):
    qsb = plug_qsb(baud=115200)
    findings = list(encoder_findings(qsb.model(baud=230400)))

    assert "speaks 115200 baud; set baud = 115200 in [devices.encoder]" in words(findings, "trouble")


def test_exchanged_ports_are_noticed_from_both_sides(plug_qsb, plug_io):
    qsb, io = plug_qsb(), plug_io(baud=9600)
    encoder = encoder_findings(qsb.model().model_copy(update={"port": io.line.port}))
    module = io_findings(io.model.model_copy(update={"port": qsb.line.port}))

    assert "a digital I/O module 4055 answers" in words(list(encoder), "trouble")
    assert "a QSB answers" in words(list(module), "trouble")


def test_a_good_module_is_said_to_be_good_and_nothing_was_switched_on(plug_io):
    io = plug_io(checksum=True)
    findings = list(io_findings(io.model, switching_s=0.5))

    assert words(findings, "good").startswith("adam4055 at address 1, 115200 baud: everything is off")
    assert findings[1].sentence == "the home switch is open, the button is not pressed."
    assert [finding.grade for finding in findings] == ["good", "good"]
    assert not any(change.outputs.dangerous for change in io.panel.history)


@pytest.mark.parametrize(
    ("real", "advice"),
    [({"baud": 9600}, "baud = 9600"), ({"address": 4}, "address = 4"), ({"checksum": True}, "checksum = true")],
)
def test_other_settings_of_a_module_are_found(plug_io, real, advice):
    io = plug_io(**real)
    said = AdamModel.model_validate(IO_TABLE).model_copy(update={"port": io.line.port})

    assert f"answers with other settings; set {advice}." in words(list(io_findings(said)), "trouble")


def test_another_module_is_named(plug_io):
    io = plug_io(dialect="i7060")
    said = io.model.model_copy(update={"dialect": "adam4055"})

    assert "calls itself '7060', the rig file says adam4055" in words(list(io_findings(said)), "trouble")


def test_the_cost_of_a_slow_module_is_said(plug_io):
    remarks = words(list(io_findings(plug_io(baud=9600).model, switching_s=0.004)), "remark")

    assert "switching_s says 4 ms; set the module to 115200 baud" in remarks
    assert "answers without checksums" in remarks


def test_an_open_emergency_stop_is_trouble(plug_io):
    io = plug_io()
    io.press("estop_ok", False)

    assert "emergency stop is open" in words(list(io_findings(io.model)), "trouble")


def test_a_module_that_is_not_there_is_trouble(plug_io):
    io = plug_io()
    io.device.mute = True

    assert "does not answer" in words(list(io_findings(io.model)), "trouble")


def test_a_port_that_another_program_holds_is_said(plug_io):
    io = plug_io()
    holder = serial.Serial(io.line.port, exclusive=True)
    findings = list(io_findings(io.model))
    holder.close()

    assert "is used by another program; end that program" in words(findings, "trouble")


def test_programs_that_hold_a_port_are_named(tmp_path):
    port = tmp_path / "ttyUSB0"
    port.touch()
    (tmp_path / "proc/4711/fd").mkdir(parents=True)
    (tmp_path / "proc/4711/comm").write_text("minicom\n")
    (tmp_path / "proc/4711/fd/3").symlink_to(port)
    (tmp_path / "proc/net").mkdir()

    assert holders_words(port, tmp_path / "proc") == "minicom (process 4711)"


def test_a_missing_port_is_trouble():
    assert "does not exist" in words(list(port_findings("io", "/dev/serial/by-id/none")), "trouble")
    assert "serial number X9 is plugged in" in words(list(port_findings("io", "usb:X9")), "trouble")


def test_a_port_without_permission_names_the_group(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    (tmp_path / "port").touch()

    assert "usermod -aG" in words(list(port_findings("io", str(tmp_path / "port"))), "trouble")


@pytest.mark.parametrize(("milliseconds", "remarks"), [(16, 1), (1, 0)])
def test_a_slow_usb_bridge_is_remarked(tmp_path, milliseconds, remarks):
    timer = tmp_path / "sys/bus/usb-serial/devices/bridge7/latency_timer"
    timer.parent.mkdir(parents=True)
    timer.write_text(f"{milliseconds}\n")
    (tmp_path / "bridge7").touch()
    findings = list(port_findings("encoder", str(tmp_path / "bridge7"), tmp_path / "sys"))

    assert len(findings) == remarks
    assert all("up to 16 ms; let udev set 1 ms" in finding.sentence for finding in findings)


def test_a_name_that_changes_with_plugging_is_remarked(tmp_path):
    (tmp_path / "ttyUSB0").touch()

    assert "order of plugging" in words(list(port_findings("io", str(tmp_path / "ttyUSB0"), tmp_path)), "remark")


def camera(rate: float = 25.0, **abilities) -> list[Finding]:
    plug = EmulatedCameraPlug(
        lambda time_s: np.zeros((48, 64), np.uint8), Abilities(**{"sizes": ((64, 48),), "rates": (rate,), **abilities})
    )
    return list(camera_findings(V4l2CameraModel(kind="v4l2", path="emulated"), View(64, 48, 25.0), plug.open))


def test_a_good_camera_is_said_to_be_good():
    findings = camera()

    assert [finding.grade for finding in findings] == ["good"]
    assert "64 x 48 pixels, 2" in findings[0].sentence


def test_a_camera_at_another_rate_or_size_is_trouble():
    assert "frames/s instead of 25; set frames_per_s = 40" in words(camera(rate=40.0), "trouble")
    assert "delivers 32 x 32 pixels instead of 64 x 48" in words(camera(sizes=((32, 32),)), "trouble")


def test_a_camera_without_manual_exposure_is_remarked():
    assert "manual exposure: asked for 1, refused" in words(camera(manual_exposure=False), "remark")


def test_a_camera_that_is_not_there_is_trouble(tmp_path):
    file = FileCameraModel(kind="file", path=str(tmp_path / "none.avi"))
    device = V4l2CameraModel(kind="v4l2", path=str(Path("/dev/v4l/by-id/none")))

    assert "give a video file" in words(list(camera_findings(file, View(64, 48, 25.0))), "trouble")
    assert "does not exist; plug" in words(list(camera_findings(device, View(64, 48, 25.0))), "trouble")
