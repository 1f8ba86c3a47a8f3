"""What is right and wrong with the devices of a rig, in words: for `footscan doctor`. Nothing is switched on."""

import math
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from footscan.config.device_models import FileCameraModel, QsbModel, V4l2CameraModel
from footscan.config.io_models import AdamModel
from footscan.config.port_name import USB_PREFIX
from footscan.devices.adam_io import AdamIo
from footscan.devices.drivers import open_camera
from footscan.devices.pictures import View
from footscan.devices.port_trouble import holders_words, permission_advice
from footscan.devices.probing import FoundModule, find_module, find_qsb
from footscan.devices.qsb_encoder import QsbEncoder
from footscan.devices.serial_port import path_of_port
from footscan.devices.v4l2_camera import OpenCapture, open_capture
from footscan.devices.values import ALL_OFF
from footscan.errors import DeviceError, WrongDeviceError

Grade = Literal["good", "remark", "trouble"]

_LATENCY_OF = "bus/usb-serial/devices/{}/latency_timer"
_LISTEN_S = 0.6
_FRAMES = 20
_RATE_ERROR = 0.05
_SWITCHINGS = 5
_FAST_BAUD = 115200


@dataclass(frozen=True)
class Finding:
    """One sentence about one device, and what to do if something is wrong."""

    device: str
    grade: Grade
    sentence: str


def port_findings(device: str, name: str, sys_root: Path = Path("/sys")) -> Iterator[Finding]:
    """A serial port before it is opened: there, permitted, free, quick; stops at what prevents its use."""
    try:
        path = Path(path_of_port(name, DeviceError))
    except DeviceError as err:
        yield Finding(device, "trouble", str(err))
        return
    if not path.exists():
        sentence = f"{path} does not exist; plug the device in, or give the path that `ls /dev/serial/by-id/` shows."
        yield Finding(device, "trouble", sentence)
    elif not os.access(path, os.R_OK | os.W_OK):
        sentence = f"{path} may not be opened by this user; {permission_advice(path)}."
        yield Finding(device, "trouble", sentence)
    else:
        yield from _port_remarks(device, name, path, sys_root)


def _port_remarks(device: str, name: str, path: Path, sys_root: Path) -> Iterator[Finding]:
    if not name.startswith(USB_PREFIX) and path.name.startswith(("ttyUSB", "ttyACM")) and not path.is_symlink():
        sentence = f"{path} changes its number with the order of plugging; give its name in /dev/serial/by-id/."
        yield Finding(device, "remark", sentence)
    timer = sys_root / _LATENCY_OF.format(path.resolve().name)
    if timer.is_file() and (milliseconds := int(timer.read_text())) > 2:
        sentence = (
            f"the USB bridge of {path} keeps bytes for up to {milliseconds} ms; let udev set 1 ms "
            "(docs/howto/build-the-machine.md)."
        )
        yield Finding(device, "remark", sentence)


def encoder_findings(model: QsbModel, sys_root: Path = Path("/sys")) -> Iterator[Finding]:
    """The encoder's port, who answers there, and how its samples come. About 1 s if all is well."""
    yield from (found := list(port_findings("encoder", model.port, sys_root)))
    if any(finding.grade == "trouble" for finding in found):
        return
    try:
        encoder = QsbEncoder(model)
    except DeviceError as err:
        yield Finding("encoder", "trouble", _why_no_qsb(model, err))
        return
    try:
        yield from _stream_findings(encoder, model)
    except DeviceError as err:
        yield Finding("encoder", "trouble", str(err))
    finally:
        encoder.close()


def _stream_findings(encoder: QsbEncoder, model: QsbModel) -> Iterator[Finding]:
    encoder.take_samples()
    time.sleep(_LISTEN_S)
    samples = encoder.take_samples()
    rate = (len(samples) - 1) / max(float(np.ptp(samples.time_s)), 1e-3) if len(samples) > 1 else 0.0
    who = f"{encoder.identity.type} number {encoder.identity.serial_number}, firmware {encoder.identity.firmware}"
    slow = rate < (1.0 - _RATE_ERROR) * model.samples_per_s
    yield Finding("encoder", "trouble" if slow else "good", f"{who}: {rate:.0f} samples/s{_asked(slow, model)}.")
    if encoder.garbled_lines:
        sentence = f"{encoder.garbled_lines} lines made no sense; check the cable, its shield and the baud rate."
        yield Finding("encoder", "remark", sentence)


def _asked(slow: bool, model: QsbModel) -> str:
    return f" instead of {model.samples_per_s:.0f}; use a faster baud or a larger interval_ticks" if slow else ""


def _why_no_qsb(model: QsbModel, err: DeviceError) -> str:
    if " is used by " in str(err) or isinstance(err, WrongDeviceError):
        return str(err)
    found = find_qsb(model.port, model.baud)
    if found is not None and found.baud != model.baud:
        return f"the QSB on {model.port} speaks {found.baud} baud; set baud = {found.baud} in [devices.encoder]."
    module = None if found else find_module(model.port, FoundModule("", 9600, 1, False))
    if module is not None:
        return f"a digital I/O module {module.name} answers on {model.port}; exchange the ports of encoder and io."
    return str(err)


