"""Where the foot stands, before the scan: the lines the lasers draw on it with the head at rest."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import LASER_NAMES, Floats, Frame, LaserName
from footscan.devices.interlock import Purpose
from footscan.devices.values import CameraFrame
from footscan.geometry.rigid import turn_z
from footscan.optics.tables import LightTable
from footscan.scanning.session.machine import Machine, Program
from footscan.scanning.stripe import automatic_threshold, find_stripe

_DARKEST_GREY = 25
"""Below it a picture without laser light would yield a stripe of noise."""


@dataclass(frozen=True)
class LitFrame:
    """A picture with one laser on, from one head angle."""

    laser: LaserName
    theta_rad: float
    frame: Frame


def look_at_foot(machine: Machine, into: list[LitFrame]) -> Program:
    """One picture with each laser, the head at rest; the machine is armed."""
    try:
        for laser in LASER_NAMES:
            machine.shine((laser,), Purpose.MEASURING)
            frames: list[CameraFrame] = []
            yield from machine.see(1, frames)
            into += [LitFrame(laser, machine.carriage.theta_rad, frame.frame) for frame in frames]
    finally:
        machine.quiet()


def lit_points(lit: LitFrame, tables: dict[LaserName, LightTable]) -> Floats:
    """`(n, 3)` world millimetres of the line in a picture."""
    stripe = find_stripe(lit.frame, max(automatic_threshold(lit.frame), _DARKEST_GREY))
    table = tables[lit.laser]
    xy_light = table.lookup(stripe.uv)
    xy_light = xy_light[np.isfinite(xy_light[:, 0])]
    world_from_light = turn_z(lit.theta_rad) @ table.world_from_light
    return xy_light @ world_from_light[:3, :2].T + world_from_light[:3, 3]
