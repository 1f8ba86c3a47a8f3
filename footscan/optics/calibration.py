"""`Calibration`: one scanner as measured, or as designed, with everything the mathematics needs and nothing else."""

import hashlib
import json
from dataclasses import asdict, dataclass, field
from typing import cast

import numpy as np

from footscan.coordinates import Floats, LaserName, theta_from_count
from footscan.geometry.plane import Plane
from footscan.geometry.rigid import inverse_rigid, turn_z
from footscan.optics import head as heads
from footscan.optics.camera import Camera
from footscan.optics.sheet import LightPlane


@dataclass(frozen=True)
class Pose:
    """The camera in the world at theta = 0: R_WC from phi and sigma (eq. 16), T_WC (eq. 17)."""

    phi_rad: float
    sigma_rad: float
    translation_mm: tuple[float, float, float]


@dataclass(frozen=True)
class EncoderScale:
    """How counts become head angles.

    A disc mounted off its centre adds `eccentricity_rad * sin(theta - eccentricity_phase_rad)` to the angle.
    """

    steps_per_rev: int
    zero_count: int
    direction: int
    eccentricity_rad: float = 0.0
    eccentricity_phase_rad: float = 0.0


@dataclass(frozen=True)
class Calibration:
    """A machine: camera, pose, two light planes, footboard, encoder, latency between exposure and time stamp."""

    scanner: str
    machine_id: str | None
    camera: Camera
    pose: Pose
    lasers: tuple[LightPlane, LightPlane]
    floor: Plane
    encoder: EncoderScale
    latency_s: float
    created: str = field(default="", compare=False)

    def laser(self, name: LaserName) -> LightPlane:
        """The light plane of one laser.

        Raises:
            ValueError: No such laser.
        """
        for sheet in self.lasers:
            if sheet.name == name:
                return sheet
        raise ValueError(f"a laser is right or left, found {name!r}")


def camera_from_world(calibration: Calibration, theta_rad: float = 0.0) -> Floats:
    """4x4 of eq. (19) with the calibrated pose; at angle theta the head has turned about Z by theta."""
    pose = calibration.pose
    return heads.camera_from_world(theta_rad, pose.phi_rad, pose.sigma_rad, np.array(pose.translation_mm))


def optical_centre_world(calibration: Calibration, theta_rad: float = 0.0) -> Floats:
    """The optical centre `(3,)` in W."""
    world_from_camera = inverse_rigid(camera_from_world(calibration, theta_rad))
    return (world_from_camera @ np.array([calibration.camera.focal_length_mm, 0.0, 0.0, 1.0]))[:3]


def theta_from_encoder(count: Floats, encoder: EncoderScale) -> Floats:
    """Head angles (rad) of interpolated counts, eccentricity of the disc included."""
    theta = theta_from_count(count, encoder.zero_count, encoder.steps_per_rev, encoder.direction)
    return theta + encoder.eccentricity_rad * np.sin(theta - encoder.eccentricity_phase_rad)


def world_at_theta(world_from_light: Floats, theta_rad: float) -> Floats:
    """4x4 of a light system after the head has turned by theta; W^-1 of eq. (22) in the ideal case."""
    return turn_z(theta_rad) @ world_from_light


def fingerprint(calibration: Calibration) -> str:
    """sha256 over every number that shapes the tables and the cloud (name and date of creation left out)."""
    content = asdict(calibration)
    for key in ("created", "scanner", "machine_id"):
        del content[key]
    return hashlib.sha256(json.dumps(_rounded(content), sort_keys=True).encode()).hexdigest()


def _rounded(value: object) -> object:
    """Numbers to 11 significant digits: a calibration keeps its fingerprint when it goes through its file."""
    if isinstance(value, float):
        return f"{value:.10e}"
    if isinstance(value, dict):
        return {key: _rounded(part) for key, part in cast("dict[str, object]", value).items()}
    if isinstance(value, list | tuple):
        return [_rounded(part) for part in cast("list[object]", value)]
    return value
