"""A simulated machine in a process of its own: ports under fixed names and a socket for pictures and faults.

A program that drives it can be killed, and what its outputs did then is still known here. One folder holds it all:
`encoder` and `io` are links to the ports, `camera` and `control` are Unix sockets.
"""

import json
import socket
import struct
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from footscan.coordinates import Frame
from footscan.sim.emulators.capture import Abilities, EmulatedCameraPlug, EmulatedCapture
from footscan.sim.emulators.emulated_rig import FAULTS, EmulatedRig, Fault
from footscan.sim.world import Trouble, World

WORLD_FAULTS: tuple[Trouble, ...] = (
    "encoder-jump",
    "stall",
    "wrong-way",
    "estop",
    "right-laser-dead",
    "left-laser-dead",
)
"""What happens to the machine itself and not to a device or its cable."""
_DEVICE_FAULTS: dict[str, Fault] = {fault: fault for fault in FAULTS}
_TROUBLES: dict[str, Trouble] = {trouble: trouble for trouble in WORLD_FAULTS}
CAMERA, CONTROL = "camera", "control"
_STAMP = struct.Struct("<d")
_SHAPE = struct.Struct("<HH")
_REPLY_S = 5.0
_NOTHING: Frame = np.zeros((0, 0), np.uint8)


class EmulatorServer:
    """Serves an emulated rig until closed; threads of its own."""

    def __init__(self, world: World, rig: EmulatedRig, folder: Path) -> None:
        """Open the sockets in `folder`, where the rig has its links."""
        self._world, self._rig, self._folder = world, rig, folder
        self._ending = threading.Event()
        folder.mkdir(parents=True, exist_ok=True)
        self._listeners = [self._listen(CAMERA, self._serve_pictures), self._listen(CONTROL, self._serve_control)]

    def wait(self) -> None:
        """Until somebody says "end" or closes."""
        self._ending.wait()

    def close(self) -> None:
        """No more."""
        self._ending.set()
        for name, listener in zip((CAMERA, CONTROL), self._listeners, strict=True):
            listener.shutdown(socket.SHUT_RDWR)  # wakes who waits for clients
            listener.close()
            (self._folder / name).unlink(missing_ok=True)
        self._rig.close()

    def obey(self, line: str) -> dict[str, Any]:
        """One command: `inject FAULT`, `mend`, `state` or `end`; returns what the machine is doing.

        Raises:
            ValueError: It is no command, or the rig has no such emulated device.
        """
        words = line.split()
        match words:
            case ["inject", name]:
                self._inject(name)
            case ["mend"]:
                self._rig.mend()
                for trouble in WORLD_FAULTS:
                    self._world.mend(trouble)
            case ["state"]:
                pass
            case ["end"]:
                self._ending.set()
            case _:
                raise ValueError(f"{line.strip()!r} is none of inject FAULT, mend, state, end")
        return self._state()

    def _inject(self, name: str) -> None:
        fault, trouble = _DEVICE_FAULTS.get(name), _TROUBLES.get(name)
        if fault is not None:
            self._rig.inject(fault)
        elif trouble is not None:
            self._world.inject(trouble)
        else:
            raise ValueError(f"{name!r} is no fault; there are {', '.join((*FAULTS, *WORLD_FAULTS))}")

    def _state(self) -> dict[str, Any]:
        outputs, now_s = self._world.outputs(), time.monotonic()
        return {
            "now_s": now_s,
            "off_since_s": self._world.off_since_s,
            "lasers": list(outputs.lasers),
            "motor": outputs.motor_run,
            "theta_deg": float(np.rad2deg(self._world.theta_at(np.array([now_s]))[0])),
        }

    def _listen(self, name: str, serve: Callable[[socket.socket], None]) -> socket.socket:
        path = self._folder / name
        path.unlink(missing_ok=True)
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(str(path))
        listener.listen()
        threading.Thread(target=self._accept, args=(listener, serve), name=name, daemon=True).start()
        return listener

    def _accept(self, listener: socket.socket, serve: Callable[[socket.socket], None]) -> None:
        while not self._ending.is_set():
            try:
                connection, _ = listener.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(connection, serve), name="client", daemon=True).start()

    def _serve(self, connection: socket.socket, serve: Callable[[socket.socket], None]) -> None:
        with connection:
            try:
                serve(connection)
            except (OSError, EOFError):
                return  # the client has gone

    def _serve_pictures(self, connection: socket.socket) -> None:
        plug = self._rig.camera
        assert plug is not None
        while True:
            (stamp_s,) = _STAMP.unpack(_received(connection, _STAMP.size))
            if not plug.plugged.is_set():
                return
            frame = _NOTHING if plug.frozen.is_set() else np.ascontiguousarray(plug.frame_at(stamp_s))
            connection.sendall(_SHAPE.pack(*frame.shape) + frame.tobytes())

    def _serve_control(self, connection: socket.socket) -> None:
        with connection.makefile("rw") as lines:
            for line in lines:
                lines.write(json.dumps(self._obeyed(line)) + "\n")
                lines.flush()

    def _obeyed(self, line: str) -> dict[str, Any]:
        try:
            return self.obey(line)
        except ValueError as err:
            return {"error": str(err)}


class RemoteCapture:
    """Opens the camera of an `EmulatorServer`, for the V4L2 driver."""

    def __init__(self, abilities: Abilities) -> None:
        self._abilities = abilities

    def __call__(self, path: str) -> EmulatedCapture:
        """An emulated capture whose pictures come from the socket at `path`; not open if nobody serves there."""
        plug = EmulatedCameraPlug(lambda stamp_s: _fetched(path, stamp_s, plug), self._abilities)
        try:
            _connected(Path(path)).close()
        except OSError:
            plug.unplug()
        return plug.open(path)


def ask(folder: Path, *words: str) -> dict[str, Any]:
    """One command to the control socket of a server.

    Raises:
        OSError: Nobody serves there.
        ValueError: The server does not understand.
    """
    with _connected(folder / CONTROL) as connection:
        connection.sendall((" ".join(words) + "\n").encode())
        with connection.makefile() as lines:
            reply: dict[str, Any] = json.loads(lines.readline())
    if "error" in reply:
        raise ValueError(reply["error"])
    return reply


def _connected(path: Path) -> socket.socket:
    connection = socket.socket(socket.AF_UNIX)
    connection.settimeout(_REPLY_S)
    try:
        connection.connect(str(path))
    except OSError:
        connection.close()
        raise
    return connection


def _fetched(path: str, stamp_s: float, plug: EmulatedCameraPlug) -> Frame:
    try:
        with _connected(Path(path)) as connection:
            connection.sendall(_STAMP.pack(stamp_s))
            height, width = _SHAPE.unpack(_received(connection, _SHAPE.size))
            return np.frombuffer(_received(connection, height * width), np.uint8).reshape(height, width)
    except (OSError, EOFError):
        plug.unplug()
        return _NOTHING


def _received(connection: socket.socket, count: int) -> bytes:
    data = bytearray()
    while len(data) < count:
        part = connection.recv(count - len(data))
        if not part:
            raise EOFError
        data += part
    return bytes(data)
