"""A last scanned on the machine: a closed surface of what was seen, and in words what the machine cannot see of it."""

from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from threadpoolctl import threadpool_limits

from footscan.foot.surface import FootSurface, fit_foot_surface
from footscan.foot.surface_files import save_surface_json, save_surface_ply, save_surface_stl
from footscan.foot.surface_mesh import mesh_from_surface
from footscan.scanning.cloud import Cloud
from footscan.workflow.foot import area_by_origin

LAST_REMARKS = (
    "a last on the board: its bottom is not seen and is assumed flat on the board, so pitch, toe spring, bottom and "
    "feather edge are no measurements of the last",
    "skin below about 6 mm is seldom seen: the edge of the assumed bottom stands in for the feather edge",
    "the cone top is not seen from the side: the last is closed flat at the height stated as cut",
)


def scanned_last(cloud: Cloud) -> tuple[FootSurface, trimesh.Trimesh]:
    """Fit and close the skin of a last; no measurement of a foot is taken.

    Raises:
        MeshError: Nothing that stands on the board by itself.
        EmptyScanError: Too few points.
    """
    with threadpool_limits(1):
        surface = fit_foot_surface(cloud.xyz_world, cloud.weight.astype(np.float64), cloud.laser)
    return surface, mesh_from_surface(surface)


def save_last(surface: FootSurface, mesh: trimesh.Trimesh, folder: Path) -> None:
    """Write surface.stl, surface.ply (with the origin of the skin) and surface.json."""
    save_surface_stl(mesh, folder / "surface.stl")
    save_surface_ply(mesh, folder / "surface.ply", "footscan, mm, world coordinates, a last")
    save_surface_json(surface.tube, folder / "surface.json")


def last_report(surface: FootSurface, mesh: trimesh.Trimesh) -> dict[str, Any]:
    """What scan.json says of the last."""
    return {
        "cut_height_mm": round(surface.cut.z_mm, 3),
        "rms_mm": round(surface.rms_mm, 4),
        "skin": area_by_origin(mesh),
        "volume_cm3": round(float(mesh.volume) / 1000.0, 3),
        "not_seen": list(LAST_REMARKS),
    }
