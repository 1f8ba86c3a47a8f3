"""Laser light at rest for adjusting threshold and exposure: it shines only while somebody keeps the button down."""

from collections.abc import Callable

from footscan.coordinates import LaserName
from footscan.devices.interlock import Purpose
from footscan.scanning.session.machine import Machine, Program
from footscan.scanning.session.states import State

HELD_FOR_S = 0.6
"""Between two messages of a button held down; a page that falls silent for longer lets go."""


def shine_while_held(machine: Machine, laser: LaserName, asked_s: Callable[[], float]) -> Program:
    """Shine as long as the button is held.

    Args:
        machine: On the control thread.
        laser: Which one.
        asked_s: When the button was last known to be down, on the machine's clock.
    """
    machine.say(State.HOLDING)
    try:
        while machine.clock.now_s() - asked_s() < HELD_FOR_S:
            machine.shine((laser,), Purpose.HELD)
            yield
    finally:
        machine.quiet()
    machine.say(State.PARKED if machine.carriage.homed else State.CONNECTED)
