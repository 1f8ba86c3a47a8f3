"""How many pictures a second the simulator paints, on one thread."""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from footscan.coordinates import LASER_NAMES
from footscan.optics.scanner import Scanner
from footscan.sim.machine import workshop_machine
from footscan.sim.objects import build_object
from footscan.sim.person import CALM, Person
from footscan.sim.picture import Painter

_SEED = 7


@dataclass(frozen=True)
class PictureTiming:
    """Of one object: its name, the pictures' size, and minimum and median milliseconds."""

    name: str
    size: str
    ms: tuple[float, float]


def time_pictures(scanner: Scanner, frames: int, mesh: Path | None = None) -> Iterator[PictureTiming]:
    """A foot that stands still, one that breathes, and a mesh (in metres) if given: head angles all round a turn.

    Raises:
        InputError: The mesh cannot be used.
    """
    yield _timed("foot", "foot", scanner, frames, breathing=False)
    yield _timed("foot, breathing", "foot", scanner, frames, breathing=True)
    if mesh is not None:
        yield _timed(mesh.name, str(mesh), scanner, frames, breathing=False)


def _timed(name: str, thing: str, scanner: Scanner, frames: int, breathing: bool) -> PictureTiming:
    surface = build_object(thing, "m")
    person = Person(surface, CALM, _SEED) if breathing else None
    painter = Painter(workshop_machine(scanner, _SEED).calibration, surface, seed=_SEED)
    took_ms: list[float] = []
    with threadpool_limits(1):
        for number, theta_rad in enumerate(np.linspace(0.0, 2.0 * np.pi, frames + 1)):
            began_s = time.perf_counter()
            if person is not None:
                painter.set_vertices(person.xyz_world_at(number / 25.0))
            painter.paint(float(theta_rad), LASER_NAMES[number % 2], number)
            took_ms.append(1000.0 * (time.perf_counter() - began_s))
    steady = np.array(took_ms[1:])  # the first one compiles
    camera = scanner.camera
    return PictureTiming(name, f"{camera.width_px}x{camera.height_px}", (float(steady.min()), float(np.median(steady))))
