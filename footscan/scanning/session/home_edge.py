"""Where the home switch opens, by the counter: looks at the switch bracket it, and several crossings narrow it down."""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from footscan.errors import DeviceError, HeadStalledError
from footscan.scanning.session.machine import Machine, Program

EDGE_ROUND_S = 0.002
"""Between two looks at the home switch while the head leaves it: what it is late by turns the whole foot."""
WELL_KNOWN_RAD = float(np.deg2rad(0.02))
"""Standard deviation of the edge at which it need not be crossed again: 0.03 mm at the toe."""
MOST_CROSSINGS = 4
_LOOK_COUNTS = 1.0
"""A count is read to the nearest step."""


@dataclass(frozen=True)
class Crossing:
    """The counter at the last look that showed the switch closed and at the first that showed it open."""

    closed_counts: float
    open_counts: float

    @property
    def middle_counts(self) -> float:
        """Where the switch opened, as far as this crossing tells."""
        return 0.5 * (self.closed_counts + self.open_counts)

    @property
    def sigma_counts(self) -> float:
        """Standard deviation of an edge that may lie anywhere between."""
        return float(np.hypot(self.open_counts - self.closed_counts, _LOOK_COUNTS)) / np.sqrt(12.0)


def fit_edge(crossings: list[Crossing]) -> tuple[float, float]:
    """Count at which the switch opens and its standard deviation; narrow crossings count more."""
    weight = np.array([crossing.sigma_counts**-2 for crossing in crossings])
    middle = np.array([crossing.middle_counts for crossing in crossings])
    return float(weight @ middle / weight.sum()), float(weight.sum() ** -0.5)


def find_edge(machine: Machine, search_step: int) -> Generator[None, None, float]:
    """Cross the home switch counter-clockwise until the count at which it opens is well known; returns the count.

    Raises:
        HeadStalledError: The switch does not change.
    """
    counts_per_rad = machine.carriage.drive.steps_per_rev / (2.0 * np.pi)
    crossings: list[Crossing] = []
    while True:
        yield from _go_behind_switch(machine, 0 if crossings else search_step)
        crossings.append((yield from _cross(machine)))
        edge_counts, sigma_counts = fit_edge(crossings)
        if sigma_counts <= WELL_KNOWN_RAD * counts_per_rad or len(crossings) == MOST_CROSSINGS:
            return edge_counts
        yield from machine.come_to_rest()


def search_s(machine: Machine, speed_step: int) -> float:
    """The whole travel at a speed takes no longer."""
    low, high = machine.motion.travel_deg
    return 1.3 * (high - low) / machine.motion.speeds_deg_per_s[speed_step] + 2.0


def no_home(machine: Machine) -> DeviceError:
    """The switch did not change."""
    return HeadStalledError(
        f"the home switch did not change while the head turned {'' if machine.inputs.home else 'clockwise '}through "
        "its whole travel; check the switch, its cable and its input in the rig file."
    )


def _go_behind_switch(machine: Machine, speed_step: int) -> Program:
    if machine.inputs.home:
        return
    machine.carriage.turn(ccw=False, speed_step=speed_step)
    yield from machine.until(lambda: machine.inputs.home, search_s(machine, speed_step), lambda: no_home(machine))
    yield from machine.come_to_rest()


def _cross(machine: Machine) -> Generator[None, None, Crossing]:
    """Leave the switch at the slowest speed, still turning at the end."""
    carriage = machine.carriage
    carriage.turn(ccw=True, speed_step=0)
    closed_s, gives_up_s = machine.inputs.time_s, machine.clock.now_s() + search_s(machine, 0)
    while machine.inputs.home:
        closed_s = machine.inputs.time_s
        if machine.clock.now_s() > gives_up_s:
            raise no_home(machine)
        machine.wake_s = machine.clock.now_s() + EDGE_ROUND_S
        yield
    open_s = machine.inputs.time_s
    while carriage.newest_s < open_s:  # a silent encoder is told by the carriage
        yield
    return Crossing(carriage.count_at(closed_s), carriage.count_at(open_s))
