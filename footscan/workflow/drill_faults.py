"""Devices and tables that fail on purpose at a moment: what a drill injects where the simulated world cannot."""

from dataclasses import dataclass, replace
from typing import cast

from footscan.coordinates import Floats, Frame
from footscan.devices.clock import Clock
from footscan.devices.protocols import Camera, Encoder
from footscan.devices.values import CameraFacts, CameraFrame, EncoderReading, EncoderSamples
from footscan.optics.tables import LightTable


@dataclass
class FailAt:
    """The moment at which a fault begins; unset, it never does."""

    clock: Clock
    at_s: float = float("inf")

    @property
    def now(self) -> bool:
        """It has begun."""
        return self.clock.now_s() >= self.at_s

    def strike(self) -> None:
        """Raise what no driver would.

        Raises:
            RuntimeError: From the moment on.
        """
        if self.now:
            raise RuntimeError("injected by the drill")


class FailingCamera:
    """A camera whose driver breaks, or hands on something that is no picture."""

    def __init__(self, camera: Camera, fail: FailAt, breaks: bool) -> None:
        self._camera, self._fail, self._breaks = camera, fail, breaks

    def facts(self) -> CameraFacts:
        """As the camera says."""
        return self._camera.facts()

    def start(self) -> None:
        """As the camera."""
        self._camera.start()

    def read(self, timeout_s: float) -> CameraFrame:
        """The next frame, until the moment."""
        frame = self._camera.read(timeout_s)
        if not self._fail.now:
            return frame
        if self._breaks:
            self._fail.strike()
        return replace(frame, frame=cast("Frame", None))

    def close(self) -> None:
        """As the camera."""
        self._camera.close()


class FailingEncoder:
    """An encoder whose driver breaks."""

    def __init__(self, encoder: Encoder, fail: FailAt) -> None:
        self._encoder, self._fail = encoder, fail

    def read(self) -> EncoderReading:
        """As the encoder, until the moment."""
        self._fail.strike()
        return self._encoder.read()

    def take_samples(self) -> EncoderSamples:
        """As the encoder, until the moment."""
        self._fail.strike()
        return self._encoder.take_samples()

    def close(self) -> None:
        """As the encoder."""
        self._encoder.close()


class FailingTable:
    """A calibration table that breaks the thread which reads it."""

    def __init__(self, table: LightTable, fail: FailAt) -> None:
        self._table, self._fail = table, fail
        self.world_from_light = table.world_from_light

    def lookup(self, uv: Floats) -> Floats:
        """As the table, until the moment."""
        self._fail.strike()
        return self._table.lookup(uv)
