"""From a cleaned cloud to a measured foot: surface, mesh with the origin of its skin, measurements."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from threadpoolctl import threadpool_limits

from footscan.config.recording_file import Subject
from footscan.config.toml_file import write_whole
from footscan.coordinates import Floats, Side
from footscan.errors import InputError
from footscan.foot.measurements import Measurements, measure, measurements_json
from footscan.foot.section_files import cut_stack, sections_dxf, stack_csv
from footscan.foot.shell import shell_from_mesh
from footscan.foot.skin_origin import Origin
from footscan.foot.smoothing import FilterSettings, filter_cloud, smoothed
from footscan.foot.standing import absent_parts, front_of
from footscan.foot.surface import FootSurface, fit_foot_surface
from footscan.foot.surface_files import save_surface_json, save_surface_ply, save_surface_stl
from footscan.foot.surface_mesh import mesh_from_surface, mirrored_mesh
from footscan.foot.wedge import Wedge, set_flat
from footscan.foot.wedge_fit import settled_under
from footscan.scanning.cloud import Cloud
from footscan.workflow.report import save_report

MAIN_MEASUREMENTS = ("foot_length", "foot_breadth", "ball_girth", "instep_girth", "heel_breadth", "instep_height")
Landmarks = Mapping[str, tuple[float, float, float]]
STACK_SHARES = tuple(k / 20.0 for k in range(1, 20))


@dataclass(frozen=True)
class FootSettings:
    """Numerical filtering of the points (0 off, 1 full) and geometrical smoothing of the surface (mm).

    Both work on copies: points.ply and the recording stay as they are; without the two the same foot comes again.
    """

    filter_strength: float = 0.0
    smooth_mm: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.filter_strength <= 1.0:
            raise InputError(f"a cloud filter of {self.filter_strength} was asked for, allowed are 0 (off) to 1.")
        if not 0.0 <= self.smooth_mm <= 50.0:
            raise InputError(f"smoothing over {self.smooth_mm} mm was asked for, allowed are 0 (off) to 50 mm.")


@dataclass(frozen=True)
class MeasuredFoot:
    """A scanned foot: fitted surface, closed mesh (mm, world, vertex attribute `origin`), measurements.

    `price` states volume and main measurements before and after filtering and smoothing; empty when both are off.
    """

    surface: FootSurface
    mesh: trimesh.Trimesh
    measurements: Measurements
    price: dict[str, dict[str, float]]


def measure_scan(
    cloud: Cloud,
    side: Side | None,
    subject: Subject,
    settings: FootSettings | None = None,
    landmarks: Landmarks | None = None,
    xy_board: Floats | None = None,
    wedge: Wedge | None = None,
) -> MeasuredFoot:
    """Fit, close and measure the foot of a cloud.

    Args:
        cloud: Cleaned and merged, world coordinates; left as it is.
        side: The operator's word; None when nobody said.
        subject: Load and missing parts, as far as somebody said so.
        settings: Filtering and smoothing; None for neither.
        landmarks: Placed by hand, name -> (x, y, z) in world coordinates.
        xy_board: `(n, 2)` places where the bare board was seen; they bound the assumed edge of the sole. Under a
            foot on a wedge, with the rearfoot turned back.
        wedge: On which the foot stood: it is fitted and closed with its rearfoot turned back, so that the assumed sole
            lies on the wedge; None for the flat board.

    Raises:
        MeshError: No foot, two, or one that is partly outside the view.
        EmptyScanError: Too few points.
    """
    settings = settings or FootSettings()
    known = landmarks or {}, xy_board, wedge
    plain = _fit_and_measure(cloud, side, subject, FootSettings(), *known)
    if settings == FootSettings():
        return plain
    changed = _fit_and_measure(cloud, side, subject, settings, *known)
    price = {"before": main_values(plain), "after": main_values(changed)}
    return replace(changed, price=price)


def _fit_and_measure(
    cloud: Cloud,
    side: Side | None,
    subject: Subject,
    settings: FootSettings,
    landmarks: Landmarks,
    xy_board: Floats | None,
    wedge: Wedge | None,
) -> MeasuredFoot:
    """A wedge of which only the foot tells is placed anew under the fitted skin, and the skin fitted again on it."""
    by_hand = {name: np.array(xyz) for name, xyz in landmarks.items()}
    surface, mesh = _fitted(cloud, side, settings, xy_board, wedge)
    if wedge is not None:
        place = side, front_of(absent_parts(subject.absent)), by_hand
        settled = settled_under(shell_from_mesh(mesh), wedge, *place)
        if not wedge.seen:
            surface, mesh = _fitted(cloud, side, settings, xy_board, settled)
        wedge = settled
    values = measure(mesh, side, load=subject.load, absent=subject.absent, landmarks=by_hand, wedge=wedge)
    return MeasuredFoot(surface, mesh, values, {})


def _fitted(
    cloud: Cloud, side: Side | None, settings: FootSettings, xy_board: Floats | None, wedge: Wedge | None
) -> tuple[FootSurface, trimesh.Trimesh]:
    """Surface and closed mesh, as the foot stood.

    Left feet are fitted as their mirror images, so that a foot and its mirror image give the same numbers.
    """
    xyz, weight, laser = set_flat(cloud.xyz_world, wedge), cloud.weight.astype(np.float64), cloud.laser
    if settings.filter_strength > 0.0:
        calm = filter_cloud(xyz, FilterSettings(strength=settings.filter_strength))
        xyz, weight, laser = calm.xyz_world, weight[calm.kept], laser[calm.kept]
    with threadpool_limits(1):  # two BLAS threads that wait for each other are slower than one
        surface = fit_foot_surface(xyz, weight, laser, xy_board=xy_board, mirrored=side == "left")
        if settings.smooth_mm > 0.0:
            surface = smoothed(surface, settings.smooth_mm)
    mesh = mirrored_mesh(mesh_from_surface(surface.mirrored())) if side == "left" else mesh_from_surface(surface)
    if wedge is not None:
        mesh.vertices, surface = wedge.bent(np.asarray(mesh.vertices)), surface.moved(wedge.bent)
    return surface, mesh


def main_values(foot: MeasuredFoot) -> dict[str, float]:
    """Volume of the mesh and the main measurements, by name."""
    values = {"mesh_volume_cm3": round(float(foot.mesh.volume) / 1000.0, 3), "rms_mm": round(foot.surface.rms_mm, 4)}
    for name in MAIN_MEASUREMENTS:
        value = foot.measurements[name].value
        if value is not None:
            values[name] = round(value, 3)
    return values


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
        "filtering_and_smoothing": foot.price,
    }


def save_foot(foot: MeasuredFoot, folder: Path, title: str, notes: Sequence[str] = ()) -> None:
    """Write surface.*, measurements.json, sections.* and report.png, each whole or not at all; notes go on the page."""
    save_surface_stl(foot.mesh, folder / "surface.stl")
    save_surface_ply(foot.mesh, folder / "surface.ply", "footscan, mm, world coordinates")
    save_surface_json(foot.surface.tube, folder / "surface.json")
    write_whole(
        folder / "measurements.json", (json.dumps(measurements_json(foot.measurements), indent=1) + "\n").encode()
    )
    stack = cut_stack(shell_from_mesh(foot.mesh), foot.measurements, STACK_SHARES)
    write_whole(folder / "sections.csv", stack_csv(stack).encode())
    write_whole(folder / "sections.dxf", sections_dxf(stack).encode())
    save_report(foot.mesh, foot.measurements, folder / "report.png", title, notes)
