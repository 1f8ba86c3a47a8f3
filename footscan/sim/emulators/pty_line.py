"""A serial line to an emulated device: a pseudo terminal with a wire's speed, that garbles at another baud rate."""

import contextlib
import heapq
import os
import select
import termios
import threading
import time
import tty
from collections.abc import Iterable
from pathlib import Path
from typing import Protocol

Spoken = Iterable[tuple[float, bytes]]
"""What a device says, each with the moment it begins to say it."""


class WireDevice(Protocol):
    """A device at the end of a serial line, as a state machine that knows no port and no thread."""

    @property
    def baud(self) -> int:
        """As set in the device."""
        ...

    def hear(self, data: bytes, time_s: float) -> Spoken:
        """Bytes have arrived."""
        ...

    def due_s(self) -> float:
        """When it wants to do something by itself; infinity if never."""
        ...

    def act(self, time_s: float) -> Spoken:
        """That moment has come, or passed."""
        ...


class PtyLine:
    """One emulated device behind a port that a driver opens; a thread of its own carries the bytes.

    Attributes:
        dropped_bytes: Said while nobody listened and the buffers were full.
    """

    def __init__(self, device: WireDevice, link: Path | None = None, bridge_s: float = 0.0) -> None:
        """Plug it in.

        Args:
            device: What answers.
            link: A symbolic link to the port, that stays the same when it is unplugged and plugged in again.
            bridge_s: A USB bridge passes bytes on at multiples of this (its latency timer) only.
        """
        self.dropped_bytes = 0
        self._device, self._link, self._bridge_s = device, link, bridge_s
        self._lock = threading.Lock()
        self._line: _Line | None = None
        self._alone = threading.Event()
        self.plug()

    @property
    def port(self) -> str:
        """The path a driver opens."""
        if self._link is not None:
            return str(self._link)
        return "/nonexistent" if self._line is None else self._line.path

    def plug(self) -> None:
        """Plug it in (again)."""
        with self._lock:
            if self._line is None:
                self._alone.set()
                self._line = _Line(self._device, self._bridge_s)
                _point(self._link, self._line.path)

    def unplug(self) -> None:
        """Pull the cable: the port is gone, the device lives on."""
        if self._pull():
            self._alone = threading.Event()
            threading.Thread(target=self._live_on, args=(self._alone,), name="emulator alone", daemon=True).start()

    def close(self) -> None:
        """End of the emulation."""
        self._alone.set()
        self._pull()

    def _pull(self) -> bool:
        with self._lock:
            if self._line is None:
                return False
            self._line.close()
            self.dropped_bytes += self._line.dropped_bytes
            self._line = None
            if self._link is not None:
                self._link.unlink(missing_ok=True)
            return True

    def _live_on(self, ended: threading.Event) -> None:
        while not ended.wait(0.005):
            if self._device.due_s() <= time.monotonic():
                self._device.act(time.monotonic())


class _Line:
    """A pty while it is plugged in."""

    def __init__(self, device: WireDevice, bridge_s: float) -> None:
        self._device, self._bridge_s = device, bridge_s
        self._master, self._slave = os.openpty()
        tty.setraw(self._master)
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.path, self.dropped_bytes = os.ttyname(self._slave), 0
        self._wake_r, self._wake_w = os.pipe()
        self._in: list[tuple[float, int, bytes]] = []
        self._out: list[tuple[float, int, bytes]] = []
        self._number, self._in_free_s, self._out_free_s = 0, 0.0, 0.0
        self._thread = threading.Thread(target=self._carry, name=f"emulator {self.path}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        os.write(self._wake_w, b"x")
        self._thread.join()
        for descriptor in (self._master, self._slave, self._wake_r, self._wake_w):
            os.close(descriptor)

    def _carry(self) -> None:
        while True:
            ready, _, _ = select.select([self._master, self._wake_r], [], [], self._patience_s())
            if self._wake_r in ready:
                return
            if self._master in ready:
                self._hear(time.monotonic())
            self._pass(time.monotonic())

    def _patience_s(self) -> float:
        moments = [queue[0][0] for queue in (self._in, self._out) if queue]
        return min(max(min([*moments, self._device.due_s()], default=1.0) - time.monotonic(), 0.0), 0.02)

    def _hear(self, now_s: float) -> None:
        with contextlib.suppress(OSError):
            data = self._clean(os.read(self._master, 4096))
            self._in_free_s = max(self._in_free_s, now_s) + self._wire_s(data)
            self._push(self._in, self._in_free_s, data)

    def _pass(self, now_s: float) -> None:
        while self._in and self._in[0][0] <= now_s:
            moment_s, _, data = heapq.heappop(self._in)
            self._say(self._device.hear(data, moment_s))
        if self._device.due_s() <= now_s:
            self._say(self._device.act(now_s))
        while self._out and self._out[0][0] <= now_s:
            self._deliver(heapq.heappop(self._out)[2])

    def _say(self, spoken: Spoken) -> None:
        for begin_s, data in spoken:
            self._out_free_s = max(self._out_free_s, begin_s) + self._wire_s(data)
            arrives_s = self._out_free_s
            if self._bridge_s:
                arrives_s = -(-arrives_s // self._bridge_s) * self._bridge_s
            self._push(self._out, arrives_s, data)

    def _push(self, queue: list[tuple[float, int, bytes]], moment_s: float, data: bytes) -> None:
        self._number += 1
        heapq.heappush(queue, (moment_s, self._number, data))

    def _deliver(self, data: bytes) -> None:
        sent = 0
        with contextlib.suppress(BlockingIOError):
            sent = os.write(self._master, self._clean(data))
        self.dropped_bytes += len(data) - sent

    def _wire_s(self, data: bytes) -> float:
        return len(data) * 10 / self._device.baud

    def _clean(self, data: bytes) -> bytes:
        """What the other side gets: nonsense unless both have set the same speed."""
        speed = termios.tcgetattr(self._slave)[5]
        return data if speed == getattr(termios, f"B{self._device.baud}") else bytes(b * 83 & 0xFF | 0x80 for b in data)


def _point(link: Path | None, path: str) -> None:
    if link is not None:
        link.parent.mkdir(parents=True, exist_ok=True)
        link.unlink(missing_ok=True)
        link.symlink_to(path)
