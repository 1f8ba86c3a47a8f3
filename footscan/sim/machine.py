"""True machines: the design, and the design as a workshop builds it, a little off everywhere."""

from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Floats
from footscan.geometry.plane import Plane
from footscan.optics import Calibration, Camera, EncoderScale, LightPlane, Pose
from footscan.optics.scanner import LaserDesign, Scanner, calibration_from_design
from footscan.optics.sheet import ideal_normal


@dataclass(frozen=True)
class Tolerances:
    """How far a built machine may be from its design, each way, evenly spread.

    Attributes:
        focal_length: Relative.
        principal_point_px: Of either coordinate.
        distortion: Largest relative shift of the picture's corner; the smallest is a quarter of it.
        pose_rad: Of phi; a third of it of sigma.
        place_mm: Of the camera along x_C and z_C; a third of it along y_C.
        alpha_rad: Of a light plane about the vertical.
        lean_rad: Of a light plane out of the vertical.
        offset_mm: Of a light plane from the axis.
        floor_rad: Lean of the footboard.
        eccentricity_rad: Of the encoder disc, at most.
        latency_s: Between exposure and time stamp, at most.
    """

    focal_length: float = 0.003
    principal_point_px: float = 4.0
    distortion: float = 0.012
    pose_rad: float = np.deg2rad(0.5)
    place_mm: float = 4.0
    alpha_rad: float = np.deg2rad(0.6)
    lean_rad: float = np.deg2rad(0.15)
    offset_mm: float = 0.5
    floor_rad: float = np.deg2rad(0.08)
    eccentricity_rad: float = 3e-4
    latency_s: float = 0.025


WORKSHOP = Tolerances()


@dataclass(frozen=True)
class TrueMachine:
    """A machine that exists only here: what its papers say and what it really is."""

    scanner: Scanner
    calibration: Calibration


def ideal_machine(scanner: Scanner) -> TrueMachine:
    """A machine built exactly as designed."""
    return TrueMachine(scanner, calibration_from_design(scanner))


def workshop_machine(scanner: Scanner, seed: int, tolerances: Tolerances = WORKSHOP) -> TrueMachine:
    """A machine as it leaves a workshop; the same seed gives the same machine."""
    random = np.random.default_rng([seed, 0x3AC41E])
    name = scanner.machine_id or f"sim-{seed}"
    design = calibration_from_design(scanner)
    right, left = (_built_sheet(laser, random, tolerances) for laser in scanner.lasers)
    calibration = replace(
        design,
        machine_id=name,
        camera=_built_camera(scanner.camera, random, tolerances),
        pose=_built_pose(design.pose, random, tolerances),
        lasers=(right, left),
        floor=_built_floor(random, tolerances),
        encoder=_built_encoder(scanner.encoder, random, tolerances),
        latency_s=float(random.uniform(0.0, tolerances.latency_s)),
    )
    return TrueMachine(replace(scanner, machine_id=name), calibration)


def _either_way(random: np.random.Generator, most: float) -> float:
    return float(random.uniform(-most, most))


def _built_camera(camera: Camera, random: np.random.Generator, most: Tolerances) -> Camera:
    corner_mm2 = (0.5 * camera.width_px * camera.horizontal_scale * camera.pixel_pitch_y_mm) ** 2
    corner_mm2 += (0.5 * camera.height_px * camera.pixel_pitch_z_mm) ** 2
    c_y, c_z = (c + _either_way(random, most.principal_point_px) for c in camera.principal_point_px)
    return replace(
        camera,
        focal_length_mm=camera.focal_length_mm * (1.0 + _either_way(random, most.focal_length)),
        principal_point_px=(c_y, c_z),
        k1_per_mm2=camera.k1_per_mm2 - float(random.uniform(0.25, 1.0)) * most.distortion / corner_mm2,
        k2_per_mm4=camera.k2_per_mm4 + _either_way(random, 0.05) * most.distortion / corner_mm2**2,
    )


def _built_pose(pose: Pose, random: np.random.Generator, most: Tolerances) -> Pose:
    t_x, t_y, t_z = pose.translation_mm
    return Pose(
        pose.phi_rad + _either_way(random, most.pose_rad),
        pose.sigma_rad + _either_way(random, most.pose_rad / 3.0),
        (
            t_x + _either_way(random, most.place_mm),
            t_y + _either_way(random, most.place_mm / 3.0),
            t_z + _either_way(random, most.place_mm),
        ),
    )


def _built_sheet(laser: LaserDesign, random: np.random.Generator, most: Tolerances) -> LightPlane:
    n_x, n_y, _ = ideal_normal(laser.alpha_rad + _either_way(random, most.alpha_rad))
    lean = _either_way(random, most.lean_rad)
    c, s = float(np.cos(lean)), float(np.sin(lean))
    return LightPlane(laser.name, (c * n_x, c * n_y, s), _either_way(random, most.offset_mm))


def _built_floor(random: np.random.Generator, most: Tolerances) -> Plane:
    lean, towards = _either_way(random, most.floor_rad), float(random.uniform(0.0, 2.0 * np.pi))
    s = np.sin(lean)
    return Plane((float(s * np.cos(towards)), float(s * np.sin(towards)), float(np.cos(lean))), 0.0)


def _built_encoder(encoder: EncoderScale, random: np.random.Generator, most: Tolerances) -> EncoderScale:
    return replace(
        encoder,
        zero_count=int(random.integers(0, encoder.steps_per_rev)),
        eccentricity_rad=float(random.uniform(0.0, most.eccentricity_rad)),
        eccentricity_phase_rad=float(random.uniform(0.0, 2.0 * np.pi)),
    )


def world_from_board(floor: Plane) -> Floats:
    """4x4 that lays what stands on z = 0 onto the machine's own, slightly leaning board."""
    up = floor.normal_array
    x = np.array([up[2], 0.0, -up[0]]) / np.hypot(up[0], up[2])
    result = np.eye(4)
    result[:3, :3] = np.stack([x, np.cross(up, x), up], axis=1)
    result[:3, 3] = floor.offset_mm * up
    return result