def io_findings(model: AdamModel, switching_s: float | None = None, sys_root: Path = Path("/sys")) -> Iterator[Finding]:
    """The module's port, who answers there, how long switching takes, and what its inputs say.

    Args:
        model: From the rig file.
        switching_s: What the rig file says of switching.
        sys_root: Where the kernel tells of USB bridges.
    """
    yield from (found := list(port_findings("io", model.port, sys_root)))
    if any(finding.grade == "trouble" for finding in found):
        return
    try:
        module = AdamIo(model)
    except DeviceError as err:
        yield Finding("io", "trouble", _why_no_module(model, err))
        return
    try:
        yield from _module_findings(module, model, switching_s)
    except DeviceError as err:
        yield Finding("io", "trouble", str(err))
    finally:
        module.close()


def _module_findings(module: AdamIo, model: AdamModel, switching_s: float | None) -> Iterator[Finding]:
    took_s = _switching_s(module)
    at = f"{model.dialect} at address {model.address}, {model.baud} baud"
    yield Finding("io", "good", f"{at}: everything is off and confirmed in {1000 * took_s:.0f} ms.")
    if switching_s is not None and took_s > switching_s:
        quicker = "" if model.baud >= _FAST_BAUD else "set the module to 115200 baud, or "
        sentence = (
            f"switching a laser and reading it back takes {1000 * took_s:.0f} ms, switching_s says "
            f"{1000 * switching_s:.0f} ms; {quicker}set switching_s = {_rounded_up(took_s):g}."
        )
        yield Finding("io", "remark", sentence)
    if not model.checksum:
        sentence = "the module answers without checksums; switch them on in module and rig file."
        yield Finding("io", "remark", sentence)
    inputs = module.read_inputs()
    button = "no button is wired" if model.inputs.button is None else _state("the button is", inputs.button, "pressed")
    yield Finding("io", "good", f"{_state('the home switch is', inputs.home, 'closed', 'open')}, {button}.")
    if not inputs.estop_ok:
        sentence = "the emergency stop is open; release it, or check the wire of its contact and `inverted`."
        yield Finding("io", "trouble", sentence)
    if inputs.watchdog_tripped:
        yield Finding("io", "remark", "the module's watchdog has tripped earlier; arming clears it.")


def _state(what: str, holds: bool, word: str, otherwise: str = "") -> str:
    return f"{what} {word if holds else otherwise or f'not {word}'}"


def _rounded_up(seconds: float) -> float:
    return math.ceil(1000 * seconds) / 1000


def _switching_s(module: AdamIo) -> float:
    took_s: list[float] = []
    for _ in range(_SWITCHINGS):
        began_s = time.monotonic()
        module.set_outputs(ALL_OFF)
        took_s.append(time.monotonic() - began_s)
    return float(np.median(took_s))


def _why_no_module(model: AdamModel, err: DeviceError) -> str:
    if " is used by " in str(err) or isinstance(err, WrongDeviceError):
        return str(err)
    asked = FoundModule("", model.baud, model.address, model.checksum)
    found = find_module(model.port, asked)
    if found is not None:
        return _differences(model, found) or str(err)
    if find_qsb(model.port, 230400) is not None:
        return f"a QSB answers on {model.port}; exchange the ports of encoder and io."
    return str(err)


def _differences(model: AdamModel, found: FoundModule) -> str:
    wrong = [
        f"{key} = {str(getattr(found, key)).lower()}"
        for key in ("baud", "address", "checksum")
        if getattr(found, key) != getattr(model, key)
    ]
    if not wrong:
        return ""
    return f"the module {found.name} on {model.port} answers with other settings; set {', '.join(wrong)}."


def camera_findings(
    model: V4l2CameraModel | FileCameraModel, view: View, opener: OpenCapture = open_capture
) -> Iterator[Finding]:
    """The camera opens, takes its settings, and delivers at its rate. About 1 s."""
    try:
        camera = open_camera(model, view, opener)
    except DeviceError as err:
        yield Finding("camera", "trouble", _with_holder(model, err))
        return
    try:
        notes = [note for note in camera.facts().notes if "asked for" in note]
        yield from (Finding("camera", "remark", f"{note}; see `v4l2-ctl -d {model.path} -L`.") for note in notes)
        camera.start()
        frames = [camera.read(3.0) for _ in range(_FRAMES)]
        yield _rate_finding([frame.time_s for frame in frames], model, view)
    except DeviceError as err:
        yield Finding("camera", "trouble", str(err))
    finally:
        camera.close()


def _rate_finding(time_s: list[float], model: V4l2CameraModel | FileCameraModel, view: View) -> Finding:
    rate = 1.0 / float(np.median(np.diff(time_s)))
    what = f"{model.path}: {view.width_px} x {view.height_px} pixels, {rate:.1f} frames/s"
    if abs(rate / view.frames_per_s - 1.0) <= _RATE_ERROR:
        return Finding("camera", "good", f"{what}.")
    advice = f"set frames_per_s = {rate:.0f}, or choose an exposure shorter than a frame and another pixel format"
    return Finding("camera", "trouble", f"{what} instead of {view.frames_per_s:g}; {advice}.")


def _with_holder(model: V4l2CameraModel | FileCameraModel, err: DeviceError) -> str:
    holder = holders_words(Path(model.path)) if "another program" in str(err) else "another program"
    return str(err).replace("another program uses it", f"{holder} uses it")
