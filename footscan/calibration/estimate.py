"""What the joint estimate looks for: a machine, where each board lay, and small doubts about boards and lens.

Unknowns are moved by small steps from where they stand, so that no parameter needs a global chart.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from footscan.coordinates import Floats
from footscan.geometry.plane import Plane
from footscan.optics import Calibration, LightPlane

POSE = ("turn_x_rad", "turn_y_rad", "turn_z_rad", "shift_x_mm", "shift_y_mm", "shift_z_mm")
"""Unknowns of every board: a small turn about its middle and a shift, both along the axes of W."""

SHAPE = ("stretch_x", "stretch_y", "bend_xx_per_mm", "bend_yy_per_mm", "bend_xy_per_mm")
LENS = ("lens_y_px", "lens_z_px")
DOUBTS = SHAPE + LENS
"""What should not differ between placements; only freed to explain a bad fit."""


@dataclass(frozen=True)
class Estimate:
    """A machine and its boards.

    Attributes:
        machine: The calibration as far as it is known.
        world_from_board: `(p, 4, 4)` per placement; x along the board's rows of squares, z away from the viewer.
        doubts: `(p, 7)` per placement: stretch of the board in x and y, its bending, shift of the picture.
    """

    machine: Calibration
    world_from_board: Floats
    doubts: Floats

    @property
    def placements(self) -> int:
        """Number of placements."""
        return len(self.world_from_board)


def start_estimate(machine: Calibration, world_from_board: Floats) -> Estimate:
    """An estimate without doubts."""
    return Estimate(machine, world_from_board, np.zeros((len(world_from_board), len(DOUBTS))))


def moved_machine(machine: Calibration, name: str, step: float) -> Calibration:
    """The machine with one unknown changed by a step.

    Raises:
        KeyError: No such unknown.
    """
    return MACHINE_MOVES[name](machine, step)


def moved_boards(estimate: Estimate, name: str, step: Floats) -> Estimate:
    """One unknown of all boards changed, each board by its own step `(p,)`."""
    if name in DOUBTS:
        doubts = estimate.doubts.copy()
        doubts[:, DOUBTS.index(name)] += step
        return replace(estimate, doubts=doubts)
    vector = np.zeros((estimate.placements, 3))
    vector[:, "xyz".index(name[name.index("_") + 1])] = step
    placed = estimate.world_from_board.copy()
    if name in POSE[:3]:
        placed[:, :3, :3] = Rotation.from_rotvec(vector).as_matrix() @ placed[:, :3, :3]
    else:
        placed[:, :3, 3] += vector
    return replace(estimate, world_from_board=placed)


def _camera(key: str) -> Callable[[Calibration, float], Calibration]:
    return lambda m, step: replace(m, camera=replace(m.camera, **{key: getattr(m.camera, key) + step}))


def _principal(axis: int) -> Callable[[Calibration, float], Calibration]:
    def move(machine: Calibration, step: float) -> Calibration:
        c_y, c_z = machine.camera.principal_point_px
        place = (c_y + step, c_z) if axis == 0 else (c_y, c_z + step)
        return replace(machine, camera=replace(machine.camera, principal_point_px=place))

    return move


def _pose(key: str) -> Callable[[Calibration, float], Calibration]:
    return lambda m, step: replace(m, pose=replace(m.pose, **{key: getattr(m.pose, key) + step}))


def _translation(axis: int) -> Callable[[Calibration, float], Calibration]:
    def move(machine: Calibration, step: float) -> Calibration:
        t = list(machine.pose.translation_mm)
        t[axis] += step
        return replace(machine, pose=replace(machine.pose, translation_mm=(t[0], t[1], t[2])))

    return move


def sheet_from_angles(sheet: LightPlane, azimuth_rad: float, lean_rad: float, offset_mm: float) -> LightPlane:
    """A sheet whose normal leans by `lean_rad` out of the horizontal, at `azimuth_rad` from the direction of y_W."""
    c, s = float(np.cos(lean_rad)), float(np.sin(lean_rad))
    normal = (-c * float(np.sin(azimuth_rad)), c * float(np.cos(azimuth_rad)), s)
    return LightPlane(sheet.name, normal, offset_mm)


def _sheet(which: int, part: int) -> Callable[[Calibration, float], Calibration]:
    def move(machine: Calibration, step: float) -> Calibration:
        sheet = machine.lasers[which]
        n_x, n_y, n_z = sheet.normal
        angles = [float(np.arctan2(-n_x, n_y)), float(np.arcsin(n_z)), sheet.offset_mm]
        angles[part] += step
        sheets = list(machine.lasers)
        sheets[which] = sheet_from_angles(sheet, angles[0], angles[1], angles[2])
        return replace(machine, lasers=(sheets[0], sheets[1]))

    return move


def _floor(axis: int) -> Callable[[Calibration, float], Calibration]:
    def move(machine: Calibration, step: float) -> Calibration:
        normal = machine.floor.normal_array
        slope = normal[:2] / normal[2]
        slope[axis] += step
        up = np.array([slope[0], slope[1], 1.0]) / np.sqrt(1.0 + slope @ slope)
        return replace(machine, floor=Plane((float(up[0]), float(up[1]), float(up[2])), machine.floor.offset_mm))

    return move


def _latency(machine: Calibration, step: float) -> Calibration:
    return replace(machine, latency_s=machine.latency_s + step)


def _eccentricity(part: int) -> Callable[[Calibration, float], Calibration]:
    def move(machine: Calibration, step: float) -> Calibration:
        encoder = machine.encoder
        size, phase = encoder.eccentricity_rad, encoder.eccentricity_phase_rad
        parts = [size * np.cos(phase), size * np.sin(phase)]
        parts[part] += step
        size, phase = float(np.hypot(*parts)), float(np.arctan2(parts[1], parts[0]))
        return replace(machine, encoder=replace(encoder, eccentricity_rad=size, eccentricity_phase_rad=phase))

    return move


MACHINE_MOVES: dict[str, Callable[[Calibration, float], Calibration]] = {
    "focal_length_mm": _camera("focal_length_mm"),
    "principal_point_y_px": _principal(0),
    "principal_point_z_px": _principal(1),
    "k1_per_mm2": _camera("k1_per_mm2"),
    "k2_per_mm4": _camera("k2_per_mm4"),
    "horizontal_scale": _camera("horizontal_scale"),
    "phi_rad": _pose("phi_rad"),
    "sigma_rad": _pose("sigma_rad"),
    "t_x_mm": _translation(0),
    "t_y_mm": _translation(1),
    "t_z_mm": _translation(2),
    "right_azimuth_rad": _sheet(0, 0),
    "right_lean_rad": _sheet(0, 1),
    "right_offset_mm": _sheet(0, 2),
    "left_azimuth_rad": _sheet(1, 0),
    "left_lean_rad": _sheet(1, 1),
    "left_offset_mm": _sheet(1, 2),
    "floor_slope_x": _floor(0),
    "floor_slope_y": _floor(1),
    "latency_s": _latency,
    "eccentricity_cos_rad": _eccentricity(0),
    "eccentricity_sin_rad": _eccentricity(1),
}
"""Every unknown of the machine, and how it is moved."""

STEPS: dict[str, float] = {
    "focal_length_mm": 1e-4,
    "principal_point_y_px": 1e-2,
    "principal_point_z_px": 1e-2,
    "k1_per_mm2": 1e-6,
    "k2_per_mm4": 1e-7,
    "horizontal_scale": 1e-5,
    "latency_s": 1e-4,
    "bend_xx_per_mm": 1e-6,
    "bend_yy_per_mm": 1e-6,
    "bend_xy_per_mm": 1e-6,
    "lens_y_px": 1e-2,
    "lens_z_px": 1e-2,
}
"""Steps of the central differences where the unit does not give them (1e-5 rad or ratio, 1e-3 mm)."""


def difference_step(name: str) -> float:
    """Half width of the central difference of one unknown."""
    return STEPS.get(name, 1e-3 if name.endswith("_mm") else 1e-5)


CAMERA = ("focal_length_mm", "principal_point_y_px", "principal_point_z_px", "k1_per_mm2", "k2_per_mm4")
HEAD = ("phi_rad", "sigma_rad", "t_x_mm", "t_y_mm", "t_z_mm")
RIGHT = ("right_azimuth_rad", "right_lean_rad", "right_offset_mm")
LEFT = ("left_azimuth_rad", "left_lean_rad", "left_offset_mm")
FLOOR = ("floor_slope_x", "floor_slope_y")
ENCODER = ("eccentricity_cos_rad", "eccentricity_sin_rad")
