"""A simulated world behind real bytes: emulators for every device that a rig file calls "emulated"."""

import itertools
import time
from collections.abc import Callable
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from footscan.config.device_models import DevicesModel, PictureModel, QsbModel, V4l2CameraModel
from footscan.config.io_models import AdamModel
from footscan.config.port_name import EMULATED
from footscan.coordinates import Frame
from footscan.sim.devices import SimCamera
from footscan.sim.emulators.adam import AdamEmulator
from footscan.sim.emulators.capture import Abilities, EmulatedCameraPlug, EmulatedCapture
from footscan.sim.emulators.panel import WorldPanel
from footscan.sim.emulators.pty_line import PtyLine
from footscan.sim.emulators.qsb import QsbEmulator
from footscan.sim.world import World

Fault = Literal[
    "camera-unplugged",
    "camera-frozen",
    "encoder-unplugged",
    "encoder-silent",
    "encoder-reset",
    "io-unplugged",
    "io-silent",
    "io-reset",
    "io-trips",
    "io-garbage",
]
FAULTS: tuple[Fault, ...] = get_args(Fault)


class EmulatedRig:
    """Emulators on the computer's own clock, driven by a world on the same clock.

    Attributes:
        devices: The rig's devices with the ports of the emulators instead of "emulated".
        camera: The emulated camera's plug, None if the rig has another camera.
        encoder: The emulated QSB, None if the rig has another encoder.
        io: The emulated module, None if the rig has another one.
    """

    def __init__(self, world: World, devices: DevicesModel, frames_per_s: float, links: Path | None = None) -> None:
        """Switch the emulators on.

        Args:
            world: What they live in.
            devices: As the rig file names them.
            frames_per_s: Of the camera.
            links: A folder for symbolic links named encoder and io to the ports.
        """
        self._world, self._links = world, links
        self._lines: dict[str, PtyLine] = {}
        self.encoder = self._plug_encoder(devices.encoder)
        self.camera = self._plug_camera(devices.camera, frames_per_s)
        self.io = self._plug_io(devices.io)
        ports = {name: {"port": line.port} for name, line in self._lines.items()}
        parts = {name: getattr(devices, name).model_copy(update=port) for name, port in ports.items()}
        self.devices = devices.model_copy(update=parts)

    def open_capture(self, path: str) -> EmulatedCapture:
        """What the V4L2 driver calls instead of OpenCV.

        Raises:
            ValueError: The rig has no emulated camera.
        """
        if self.camera is None:
            raise ValueError("this rig has no emulated camera")
        return self.camera.open(path)

    def inject(self, fault: Fault) -> None:
        """Something happens to a device or its cable, now.

        Raises:
            ValueError: The rig has no such emulated device.
        """
        kind, what = fault.split("-")
        if what == "unplugged" and kind in self._lines:
            self._lines[kind].unplug()
            return
        action = self._actions().get(fault)
        if action is None:
            raise ValueError(f"{fault} needs an emulated {kind}, which this rig does not have")
        action()

    def mend(self) -> None:
        """All cables in again, nothing mute or frozen."""
        for line in self._lines.values():
            line.plug()
        if self.camera is not None:
            self.camera.plug()
            self.camera.frozen.clear()
        for device in (self.encoder, self.io):
            if device is not None:
                device.mute = False
        if self.io is not None:
            self.io.garbles = False

    def close(self) -> None:
        """Switch the emulators off."""
        for line in self._lines.values():
            line.close()
        if self.camera is not None:
            self.camera.unplug()

    def _actions(self) -> dict[Fault, Callable[[], None]]:
        actions: dict[Fault, Callable[[], None]] = {}
        if self.camera is not None:
            actions |= {"camera-unplugged": self.camera.unplug, "camera-frozen": self.camera.frozen.set}
        if (encoder := self.encoder) is not None:
            actions |= {
                "encoder-silent": lambda: setattr(encoder, "mute", True),
                "encoder-reset": lambda: encoder.reset(time.monotonic()),
            }
        if (io := self.io) is not None:
            actions |= {
                "io-silent": lambda: setattr(io, "mute", True),
                "io-reset": lambda: io.reset(time.monotonic()),
                "io-trips": lambda: io.trip(time.monotonic()),
                "io-garbage": lambda: setattr(io, "garbles", True),
            }
        return actions

    def _plug_camera(self, model: PictureModel | object, frames_per_s: float) -> EmulatedCameraPlug | None:
        if not isinstance(model, V4l2CameraModel) or model.path != EMULATED:
            return None
        camera = self._world.machine.calibration.camera
        size = (camera.width_px, camera.height_px * model.rows_per_row)
        eye = SimCamera(self._world, frames_per_s, model.exposure_s)
        eye.warm_up()
        latency_s, numbers = self._world.machine.calibration.latency_s, itertools.count()

        def frame_at(stamp_s: float) -> Frame:
            if self.encoder is not None:
                self.encoder.trigger(stamp_s - latency_s)  # the strobe; heeded only where `frame_trigger` is set
            upright = eye.expose(stamp_s - latency_s, next(numbers)).repeat(model.rows_per_row, axis=0)
            return upright[::-1, ::-1] if camera.image_rotation_deg == 180 else upright

        return EmulatedCameraPlug(frame_at, Abilities((size,), (frames_per_s,)))

    def _plug_encoder(self, model: object) -> QsbEmulator | None:
        if not isinstance(model, QsbModel) or model.port != EMULATED:
            return None
        world = self._world
        device = QsbEmulator(lambda t: int(world.counts_at(np.array([t]))[0]), time.monotonic(), baud=model.baud)
        self._lines["encoder"] = PtyLine(device, self._link("encoder"))
        return device

    def _plug_io(self, model: object) -> AdamEmulator | None:
        if not isinstance(model, AdamModel) or model.port != EMULATED:
            return None
        panel = WorldPanel(self._world, model)
        device = AdamEmulator(model.dialect, panel, model.baud, model.address, model.checksum)
        self._lines["io"] = PtyLine(device, self._link("io"))
        return device

    def _link(self, name: str) -> Path | None:
        return None if self._links is None else self._links / name
