"""The simulated camera, encoder and digital I/O module: the same contract as the real ones, on one shared world."""

import math
import threading

import numpy as np

from footscan.coordinates import LASER_NAMES, Floats, Frame
from footscan.devices.carriage import SILENT_S
from footscan.devices.values import ALL_OFF, CameraFacts, CameraFrame, EncoderReading, EncoderSamples, Inputs, Outputs
from footscan.errors import CameraLostError, EncoderLostError, OutputsLostError
from footscan.sim.calibration_run import CALIBRATION_PICTURE, stand_board
from footscan.sim.clock import VirtualClock
from footscan.sim.picture import Painter
from footscan.sim.world import World

_BUFFERED = 4  # frames a driver keeps for a slow reader


class SimCamera:
    """A free-running camera: frame n is exposed at start + n / rate, stamped late by the machine's latency."""

    def __init__(self, world: World, frames_per_s: float, exposure_s: float) -> None:
        self._world, self._rate, self._exposure_s = world, frames_per_s, exposure_s
        self._latency_s = world.machine.calibration.latency_s
        self._painted = world.standing
        self._painter = self._new_painter()
        self._started_s: float | None = None
        self._next = 0
        self._closed = False

    def facts(self) -> CameraFacts:
        """What it delivers."""
        camera = self._world.machine.calibration.camera
        return CameraFacts("simulated camera", camera.width_px, camera.height_px, self._rate, self._exposure_s)

    def start(self) -> None:
        """Let frames come."""
        if self._started_s is None:
            self._started_s = self._world.clock.now_s() + 0.5 / self._rate

    def read(self, timeout_s: float) -> CameraFrame:
        """The next frame.

        Raises:
            CameraLostError: Not started, closed, or frozen.
        """
        clock = self._world.clock
        if self._closed or self._started_s is None:
            raise CameraLostError("the simulated camera is not running; start it first.")
        ripe = math.ceil((clock.now_s() - self._latency_s - self._started_s) * self._rate)
        number = max(self._next, ripe - _BUFFERED)
        exposed_s = self._started_s + number / self._rate
        due_s = exposed_s + self._latency_s
        gives_up_s = clock.now_s() + timeout_s
        if self._world.suffers("camera-frozen", exposed_s) or due_s > gives_up_s:
            clock.wait(gives_up_s, lambda: self._closed)
            raise CameraLostError(
                f"no frame came from the camera within {timeout_s:g} s; check its cable and supply, then start again."
            )
        clock.wait(due_s, lambda: self._closed)
        self._next = number + 1
        return CameraFrame(self.expose(exposed_s, number), due_s, number)

    def close(self) -> None:
        """Stop the frames."""
        self._closed = True
        self._world.clock.notify()

    def _new_painter(self) -> Painter:
        settings, board = self._world.settings, self._painted.printed
        if board is not None:
            return Painter.of_board(self._world.machine.calibration, board, CALIBRATION_PICTURE, settings.seed)
        return Painter(self._world.machine.calibration, self._painted.surface, settings.picture, settings.seed)

    def warm_up(self) -> None:
        """Use all that is compiled at first use, before time runs: compiling holds the other threads up.

        Whoever stands there moves once, both lasers are painted once, and so is a board, which may be put there later.
        """
        vertices = self._painted.xyz_world_at(0.0)
        if vertices is not None:
            self._painter.set_vertices(vertices)
        self._painter.paint(0.0, LASER_NAMES, 0)
        if not isinstance(self._world.clock, VirtualClock):  # virtual time waits for those who compile
            machine = self._world.machine.calibration
            Painter.of_board(machine, stand_board(0), CALIBRATION_PICTURE).paint(0.0, LASER_NAMES, 0)

    def expose(self, exposed_s: float, number: int) -> Frame:
        """The picture of a moment; `number` seeds its noise. For one thread at a time."""
        world = self._world
        theta_rad = float(world.theta_at(np.array([exposed_s]))[0])
        if world.standing is not self._painted:
            self._painted = world.standing
            self._painter = self._new_painter()
        vertices = self._painted.xyz_world_at(exposed_s - world.start_s)
        if vertices is not None:
            self._painter.set_vertices(vertices)
        return self._painter.paint(theta_rad, world.lasers_at(exposed_s) or None, number)


class SimEncoder:
    """The counter of the simulated head, sampled evenly; it counts from zero at power-on."""

    def __init__(self, world: World, samples_per_s: float) -> None:
        self._world, self._rate = world, samples_per_s
        self._taken = math.floor(world.clock.now_s() * samples_per_s)
        self._lock = threading.Lock()

    def read(self) -> EncoderReading:
        """The newest sample.

        Raises:
            EncoderLostError: Silent for 0.1 s or longer.
        """
        newest_s = self._newest_sample() / self._rate
        if self._world.clock.now_s() - newest_s > SILENT_S:
            raise EncoderLostError("the simulated encoder is silent; check its cable and supply.")
        return EncoderReading(int(self._world.counts_at(np.array([newest_s]))[0]), newest_s)

    def take_samples(self) -> EncoderSamples:
        """All samples since the last call."""
        with self._lock:
            newest = self._newest_sample()
            time_s: Floats = np.arange(self._taken + 1, newest + 1) / self._rate
            self._taken = max(newest, self._taken)
            return EncoderSamples(time_s, self._world.counts_at(time_s))

    def close(self) -> None:
        """Nothing to give back."""

    def _newest_sample(self) -> int:
        now_s = self._world.catch_up()
        silent_s = self._world.silent_since("encoder-silent")
        return math.floor(min(now_s, silent_s) * self._rate)


class SimDigitalIo:
    """The simulated module: switching takes a moment, a silent one raises after its time-out."""

    def __init__(self, world: World, switching_s: float = 0.001, timeout_s: float = 0.05) -> None:
        self._world, self._switching_s, self._timeout_s = world, switching_s, timeout_s
        self._closed = False

    def set_outputs(self, outputs: Outputs) -> None:
        """Switch, and read back.

        Raises:
            OutputsLostError: The module does not answer, or dropped its outputs by itself.
        """
        self._refuse_silence()
        self._world.clock.wait(self._world.clock.now_s() + self._switching_s)
        self._world.set_outputs(outputs)
        shown = self.read_outputs()
        if shown != outputs:
            raise OutputsLostError(
                f"the output module shows {shown} instead of {outputs}; its watchdog has dropped the outputs or its "
                "power failed. Check it, then arm it again."
            )

    def read_outputs(self) -> Outputs:
        """What is switched now."""
        self._refuse_silence()
        return self._world.outputs()

    def read_inputs(self) -> Inputs:
        """The switches now."""
        self._refuse_silence()
        return self._world.inputs()

    def arm_watchdog(self, timeout_s: float) -> None:
        """Outputs drop unless fed from now on; clears a trip."""
        self._refuse_silence()
        self._world.arm_watchdog(timeout_s)

    def feed_watchdog(self) -> None:
        """The control thread is alive."""
        self._refuse_silence()
        self._world.feed_watchdog()

    def close(self) -> None:
        """All off."""
        if not self._closed:
            self._closed = True
            if not self._world.suffers("io-silent", self._world.clock.now_s()):
                self._world.set_outputs(ALL_OFF)

    def _refuse_silence(self) -> None:
        clock = self._world.clock
        if self._world.suffers("io-silent", clock.now_s()):
            clock.wait(clock.now_s() + self._timeout_s)
            raise OutputsLostError("the output module does not answer; check its cable, supply and address.")
