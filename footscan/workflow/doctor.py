"""`footscan doctor`: everything a scan needs, checked and said in words; lasers and motor stay off."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from footscan.config.device_models import DevicesModel, FileCameraModel, QsbModel, V4l2CameraModel
from footscan.config.io_models import AdamModel
from footscan.config.rig_file import Rig
from footscan.devices.diagnosis import Finding, camera_findings, encoder_findings, io_findings
from footscan.devices.pictures import View
from footscan.devices.v4l2_camera import OpenCapture
from footscan.errors import DeviceError
from footscan.optics.calibration import Calibration
from footscan.scanning.session.assembly import RigDevices
from footscan.workflow.scan import find_scans

_SCAN_BYTES = 60_000_000
_FRAMES = 10


def examine_drivers(devices: DevicesModel, rig: Rig, view: View, opener: OpenCapture) -> Iterator[Finding]:
    """Each real or emulated device, from its port to its answers.

    Args:
        devices: With the ports they are reached at.
        rig: What the file says of rates and times.
        view: What is expected of the camera.
        opener: Of the camera.
    """
    if isinstance(devices.camera, V4l2CameraModel | FileCameraModel):
        yield from camera_findings(devices.camera, view, opener)
    if isinstance(devices.encoder, QsbModel):
        yield from encoder_findings(devices.encoder)
    if isinstance(devices.io, AdamModel):
        yield from io_findings(devices.io, rig.motion.switching_s)


def examine_open_devices(devices: RigDevices, frames_per_s: float) -> Iterator[Finding]:
    """Camera, encoder and module by what they say and do; nothing is switched on."""
    yield _tried("camera", lambda: _camera_words(devices, frames_per_s))
    yield _tried("encoder", lambda: _encoder_words(devices))
    yield _tried("io", lambda: _io_words(devices))


def _tried(device: str, words: Callable[[], Finding]) -> Finding:
    try:
        return words()
    except DeviceError as err:
        return Finding(device, "trouble", str(err))


def _camera_words(devices: RigDevices, frames_per_s: float) -> Finding:
    devices.camera.start()
    frames = [devices.camera.read(1.0) for _ in range(_FRAMES)]
    rate = (frames[-1].number - frames[0].number) / (frames[-1].time_s - frames[0].time_s)
    height, width = frames[0].frame.shape
    good = abs(rate / frames_per_s - 1.0) < 0.1
    sentence = f"{devices.camera.facts().name}: {width} x {height} pixels, {rate:.1f} frames/s"
    return Finding(
        "camera", "good" if good else "trouble", f"{sentence}{'' if good else f', wanted {frames_per_s:g}'}."
    )


def _encoder_words(devices: RigDevices) -> Finding:
    reading = devices.encoder.read()
    samples = devices.encoder.take_samples()
    return Finding("encoder", "good", f"it counts {reading.count} and spoke {len(samples)} times meanwhile.")


def _io_words(devices: RigDevices) -> Finding:
    inputs, outputs = devices.io.read_inputs(), devices.io.read_outputs()
    if outputs.dangerous:
        return Finding("io", "trouble", f"{outputs} is on although nobody asked for it; switch the machine off.")
    if not inputs.estop_ok:
        return Finding("io", "trouble", "the emergency stop is open; release it, or check its cable.")
    return Finding("io", "good", f"it answers, everything is off, home switch {'closed' if inputs.home else 'open'}.")


def examine_computer(data: Path, scans: Path, calibration: Calibration | None, word: str) -> Iterator[Finding]:
    """Disk, calibration, and scans that were never finished or processed."""
    place = next(parent for parent in (data, *data.parents) if parent.exists())
    free = shutil.disk_usage(place).free
    grade = "good" if free > 20 * _SCAN_BYTES else "remark" if free > _SCAN_BYTES else "trouble"
    yield Finding("disk", grade, f"{free / 1e9:.1f} GB free at {place}, about {free // _SCAN_BYTES} scans.")
    yield Finding("calibration", "trouble" if calibration is None else "good", f"{word}.")
    for stored in find_scans(scans):
        if stored.trouble:
            yield Finding("scan", "remark", f"{stored.folder} cannot be read: {stored.trouble}")
        elif not stored.processed:
            state = "was never processed" if stored.finished else "was broken off; what was captured is kept"
            yield Finding("scan", "remark", f"{stored.folder} ({stored.frames} frames) {state}; see `footscan scans`.")
