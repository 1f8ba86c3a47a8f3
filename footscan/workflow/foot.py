"""From a cleaned cloud to a measured foot: surface, mesh with the origin of its skin, measurements."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from threadpoolctl import threadpool_limits

from footscan.config.recording_file import Subject
from footscan.config.toml_file import write_whole
from footscan.coordinates import Side
from footscan.foot.measurements import Measurements, measure, measurements_json
from footscan.foot.skin_origin import Origin
from footscan.foot.surface import FootSurface, fit_foot_surface
from footscan.foot.surface_files import save_surface_json, save_surface_ply, save_surface_stl
from footscan.foot.surface_mesh import mesh_from_surface
from footscan.scanning.cloud import Cloud
from footscan.workflow.report import save_report


@dataclass(frozen=True)
class MeasuredFoot:
    """A scanned foot: fitted surface, closed mesh (mm, world, vertex attribute `origin`), measurements."""

    surface: FootSurface
    mesh: trimesh.Trimesh
    measurements: Measurements


def measure_scan(cloud: Cloud, side: Side | None, subject: Subject) -> MeasuredFoot:
    """Fit, close and measure the foot of a cloud.

    Args:
        cloud: Cleaned and merged, world coordinates.
        side: The operator's word; None when nobody said.
        subject: Load and missing parts, as far as somebody said so.

    Raises:
        MeshError: No foot, two, or one that is partly outside the view.
        EmptyScanError: Too few points.
    """
    with threadpool_limits(1):  # two BLAS threads that wait for each other are slower than one
        surface = fit_foot_surface(cloud.xyz_world, cloud.weight.astype(np.float64), cloud.laser)
    mesh = mesh_from_surface(surface)
    return MeasuredFoot(surface, mesh, measure(mesh, side, load=subject.load, absent=subject.absent))


def area_by_origin(mesh: trimesh.Trimesh) -> dict[str, float]:
    """Share of the skin's area per class; a facet belongs to the worst class of its corners."""
    origin = np.asarray(mesh.vertex_attributes["origin"])[mesh.faces].max(axis=1)
    area = np.asarray(mesh.area_faces)
    skin = float(area[origin != Origin.CUT].sum())
    kinds = (Origin.SEEN, Origin.BRIDGED, Origin.ASSUMED_SOLE)
    return {kind.name.lower(): round(float(area[origin == kind].sum()) / skin, 4) for kind in kinds}


def foot_report(foot: MeasuredFoot) -> dict[str, Any]:
    """What scan.json says of the surface."""
    surface = foot.surface
    return {
        "cut_height_mm": round(surface.cut.z_mm, 3),
        "cut_seen_share": round(surface.cut.seen_share, 4),
        "cut_reason": surface.cut.reason,
        "closure": surface.closure.name,
        "rms_mm": round(surface.rms_mm, 4),
        "points_fitted": int((surface.weight > 0.0).sum()),
        "strays": surface.strays,
        "skin": area_by_origin(foot.mesh),
        "vertices": len(foot.mesh.vertices),
        "volume_cm3": round(float(foot.mesh.volume) / 1000.0, 3),
        "remarks": list(foot.measurements.remarks),
        "questions": list(foot.measurements.questions),
    }


def save_foot(foot: MeasuredFoot, folder: Path, title: str) -> None:
    """Write surface.stl, surface.ply, surface.json, measurements.json and report.png, each whole or not at all."""
    save_surface_stl(foot.mesh, folder / "surface.stl")
    save_surface_ply(foot.mesh, folder / "surface.ply", "footscan, mm, world coordinates")
    save_surface_json(foot.surface.tube, folder / "surface.json")
    write_whole(
        folder / "measurements.json", (json.dumps(measurements_json(foot.measurements), indent=1) + "\n").encode()
    )
    save_report(foot.mesh, foot.measurements, folder / "report.png", title)
