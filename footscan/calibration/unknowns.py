"""Which unknowns an estimate leaves free, and what is known of some of them beforehand."""

from dataclasses import dataclass

import numpy as np

from footscan.calibration.estimate import CAMERA, FLOOR, HEAD, LEFT, POSE, RIGHT
from footscan.coordinates import Floats


@dataclass(frozen=True)
class Prior:
    """What is known of an unknown of the camera beforehand: its value as designed, and how far it may be from it."""

    name: str
    value: float
    deviation: float


@dataclass(frozen=True)
class Unknowns:
    """Which unknowns of the machine and of the boards are free, and what is known of the machine's beforehand."""

    machine: tuple[str, ...]
    boards: tuple[str, ...] = POSE
    priors: tuple[Prior, ...] = ()

    def names(self, placements: int) -> list[str]:
        """All of them, in the order of the columns."""
        return [*self.machine, *(f"{name}[{p}]" for p in range(placements) for name in self.boards)]


FIRMNESS = {"stretch_x": 1e4, "stretch_y": 1e4, "lens_y_px": 1e-2, "lens_z_px": 1e-2}
"""1 / variance that holds doubts where their common part cannot be seen: 1 % of stretch, 10 px of lens."""


def firmness(unknowns: Unknowns, placements: int) -> Floats:
    """1 / variance `(k,)` with which each unknown is held; 0 for all but doubts and what has a prior."""
    held = FIRMNESS | {prior.name: 1.0 / prior.deviation**2 for prior in unknowns.priors}
    return np.array([held.get(name.split("[")[0], 0.0) for name in unknowns.names(placements)])


EVERYTHING = Unknowns((*CAMERA, *HEAD, *RIGHT, *LEFT, *FLOOR, "latency_s"))
POSES_ONLY = Unknowns(())
