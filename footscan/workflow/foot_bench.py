"""`footscan bench foot`: surface, measurements and sections beside geomdl's fit and trimesh's cut in the same run."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import trimesh
from threadpoolctl import threadpool_limits

from footscan.coordinates import Floats
from footscan.foot.measurements import measure
from footscan.foot.sections import measure_cut
from footscan.foot.shell import shell_from_mesh
from footscan.foot.surface import fit_foot_surface
from footscan.foot.surface_bench import compare_fits
from footscan.foot.surface_mesh import mesh_from_surface
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import trimesh_from_surface

_LOWEST_SEEN_MM, _LEG_MM = 6.0, 150.0


@dataclass(frozen=True)
class FootTiming:
    """Minimum and median in ms of one step, and of its baseline where there is one."""

    step: str
    ours_ms: tuple[float, float]
    target_ms: float | None
    baseline: str
    baseline_ms: tuple[float, float] | None


def sampled_foot(points: int, seed: int = 1) -> tuple[Floats, trimesh.Trimesh]:
    """`(points, 3)` noisy samples (0.05 mm) of the built-in foot's skin between 6 and 150 mm, and its mesh."""
    mesh = trimesh_from_surface(build_foot(FootShape("left", 1.0)))
    samples = trimesh.sample.sample_surface(mesh, 3 * points, seed=seed)[0]
    xyz = np.asarray(samples, dtype=np.float64)
    xyz = xyz[(xyz[:, 2] > _LOWEST_SEEN_MM) & (xyz[:, 2] < _LEG_MM)][:points]
    return xyz + np.random.default_rng(seed).normal(0.0, 0.05, xyz.shape), mesh


def time_foot(points: int, repeats: int) -> list[FootTiming]:
    """Time every step between a cloud and its numbers."""
    xyz, _ = sampled_foot(points)
    with threadpool_limits(1):
        return _time_steps(xyz, repeats)


def _time_steps(xyz: Floats, repeats: int) -> list[FootTiming]:
    weight, laser = np.full(len(xyz), 0.7), np.arange(len(xyz)) % 2
    surface = fit_foot_surface(xyz, weight, laser)
    mesh = mesh_from_surface(surface)
    fit = _timed(lambda: fit_foot_surface(xyz, weight, laser), repeats)
    close = _timed(lambda: mesh_from_surface(surface), repeats)
    numbers = _timed(lambda: measure(mesh, "left"), repeats)

    def chain() -> None:
        measure(mesh_from_surface(fit_foot_surface(xyz, weight, laser)), "left")

    whole = _timed(chain, repeats)
    fits = compare_fits(surface.tube)
    shell, origin, normal = shell_from_mesh(mesh), mesh.bounds.mean(axis=0), np.array([0.6, 0.0, 0.8])
    cut = _timed(lambda: measure_cut(shell, origin, normal), 5 * repeats)
    plain = _timed(lambda: mesh.section(plane_origin=origin, plane_normal=normal), 5 * repeats)
    return [
        FootTiming(f"surface of {len(xyz)} points", fit, None, "", None),
        FootTiming(
            f"fit of a grid, {fits.controls} controls", _once(fits.ours_s), None, "geomdl", _once(fits.geomdl_s)
        ),
        FootTiming(f"closed mesh, {len(mesh.faces)} facets", close, None, "", None),
        FootTiming("all measurements", numbers, None, "", None),
        FootTiming("surface, mesh and measurements", whole, 1500.0, "", None),
        FootTiming("section at any plane, measured", cut, 10.0, "trimesh, curves only", plain),
    ]


def _timed(work: Callable[[], object], repeats: int) -> tuple[float, float]:
    work()
    ms: list[float] = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        ms.append(1e3 * (time.perf_counter() - begin))
    return min(ms), float(np.median(ms))


def _once(seconds: float) -> tuple[float, float]:
    return 1e3 * seconds, 1e3 * seconds
