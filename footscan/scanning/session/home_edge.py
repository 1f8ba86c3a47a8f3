"""Where the home switch opens, by the counter: looks at the switch bracket it, and several crossings narrow it down.

Through a slow line the head turns half a degree between two looks. Each further crossing therefore puts a look where
the head is in the middle of what is left, and halves it.
"""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from footscan.errors import DeviceError, HeadStalledError
from footscan.scanning.session.machine import Machine, Program

EDGE_ROUND_S = 0.002
"""Between two looks at the home switch while the head leaves it: what it is late by turns the whole foot."""
WELL_KNOWN_RAD = float(np.deg2rad(0.02))
"""Standard deviation of the edge at which it need not be crossed again: 0.03 mm at the toe."""
MOST_CROSSINGS = 8
_RUN_UP_S = 0.12
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


@dataclass(frozen=True)
class _Look:
    """How long after it was wanted the module looked, and how long the whole round took."""

    lead_s: float = 0.0
    takes_s: float = 0.0


def fit_edge(crossings: list[Crossing]) -> tuple[float, float]:
    """Count at which the switch opens and its standard deviation.

    It lies in what all crossings have in common. A switch that plays leaves nothing: then narrow crossings count more.
    """
    low = max(min(crossing.closed_counts, crossing.open_counts) for crossing in crossings)
    high = min(max(crossing.closed_counts, crossing.open_counts) for crossing in crossings)
    if low <= high:
        common = Crossing(low, high)
        return common.middle_counts, common.sigma_counts
    weight = np.array([crossing.sigma_counts**-2 for crossing in crossings])
    middle = np.array([crossing.middle_counts for crossing in crossings])
    mean = float(weight @ middle / weight.sum())
    return mean, float(np.hypot(weight.sum() ** -0.5, middle.std()))


def find_edge(machine: Machine, search_step: int) -> Generator[None, None, float]:
    """Cross the home switch counter-clockwise until the count at which it opens is well known; returns the count.

    Raises:
        HeadStalledError: The switch does not change.
    """
    counts_per_rad = machine.carriage.drive.steps_per_rev / (2.0 * np.pi)
    crossings: list[Crossing] = []
    yield from _go_behind_switch(machine, search_step)
    while True:
        aim_counts = fit_edge(crossings)[0] if crossings else np.inf
        crossings.append((yield from _cross(machine, aim_counts)))
        edge_counts, sigma_counts = fit_edge(crossings)
        if sigma_counts <= WELL_KNOWN_RAD * counts_per_rad or len(crossings) == MOST_CROSSINGS:
            return edge_counts
        yield from machine.come_to_rest()
        yield from _go_back(machine, edge_counts)


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


def _go_back(machine: Machine, edge_counts: float) -> Program:
    """Behind the edge so far that the head turns evenly when it comes there again."""
    drive = machine.carriage.drive
    run_up_rad = drive.stopping_rad(0) + _RUN_UP_S * drive.speeds_rad_s[0]
    run_up_counts = run_up_rad * drive.steps_per_rev / (2.0 * np.pi)

    def far_enough() -> bool:
        return machine.inputs.home and abs(machine.carriage.count - edge_counts) > run_up_counts

    machine.carriage.turn(ccw=False, speed_step=0)
    yield from machine.until(far_enough, search_s(machine, 0), lambda: no_home(machine))
    yield from machine.come_to_rest()


def _cross(machine: Machine, aim_counts: float) -> Generator[None, None, Crossing]:
    """Leave the switch at the slowest speed, still turning at the end; one look is put where `aim_counts` shows."""
    carriage = machine.carriage
    carriage.turn(ccw=True, speed_step=0)
    closed_s, gives_up_s = machine.inputs.time_s, machine.clock.now_s() + search_s(machine, 0)
    look = _Look()
    while machine.inputs.home:
        closed_s = machine.inputs.time_s
        if machine.clock.now_s() > gives_up_s:
            raise no_home(machine)
        machine.wake_s = asked_s = _next_look_s(machine, aim_counts, look)
        machine.clock.wait(asked_s)  # a frame that comes meanwhile must not bring the look forward
        yield
        look = _Look(max(machine.inputs.time_s - asked_s, 0.0), machine.clock.now_s() - asked_s)
    open_s = machine.inputs.time_s
    while carriage.newest_s < open_s:  # a silent encoder is told by the carriage
        yield
    return Crossing(carriage.count_at(closed_s), carriage.count_at(open_s))


def _next_look_s(machine: Machine, aim_counts: float, look: _Look) -> float:
    """When to ask next: soon, or so that the module looks at the aim if no other look fits in before."""
    carriage, soon_s = machine.carriage, machine.clock.now_s() + EDGE_ROUND_S
    rate = carriage.drive.direction * carriage.speed_rad_s * carriage.drive.steps_per_rev / (2.0 * np.pi)
    if rate == 0.0 or not np.isfinite(aim_counts):
        return soon_s
    aimed_s = carriage.newest_s + (aim_counts - carriage.count_at(carriage.newest_s)) / rate - look.lead_s
    return aimed_s if soon_s < aimed_s < soon_s + look.takes_s + EDGE_ROUND_S else soon_s
