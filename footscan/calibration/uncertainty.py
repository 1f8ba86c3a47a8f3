"""How well an estimate is known: standard deviations of its parameters, and the millimetres they cause."""

import numpy as np
from threadpoolctl import threadpool_limits

from footscan.calibration.estimate import difference_step, moved_machine
from footscan.calibration.residuals import TUKEY
from footscan.calibration.solve import Fit
from footscan.coordinates import LASER_NAMES, Bools, Floats, LaserName, pixel_from_uv
from footscan.geometry.rigid import inverse_rigid
from footscan.optics import Calibration
from footscan.optics.calibration import camera_from_world
from footscan.optics.camera import ray_from_pixel

VOLUME_RADIUS_MM = 170.0
VOLUME_Z_MM = (0.0, 120.0)
_GRID_PX = 12


def covariance(fit: Fit) -> Floats:
    """Covariance `(k, k)` of all unknowns: what they would be without each frame in turn (a jackknife, linearised).

    Errors of one frame hang together (its corners share light and blur, its stripe places one laser line), so frames
    are left out as a whole. What is known beforehand counts with its own variance.
    """
    with threadpool_limits(1):
        return _jackknife(fit)


def _jackknife(fit: Fit) -> Floats:
    bend = fit.weight * _stiffness(fit)
    matrix = (fit.jacobian * bend[:, None]).T @ fit.jacobian + np.diag(fit.firmness())
    unit = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    # a millionth of a millionth keeps what nothing shows finite
    whole = matrix * unit[:, None] * unit[None, :] + 1e-12 * np.eye(len(matrix))
    jacobian = fit.jacobian * unit
    key = fit.rows.frame * 4 + fit.rows.laser + 1
    order = np.argsort(key, kind="stable")
    starts = np.flatnonzero(np.diff(key[order], prepend=-1))
    steps: list[Floats] = []
    for rows in np.split(order, starts[1:]):
        own, weight = jacobian[rows], fit.weight[rows]
        used = np.flatnonzero(np.any(own != 0.0, axis=0))
        without = whole.copy()
        without[np.ix_(used, used)] -= (own[:, used] * bend[rows, None]).T @ own[:, used]
        score: Floats = (weight * fit.residual_px[rows]) @ own
        steps.append(np.asarray(np.linalg.solve(without, score), dtype=np.float64))
    moved = np.array(steps)
    inverse = np.linalg.inv(whole)
    known = fit.firmness() * unit**2
    result = moved.T @ moved + (inverse * known) @ inverse
    return np.asarray(result * unit[:, None] * unit[None, :])


def _stiffness(fit: Fit) -> Floats:
    """Mean slope of Tukey's influence function over its mean weight `(r,)`, per kind of residual (Huber 1981, 3.2).

    The weights of a robust fit promise more than they hold: a residual that grows also loses weight.
    """
    ratio2 = np.minimum((fit.residual_px / (TUKEY * fit.scale_px[fit.rows.group])) ** 2, 1.0)
    slope, weight = (1.0 - ratio2) * (1.0 - 5.0 * ratio2), (1.0 - ratio2) ** 2
    groups = np.arange(len(fit.scale_px))
    share = np.array([_ratio(slope[fit.rows.group == g], weight[fit.rows.group == g]) for g in groups])
    return share[fit.rows.group]


def _ratio(slope: Floats, weight: Floats) -> float:
    """Between a fifth (nearly all rejected) and one."""
    return float(np.clip(slope.sum() / max(float(weight.sum()), 1e-12), 0.2, 1.0)) if len(slope) else 1.0


def standard_deviations(fit: Fit) -> dict[str, float]:
    """Standard deviation of every unknown of the machine, in its own unit."""
    deviation = np.sqrt(np.maximum(np.diag(covariance(fit)), 0.0))
    return dict(zip(fit.unknowns.machine, (float(x) for x in deviation), strict=False))


def condition(fit: Fit) -> float:
    """Condition number of the problem with every unknown in its own natural unit."""
    matrix = fit.normal_matrix()
    unit = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values = np.linalg.eigvalsh(matrix * unit[:, None] * unit[None, :])
    return float(np.sqrt(values[-1] / max(float(values[0]), 1e-300)))


