"""The design of a scanner (scanner.toml), and the ideal calibration that follows from it (Table I, eq. 17-18)."""

from dataclasses import dataclass
from typing import Literal

from footscan.coordinates import LaserName
from footscan.geometry.plane import Plane
from footscan.optics.calibration import Calibration, EncoderScale, Pose
from footscan.optics.camera import Camera
from footscan.optics.head import Head, translation_from_head
from footscan.optics.sheet import LightPlane, ideal_normal

Sweep = Literal["ccw", "cw"]


@dataclass(frozen=True)
class LaserDesign:
    """One laser: its angle alpha beside the camera and the sweep it is used on."""

    name: LaserName
    alpha_rad: float
    sweep: Sweep


@dataclass(frozen=True)
class Scanner:
    """A machine as designed."""

    name: str
    machine_id: str | None
    camera: Camera
    head: Head
    lasers: tuple[LaserDesign, LaserDesign]
    encoder: EncoderScale


def calibration_from_design(scanner: Scanner) -> Calibration:
    """The calibration of a machine built exactly as designed: the paper's ideal case."""
    t_x, t_y, t_z = (float(t) for t in translation_from_head(scanner.head))
    right, left = (LightPlane(laser.name, ideal_normal(laser.alpha_rad), 0.0) for laser in scanner.lasers)
    return Calibration(
        scanner=scanner.name,
        machine_id=scanner.machine_id,
        camera=scanner.camera,
        pose=Pose(scanner.head.phi_rad, scanner.head.sigma_rad, (t_x, t_y, t_z)),
        lasers=(right, left),
        floor=Plane((0.0, 0.0, 1.0), 0.0),
        encoder=scanner.encoder,
        latency_s=0.0,
    )
