"""Numerical filtering of a cloud and geometrical smoothing of a surface, both on copies, both with their price stated.

Filtering moves points along the normal of their neighbourhood towards its plane and drops those that stand off.
Smoothing damps the control net. Each result holds the original, so nothing is ever lost.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
import trimesh
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import splu
from scipy.spatial import KDTree

from footscan.coordinates import Bools, Floats
from footscan.foot.nurbs import SplineTube
from footscan.foot.surface import FootSurface, flat_ends
from footscan.foot.surface_mesh import FACET_MM, mesh_from_surface

_LEAST_SPAN = 0.1
"""Control points may lie closer than this share of the usual distance; then they count as that far apart."""

Measure = Callable[[trimesh.Trimesh], Mapping[str, float]]
"""Named values of a mesh, e.g. the main measurements."""


@dataclass(frozen=True)
class FilterSettings:
    """Numerical filtering of a cloud.

    Attributes:
        neighbours: Points that make a neighbourhood.
        strength: 0 leaves points where they are, 1 moves them on to the plane of their neighbourhood.
        drop_mm: Points further than this from their neighbourhood's plane are dropped; None keeps all.
    """

    neighbours: int = 12
    strength: float = 0.5
    drop_mm: float | None = 1.0


@dataclass(frozen=True)
class FilteredCloud:
    """A filtered copy and where it came from.

    Attributes:
        xyz_world: `(m, 3)` filtered points.
        kept: `(n,)` which of the original points they are.
        original_mm: `(n, 3)` the points as measured.
    """

    xyz_world: Floats
    kept: Bools
    original_mm: Floats = field(repr=False)

    @property
    def largest_move_mm(self) -> float:
        """Longest way a point was moved."""
        return float(np.linalg.norm(self.xyz_world - self.original_mm[self.kept], axis=1).max(initial=0.0))


@dataclass(frozen=True)
class SmoothedSurface:
    """A smoothed copy, the original, and what smoothing did to volume and measurements.

    Attributes:
        surface: The smoothed foot.
        original: The foot as fitted.
        before: Named values of the original's mesh (volume in cm3, extents in mm, and what `measure` adds).
        after: The same of the smoothed mesh.
    """

    surface: FootSurface
    original: FootSurface
    before: Mapping[str, float]
    after: Mapping[str, float]

    @property
    def change(self) -> Mapping[str, float]:
        """After minus before, by name."""
        return {name: self.after[name] - value for name, value in self.before.items() if name in self.after}


def filter_cloud(xyz_world: Floats, settings: FilterSettings) -> FilteredCloud:
    """Filter a cloud.

    Args:
        xyz_world: `(n, 3)` mm; left as it is.
        settings: How strongly.

    Returns:
        The filtered copy with the original.

    Raises:
        ValueError: A setting out of range.
    """
    if not 0.0 <= settings.strength <= 1.0 or settings.neighbours < 4:
        raise ValueError(
            f"filtering needs a strength of 0 to 1 and 4 neighbours or more, found {settings.strength} and "
            f"{settings.neighbours}"
        )
    offset, normal = plane_offsets(xyz_world, min(settings.neighbours, len(xyz_world)))
    kept = np.ones(len(xyz_world), bool) if settings.drop_mm is None else np.abs(offset) <= settings.drop_mm
    moved = xyz_world - settings.strength * offset[:, None] * normal
    return FilteredCloud(moved[kept], kept, xyz_world)


def plane_offsets(xyz_mm: Floats, neighbours: int) -> tuple[Floats, Floats]:
    """Signed distance `(n,)` of each point from the plane of its neighbours, itself left out, and normals `(n, 3)`."""
    near = np.asarray(KDTree(xyz_mm).query(xyz_mm, k=neighbours + 1, workers=-1)[1])
    around = xyz_mm[near[:, 1:]]
    middle = around.mean(axis=1)
    spread = around - middle[:, None]
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", spread, spread))
    normal = np.ascontiguousarray(axes[:, :, 0])
    return ((xyz_mm - middle) * normal).sum(axis=1), normal


def smooth_surface(
    surface: FootSurface, length_mm: float, measure: Measure | None = None, facet_mm: float = FACET_MM
) -> SmoothedSurface:
    """Smooth a foot: features shorter than a length are damped, larger ones stay.

    Args:
        surface: The fitted foot; left as it is.
        length_mm: Features of this size lose half their height; 0 changes nothing.
        measure: Adds named values to the volume and extents stated before and after.
        facet_mm: Facets of the meshes that are measured.

    Raises:
        ValueError: A negative length.
    """
    if length_mm < 0.0:
        raise ValueError(f"a smoothing length cannot be negative, found {length_mm} mm; 0 switches smoothing off")
    smooth = smoothed(surface, length_mm)
    before, after = (_values(foot, measure, facet_mm) for foot in (surface, smooth))
    return SmoothedSurface(smooth, surface, before, after)


def smoothed(surface: FootSurface, length_mm: float) -> FootSurface:
    """The smoothed copy alone, its sole and cut kept flat."""
    return surface.with_tube(flat_ends(smooth_tube(surface.tube, length_mm), surface.cut.z_mm))


def smooth_tube(tube: SplineTube, length_mm: float) -> SplineTube:
    """Damp the control net by an implicit step of the bi-Laplacian over the skin; its first and last row stay.

    Differences are taken over the net's own distances in mm, so that the length means the same at a toe, where columns
    spread, and at the heel; counted in rows and columns, a toe would be shortened like a bump.
    """
    if length_mm == 0.0:
        return tube
    rows, columns = tube.net_mm.shape[:2]
    around, up = (_second_derivatives(tube.net_mm, axis) for axis in (1, 0))
    area = diags_array(_spans(tube.net_mm, 1).mean(axis=0).ravel() * _spans(tube.net_mm, 0).mean(axis=0).ravel())
    stiff = around.T @ area @ around + up.T @ area @ up
    system = (area + (length_mm / (2.0 * np.pi)) ** 4 * stiff).tocsr()
    free = np.repeat(np.arange(rows) % (rows - 1) > 0, columns)
    flat = tube.net_mm.reshape(-1, 3)
    right = area @ flat - system @ np.where(free[:, None], 0.0, flat)
    result = flat.copy()
    result[free] = splu(system[free][:, free].tocsc()).solve(right[free])
    return SplineTube(result.reshape(rows, columns, 3), tube.knots_v)


def _second_derivatives(net_mm: Floats, axis: int) -> csr_array:
    """Second derivatives (per mm2) of the net along its columns (0) or rows (1); none at the ends of columns."""
    before, after = _spans(net_mm, axis)
    low, high = 2.0 / (before * (before + after)), 2.0 / (after * (before + after))
    if axis == 0:
        low[[0, -1]], high[[0, -1]] = 0.0, 0.0
    number = np.arange(before.size).reshape(before.shape)
    beside = [number, np.roll(number, 1, axis), np.roll(number, -1, axis)]
    values = np.concatenate([part.ravel() for part in (-low - high, low, high)])
    place = (np.tile(number.ravel(), 3), np.concatenate([part.ravel() for part in beside]))
    return csr_array((values, place), shape=(before.size, before.size))


def _spans(net_mm: Floats, axis: int) -> Floats:
    """Distances `(2, n_v, n_u)` to the control point before and after along an axis, not below a share of the usual."""
    after = np.linalg.norm(np.roll(net_mm, -1, axis) - net_mm, axis=2)
    if axis == 0:
        after[-1] = after[-2]
    after = np.maximum(after, _LEAST_SPAN * np.median(after))
    before = np.roll(after, 1, axis)
    if axis == 0:
        before[0] = after[0]
    return np.stack([before, after])


def _values(foot: FootSurface, measure: Measure | None, facet_mm: float) -> dict[str, float]:
    mesh = mesh_from_surface(foot, facet_mm)
    values = {"volume_cm3": float(mesh.volume) / 1000.0, "area_cm2": float(mesh.area) / 100.0}
    values |= {f"extent_{name}_mm": float(size) for name, size in zip("xyz", mesh.extents, strict=True)}
    values["rms_to_points_mm"] = foot.rms_mm
    return values | dict(measure(mesh) if measure else {})
