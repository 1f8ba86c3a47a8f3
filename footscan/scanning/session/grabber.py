"""The grab thread: takes frames from the camera and hands them on, and never waits for who works on them."""

import threading
from collections.abc import Callable

from footscan.devices.clock import Clock
from footscan.devices.protocols import Camera
from footscan.devices.values import CameraFrame
from footscan.errors import FootscanError
from footscan.scanning.session.queue_thread import failure_of_thread

_FEWEST_PERIODS = 4.0
_LEAST_TIMEOUT_S = 0.2


class Grabber(threading.Thread):
    """Runs until `finish`; `failure` says why it ended otherwise.

    Attributes:
        arrived: Frames so far.
        latest: The newest frame, for the screen.
        failure: What went wrong, None while well.
    """

    def __init__(self, camera: Camera, clock: Clock, hand_on: Callable[[CameraFrame], None]) -> None:
        super().__init__(name="grab", daemon=True)
        self.arrived = 0
        self.latest: CameraFrame | None = None
        self.failure: FootscanError | None = None
        self._camera, self._clock, self._hand_on = camera, clock, hand_on
        self._timeout_s = max(_FEWEST_PERIODS / camera.facts().frames_per_s, _LEAST_TIMEOUT_S)
        self._finished = False
        clock.join()

    def run(self) -> None:
        """Take frames until told to finish."""
        try:
            self._camera.start()
            while not self._finished:
                self._take(self._camera.read(self._timeout_s))
        except Exception as err:  # noqa: BLE001 - whatever ended the thread must stop the machine
            self.failure = None if self._finished else failure_of_thread("takes the frames", err)
        finally:
            self._clock.notify()
            self._clock.leave()

    def finish(self) -> None:
        """Stop after the current frame."""
        self._finished = True

    def _take(self, frame: CameraFrame) -> None:
        self.latest = frame
        self._hand_on(frame)
        self.arrived += 1
        self._clock.notify()
