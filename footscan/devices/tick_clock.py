"""Host seconds of a device's own ticks, although every line arrives late by an unknown, always positive time.

Arrival = a + b tick + delay with delay > 0: the line below all arrivals that lies closest to them on average. Of each
quarter second only the least delayed arrival is kept; ten seconds are looked at.
"""

from collections import deque

import numpy as np

from footscan.coordinates import Floats
from footscan.devices.qsb_protocol import TICKS_PER_S

_BLOCK_TICKS = 128
_BLOCKS = 40
_LEAST_SPAN_S = 6.0
_CRYSTAL_ERROR = 1.5e-4


class TickClock:
    """Fitted again with each arrival that matters; ticks are unwrapped integers."""

    def __init__(self, wire_s: float) -> None:
        """A line is `wire_s` on the wire before it has arrived."""
        self._wire_s = wire_s
        self._blocks: deque[tuple[int, float, float]] = deque(maxlen=_BLOCKS)
        self._first_tick, self._first_s = 0, 0.0
        self._late_s, self._slope = 0.0, 0.0

    def add(self, tick: int, arrival_s: float) -> None:
        """A line with this tick has arrived."""
        if not self._blocks:
            self._first_tick, self._first_s = tick, arrival_s
        since_s = self._since_s(tick)
        late_s, block = arrival_s - self._first_s - since_s, tick // _BLOCK_TICKS
        if self._blocks and self._blocks[-1][0] == block:
            if late_s >= self._blocks[-1][2]:
                return
            self._blocks.pop()
        self._blocks.append((block, since_s, late_s))
        self._fit()

    def time_s(self, tick: int) -> float:
        """When the device's clock showed `tick`; means nothing before an arrival."""
        since_s = self._since_s(tick)
        return self._first_s + since_s + self._late_s + self._slope * since_s - self._wire_s

    def delay_s(self, tick: int, arrival_s: float) -> float:
        """How much later than the quickest lines this one arrives; 0 before an arrival."""
        return arrival_s - self.time_s(tick) - self._wire_s if self._blocks else 0.0

    def _since_s(self, tick: int) -> float:
        return (tick - self._first_tick) / TICKS_PER_S

    def _fit(self) -> None:
        since_s = np.array([since for _, since, _ in self._blocks])
        late_s = np.array([late for _, _, late in self._blocks])
        long_enough = since_s[-1] - since_s[0] > _LEAST_SPAN_S
        self._slope, self._late_s = lower_line(since_s, late_s) if long_enough else (0.0, float(late_s.min()))


def lower_line(x: Floats, y: Floats, steepest: float = _CRYSTAL_ERROR) -> tuple[float, float]:
    """Slope and intercept of the line below all points `(n,)`, `x` rising, that lies closest to them on average.

    It runs through the edge of the lower hull under the mean of `x`; the slope is kept within `steepest`.
    """
    hull: list[int] = []
    for i in range(len(x)):
        while len(hull) > 1 and _not_below(x, y, hull[-2], hull[-1], i):
            hull.pop()
        hull.append(i)
    if len(hull) < 2:
        return 0.0, float(y.min())
    right = min(max(int(np.searchsorted(x[hull], x.mean())), 1), len(hull) - 1)
    first, second = hull[right - 1], hull[right]
    slope = float(np.clip((y[second] - y[first]) / (x[second] - x[first]), -steepest, steepest))
    return slope, float((y - slope * x).min())


def _not_below(x: Floats, y: Floats, first: int, middle: int, last: int) -> bool:
    """The middle point is on or above the line from the first to the last."""
    turn = (x[middle] - x[first]) * (y[last] - y[first]) - (y[middle] - y[first]) * (x[last] - x[first])
    return bool(turn <= 0)
