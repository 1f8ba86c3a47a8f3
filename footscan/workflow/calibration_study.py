"""The two studies of the paper's Part II: RMS 3-D error against the number of control points, and against image noise.

Synthetic, on points: true workshop machines, exact projections, Gaussian noise. The paper's monoview coplanar
calibration beside the joint estimate from several boards and stripes.
"""

from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from footscan.calibration.estimate import start_estimate
from footscan.calibration.monoview import fit_monoview, plane_places_mm
from footscan.calibration.solve import fit_estimate
from footscan.calibration.synthetic import SyntheticPlan, make_sightings
from footscan.calibration.uncertainty import machine_difference_mm, working_pixels
from footscan.calibration.unknowns import EVERYTHING
from footscan.config import Board
from footscan.coordinates import Floats
from footscan.optics import Calibration
from footscan.optics.calibration import camera_from_world
from footscan.optics.camera import pixel_from_camera
from footscan.optics.scanner import Scanner, calibration_from_design
from footscan.optics.sheet import world_from_light
from footscan.scanning.sweep import Progress
from footscan.sim.machine import workshop_machine

NOISE_PX = (0.0, 0.05, 0.1, 0.2, 0.5)
GRIDS = ((3, 3), (4, 3), (5, 4), (7, 5), (10, 7), (16, 11))
BOARDS = ((4, 3), (5, 4), (7, 5), (11, 8))
_USUAL_NOISE_PX = 0.1
_USUAL_GRID = (10, 7)
_MONOVIEW_TRIALS = 24
_JOINT_TRIALS = 3
_FIELD_MM = np.array([220.0, 120.0])


@dataclass(frozen=True)
class StudyPoint:
    """One figure: control points per view, noise, RMS 3-D error over all trials, and how many trials."""

    method: str
    control_points: int
    noise_px: float
    rms_mm: float
    trials: int


def run_study(scanner: Scanner, progress: Progress = lambda done, total: None) -> list[StudyPoint]:
    """Both studies with both methods."""
    work = [("monoview", grid, _USUAL_NOISE_PX) for grid in GRIDS]
    work += [("monoview", _USUAL_GRID, noise) for noise in NOISE_PX]
    work += [("monoview, exact lens", grid, _USUAL_NOISE_PX) for grid in GRIDS]
    work += [("monoview, exact lens", _USUAL_GRID, noise) for noise in NOISE_PX]
    work += [("joint", board, _USUAL_NOISE_PX) for board in BOARDS]
    work += [("joint", (7, 5), noise) for noise in NOISE_PX]
    points: list[StudyPoint] = []
    for done, (method, grid, noise_px) in enumerate(work, start=1):
        points.append(_point(scanner, method, grid, noise_px))
        progress(done, len(work))
    return points


def _point(scanner: Scanner, method: str, grid: tuple[int, int], noise_px: float) -> StudyPoint:
    trials = _JOINT_TRIALS if method == "joint" else _MONOVIEW_TRIALS
    squares = [_trial(scanner, method, grid, noise_px, seed) for seed in range(trials)]
    count = (grid[0] - 1) * (grid[1] - 1) if method == "joint" else grid[0] * grid[1]
    return StudyPoint(method, count, noise_px, float(np.sqrt(np.mean(squares))), trials)


def _trial(scanner: Scanner, method: str, grid: tuple[int, int], noise_px: float, seed: int) -> float:
    """Mean square 3-D error (mm2) in the working volume."""
    machine = workshop_machine(scanner, seed).calibration
    if method == "joint":
        return _joint_trial(machine, grid, noise_px, seed)
    design = calibration_from_design(scanner)
    if method == "monoview, exact lens":
        known = replace(machine.camera, focal_length_mm=design.camera.focal_length_mm, k1_per_mm2=0.0)
        design = replace(design, camera=known)
    return _monoview_trial(machine, design, grid, noise_px, seed)


def _joint_trial(machine: Calibration, grid: tuple[int, int], noise_px: float, seed: int) -> float:
    board = Board(*grid, 210.0 / grid[0], 0.7 * 210.0 / grid[0], "DICT_4X4_250")
    plan = SyntheticPlan(corner_noise_px=noise_px, stripe_noise_px=noise_px, seed=seed, stripe_step_mm=2.0)
    made = make_sightings(replace(machine, encoder=replace(machine.encoder, eccentricity_rad=0.0)), board, plan)
    fit = fit_estimate(made.truth, made.sightings, EVERYTHING)
    off = machine_difference_mm(fit.estimate.machine, made.truth.machine)
    return float(np.mean(np.concatenate([off["right"], off["left"]]) ** 2))


def _monoview_trial(
    machine: Calibration, design: Calibration, grid: tuple[int, int], noise_px: float, seed: int
) -> float:
    """Control points in the right laser's sheet, seen once; the error over all pixels of the working volume."""
    world_from_plane = world_from_light(machine.lasers[0])
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, grid[0]), np.linspace(0.0, 1.0, grid[1]))
    xy_plane = np.column_stack([x.ravel() * _FIELD_MM[0], y.ravel() * _FIELD_MM[1]])
    yz_pixel = _seen(machine, xy_plane, world_from_plane)
    noise = noise_px * np.random.default_rng([seed, 0x57]).standard_normal(yz_pixel.shape)
    found = fit_monoview(design, xy_plane, yz_pixel + noise)
    pixels = working_pixels(machine, "right")
    still = replace(machine, encoder=replace(machine.encoder, eccentricity_rad=0.0))
    true_mm = plane_places_mm(start_estimate(still, world_from_plane[None]), pixels)
    return float(np.mean(np.sum((found.places_mm(pixels) - true_mm) ** 2, axis=1)))


def _seen(machine: Calibration, xy_plane: Floats, world_from_plane: Floats) -> Floats:
    camera_from_plane = camera_from_world(machine) @ world_from_plane
    xyz_plane = np.column_stack([xy_plane, np.zeros(len(xy_plane))])
    xyz_camera = xyz_plane @ camera_from_plane[:3, :3].T + camera_from_plane[:3, 3]
    return pixel_from_camera(xyz_camera, machine.camera)


def study_table(points: list[StudyPoint]) -> list[dict[str, object]]:
    """Plain values for JSON."""
    return [asdict(point) for point in points]


def save_plot(points: list[StudyPoint], path: Path) -> None:
    """Both studies as one picture."""
    figure = Figure(figsize=(11.0, 4.2), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    for method, colour in (("monoview", "tab:red"), ("monoview, exact lens", "tab:orange"), ("joint", "tab:blue")):
        own = [point for point in points if point.method == method]
        many = sorted({(p.control_points, p.rms_mm) for p in own if p.noise_px == _USUAL_NOISE_PX})
        usual = 24 if method == "joint" else _USUAL_GRID[0] * _USUAL_GRID[1]
        noisy = sorted({(p.noise_px, p.rms_mm) for p in own if p.control_points == usual})
        left.plot(*zip(*many, strict=True), "o-", color=colour, label=method)
        right.plot(*zip(*noisy, strict=True), "o-", color=colour, label=method)
    left.set(xlabel="control points in a view", ylabel="RMS 3-D error (mm)", xscale="log", yscale="log")
    left.set_title(f"Image noise {_USUAL_NOISE_PX} px", fontsize=10)
    right.set(xlabel="image noise (px)", ylabel="RMS 3-D error (mm)", yscale="symlog")
    right.set_yscale("symlog", linthresh=0.01)
    right.set_title("70 control points (monoview), 24 a view (joint)", fontsize=10)
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, format="png")
