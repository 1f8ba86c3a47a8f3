"""What the software asks of a camera, an encoder and a digital I/O module, real, emulated or simulated.

All calls may raise `DeviceError` with a sentence for a person. `close` is safe to call twice.
"""

from typing import Protocol

from footscan.devices.values import CameraFacts, CameraFrame, EncoderReading, EncoderSamples, Inputs, Outputs


class Camera(Protocol):
    """One camera that runs on its own once started."""

    def facts(self) -> CameraFacts:
        """What it really delivers."""
        ...

    def start(self) -> None:
        """Let frames come."""
        ...

    def read(self, timeout_s: float) -> CameraFrame:
        """The next frame, stamped.

        Raises:
            CameraLostError: None came within `timeout_s`, or the camera is gone.
        """
        ...

    def close(self) -> None:
        """Give the camera back."""
        ...


class Encoder(Protocol):
    """The counter of the head's angle."""

    def read(self) -> EncoderReading:
        """The newest sample.

        Raises:
            EncoderLostError: It has not spoken for 0.1 s or longer.
        """
        ...

    def take_samples(self) -> EncoderSamples:
        """All samples since the last call, oldest first; empty when there is nothing new."""
        ...

    def close(self) -> None:
        """Give the port back."""
        ...


class DigitalIo(Protocol):
    """The module that switches lasers, motor, lamp and buzzer and reads switches; it drops its outputs unless fed."""

    def set_outputs(self, outputs: Outputs) -> None:
        """Switch, and read back.

        Raises:
            OutputsLostError: The module does not answer, or shows other outputs than asked for.
        """
        ...

    def read_outputs(self) -> Outputs:
        """What the module says it switches now."""
        ...

    def read_inputs(self) -> Inputs:
        """The switches now."""
        ...

    def arm_watchdog(self, timeout_s: float) -> None:
        """From now on outputs drop when `feed_watchdog` is not called for `timeout_s`; clears an earlier trip."""
        ...

    def feed_watchdog(self) -> None:
        """The control thread is alive."""
        ...

    def close(self) -> None:
        """Switch everything off and give the port back."""
        ...