def volume_points(machine: Calibration, laser: LaserName, yz_pixel: Floats) -> Floats:
    """World places `(n, 3)` at theta = 0 of pixels `(n, 2)` through one laser's sheet."""
    world_from_camera = inverse_rigid(camera_from_world(machine))
    ray = ray_from_pixel(yz_pixel, machine.camera) @ world_from_camera[:3, :3].T
    lens = (world_from_camera @ np.array([machine.camera.focal_length_mm, 0.0, 0.0, 1.0]))[:3]
    sheet = machine.laser(laser)
    normal = np.array(sheet.normal)
    return lens + ((sheet.offset_mm - normal @ lens) / (ray @ normal))[:, None] * ray


def working_pixels(machine: Calibration, laser: LaserName) -> Floats:
    """A grid of pixels `(n, 2)` in F whose place on the sheet lies in the volume in which feet are measured."""
    camera = machine.camera
    step = max(_GRID_PX, camera.width_px // 48)
    column, row = np.meshgrid(np.arange(0, camera.width_px, step), np.arange(0, camera.height_px, step))
    uv = np.column_stack([column.ravel(), row.ravel()]).astype(np.float64)
    yz_pixel = pixel_from_uv(uv, camera.height_px)
    return yz_pixel[in_volume(volume_points(machine, laser, yz_pixel))]


def in_volume(xyz_world: Floats) -> Bools:
    """Whether `(n, 3)` places lie within 170 mm of the axis and 120 mm above the board."""
    near = np.hypot(xyz_world[:, 0], xyz_world[:, 1]) < VOLUME_RADIUS_MM
    return near & (xyz_world[:, 2] > VOLUME_Z_MM[0]) & (xyz_world[:, 2] < VOLUME_Z_MM[1])


def expected_error_mm(fit: Fit) -> dict[LaserName, Floats]:
    """Standard deviation `(n,)` in mm of the places that pixels of the working volume get, per laser."""
    spread = covariance(fit)[: len(fit.unknowns.machine), : len(fit.unknowns.machine)]
    return {name: _error_of_laser(fit, name, spread) for name in LASER_NAMES}


def _error_of_laser(fit: Fit, name: LaserName, spread: Floats) -> Floats:
    machine = fit.estimate.machine
    yz_pixel = working_pixels(machine, name)
    slopes = np.stack([_slope(machine, name, yz_pixel, unknown) for unknown in fit.unknowns.machine], axis=-1)
    variance = np.einsum("nik,kl,nil->n", slopes, spread, slopes)
    return np.sqrt(np.maximum(variance, 0.0))


def _slope(machine: Calibration, laser: LaserName, yz_pixel: Floats, unknown: str) -> Floats:
    h = difference_step(unknown)
    ahead, behind = (volume_points(moved_machine(machine, unknown, step), laser, yz_pixel) for step in (h, -h))
    return (ahead - behind) / (2.0 * h)


def error_shares_mm(fit: Fit) -> dict[str, float]:
    """RMS millimetres in the working volume that the doubt of each unknown causes by itself (both lasers)."""
    deviation = standard_deviations(fit)
    machine = fit.estimate.machine
    pixels = {name: working_pixels(machine, name) for name in LASER_NAMES}
    return {
        unknown: float(
            np.sqrt(
                np.mean(
                    [
                        np.sum((_slope(machine, name, pixels[name], unknown) * deviation[unknown]) ** 2, axis=1).mean()
                        for name in LASER_NAMES
                    ]
                )
            )
        )
        for unknown in fit.unknowns.machine
    }


def machine_difference_mm(one: Calibration, other: Calibration) -> dict[LaserName, Floats]:
    """Distance `(n,)` in mm between the places that two calibrations give to the same pixels, per laser."""
    result: dict[LaserName, Floats] = {}
    for name in LASER_NAMES:
        yz_pixel = working_pixels(other, name)
        off = volume_points(one, name, yz_pixel) - volume_points(other, name, yz_pixel)
        result[name] = np.linalg.norm(off, axis=1)
    return result
