"""The output module's twin in another process: it outlives a killed program and says when its outputs fell.

A simulated world dies with the program it lives in. A world with a `mirror` tells every command to its module also to
a Unix socket, where another process keeps a second module of the same kind, with the same watchdog, on the same
monotonic clock.
"""

import json
import socket
import threading
import time
from dataclasses import asdict
from pathlib import Path

from footscan.devices.values import ALL_OFF, Outputs
from footscan.errors import ConfigError
from footscan.sim.io_module import IoModule


class MirroredModule(IoModule):
    """A module that tells its twin every command."""

    def __init__(self, place: Path) -> None:
        """Find the twin's socket.

        Raises:
            ConfigError: Nobody listens there.
        """
        super().__init__()
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            self._socket.connect(str(place))
        except OSError as err:
            raise ConfigError(f"nobody listens at mirror = {str(place)!r} ({err.strerror}); leave it out.") from err

    def set(self, outputs: Outputs, time_s: float) -> None:
        """Switch, here and there."""
        super().set(outputs, time_s)
        self._tell({"set": asdict(outputs)})

    def arm(self, timeout_s: float, time_s: float) -> None:
        """Set the watchdog, here and there."""
        super().arm(timeout_s, time_s)
        self._tell({"arm": timeout_s})

    def feed(self, time_s: float) -> None:
        """The computer is alive."""
        super().feed(time_s)
        self._tell({"feed": True})

    def _tell(self, message: dict[str, object]) -> None:
        self._socket.send(json.dumps(message).encode())


class ModuleTwin(threading.Thread):
    """Listens at a socket and keeps the second module; use as a context manager."""

    def __init__(self, place: Path) -> None:
        super().__init__(name="module twin", daemon=True)
        self._module = IoModule()
        self._lock = threading.Lock()
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(place))
        self._socket.settimeout(0.002)
        self._ended = False
        self._off_since_s: float | None = time.monotonic()

    @property
    def outputs(self) -> Outputs:
        """What is switched now."""
        with self._lock:
            return self._look()

    @property
    def off_since_s(self) -> float | None:
        """Since when (CLOCK_MONOTONIC) nothing dangerous has been on; None while something is."""
        with self._lock:
            self._look()
            return self._off_since_s

    def run(self) -> None:
        """Obey commands as they come."""
        while not self._ended:
            try:
                message = json.loads(self._socket.recv(4096))
            except TimeoutError:
                message = {}
            with self._lock:
                self._obey(message)
                self._look()

    def __enter__(self) -> "ModuleTwin":
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._ended = True
        self.join()
        self._socket.close()

    def _obey(self, message: dict[str, object]) -> None:
        now_s = time.monotonic()
        match message:
            case {"set": dict(values)}:
                self._module.set(Outputs(**values), now_s)
            case {"arm": float(timeout_s)}:
                self._module.arm(timeout_s, now_s)
            case {"feed": True}:
                self._module.feed(now_s)
            case _:
                pass

    def _look(self) -> Outputs:
        trips_s, now_s = self._module.trips_at_s, time.monotonic()
        outputs = self._module.outputs_at(now_s)
        if outputs.dangerous:
            self._off_since_s = None
        elif self._off_since_s is None:
            tripped = self._module.tripped and trips_s is not None
            self._off_since_s = trips_s if tripped else now_s
        return outputs if outputs.dangerous else ALL_OFF
