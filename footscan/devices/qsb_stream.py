"""The lines a QSB streams, as samples: counts without wrap, times on the host's clock, nonsense counted and dropped."""

from collections import deque

import numpy as np

from footscan.coordinates import Floats
from footscan.devices import qsb_protocol as qsb
from footscan.devices.qsb_protocol import QsbReply
from footscan.devices.tick_clock import TickClock
from footscan.devices.values import EncoderReading, EncoderSamples
from footscan.errors import EncoderLostError

_EARLY_S = 0.05
_PATIENCE = 3
_KEPT = 300_000
"""Ten minutes of samples that nobody takes."""


class QsbStream:
    """Fed with lines and the host's time of their arrival; not safe for several threads.

    Attributes:
        garbled: Lines that were no reply, or whose tick cannot be.
        newest: The last sample.
    """

    def __init__(self, wire_s: float) -> None:
        self.garbled = 0
        self.newest: EncoderReading | None = None
        self._clock = TickClock(wire_s)
        self._tick: int | None = None
        self._count = 0
        self._early = self._backward = 0
        self._samples: deque[EncoderReading] = deque(maxlen=_KEPT)
        self._captures: deque[EncoderReading] = deque(maxlen=_KEPT)

    def feed(self, line: bytes, arrival_s: float) -> bool:
        """Take in a line; says whether it was a sample.

        Raises:
            EncoderLostError: The device has restarted: its count means nothing any more.
        """
        reply = qsb.reply_from_line(line)
        if reply is None:
            self._refuse_restart(qsb.is_banner(line))
            self.garbled += 1
            return False
        if reply.kind != "s" or reply.register not in (qsb.COUNT, qsb.CAPTURE):
            return False
        return self._take(reply, arrival_s)

    def take_samples(self) -> EncoderSamples:
        """All since the last call."""
        return _taken(self._samples)

    def take_captures(self) -> EncoderSamples:
        """Counts latched by the camera's strobe since the last call."""
        return _taken(self._captures)

    def _take(self, reply: QsbReply, arrival_s: float) -> bool:
        tick = self._plausible_tick(reply, arrival_s)
        if tick is None:
            self.garbled += 1
            return False
        count = qsb.unwrapped(reply.value, self._count)
        if reply.register == qsb.CAPTURE:
            self._captures.append(EncoderReading(count, self._clock.time_s(tick)))
            return False
        self._clock.add(tick, arrival_s)
        self._tick, self._count = tick, count
        self.newest = EncoderReading(count, self._ordered(self._clock.time_s(tick)))
        self._samples.append(self.newest)
        return True

    def _plausible_tick(self, reply: QsbReply, arrival_s: float) -> int | None:
        """The unwrapped tick, or None if one garbled digit explains it better; after some in a row it is believed."""
        if reply.tick is None:
            return None
        if self._tick is None:
            return reply.tick
        tick = qsb.unwrapped(reply.tick, self._tick)
        stream = reply.register == qsb.COUNT
        if tick < self._tick or (stream and tick == self._tick):
            self._backward += stream
            self._refuse_restart(self._backward > _PATIENCE)
            return None if stream else tick
        self._backward = 0
        if self._clock.delay_s(tick, arrival_s) < -_EARLY_S and self._early < _PATIENCE:
            self._early += 1
            return None
        self._early = 0
        return tick

    def _ordered(self, time_s: float) -> float:
        """A better fit may say that the last sample was later than this one; time still goes forward."""
        return time_s if self.newest is None else max(time_s, self.newest.time_s + 1e-6)

    def _refuse_restart(self, restarted: bool) -> None:
        if restarted:
            raise EncoderLostError(
                "the encoder's counter has restarted (its power or USB connection failed for a moment) and has lost "
                "its count; check the cable, then start again and home the head."
            )


def _taken(readings: deque[EncoderReading]) -> EncoderSamples:
    time_s: Floats = np.array([reading.time_s for reading in readings], dtype=np.float64)
    count = np.array([reading.count for reading in readings], dtype=np.int64)
    readings.clear()
    return EncoderSamples(time_s, count)
