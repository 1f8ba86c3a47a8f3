"""The NURBS foot: a spline surface fitted to a cleaned cloud, which knows what of it was seen."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from footscan.coordinates import Floats, Ints
from footscan.errors import MeshError
from footscan.foot.closure import ClosureRule
from footscan.foot.nurbs import SplineTube, clamped_knots, graded_breaks, mirrored_tube
from footscan.foot.nurbs_fit import distance_mm, fit_tube, nearer_parameters
from footscan.foot.surface_bottom import AssumedSkin, assume_bottom
from footscan.foot.surface_chart import FootChart, build_chart
from footscan.foot.surface_checks import check_arrays, check_border, check_shape, main_object
from footscan.foot.surface_cut import LegCut, find_leg_cut

_FIRST = (90, 36)
_FIRST_TOLERANCE_MM = 1.0
_TUKEY = 4.685
_TOE_SHARE, _TOE_DENSITY = 0.3, 1.6  # the lower part of the skin, where the toes are, gets denser rows
_FEWEST_PER_CONTROL = 2.0


@dataclass(frozen=True)
class SurfaceSettings:
    """What may be chosen about the surface.

    Attributes:
        count_u: Control points around.
        spans_v: Knot spans from the board to the cut.
        stiffness: Bending energy against the mean weight of points per control point.
        tolerance_mm: Deviation that counts as ordinary; points beyond 4.7 times it do not count.
        passes: Fits, each with corrected parameters and weights.
        needed_share: Share of directions around the leg whose skin must reach the cut.
        closure_share: Longest run of the rounding along the board over the foot's length.
        soft_mm: The skin reaches the board this far inside the last bare board ...
        soft_share: ... and this share of the foot's length further in.
        closure_weight: Weight of the assumed skin over the mean weight of points; small, so that it pulls no seen
            skin.
    """

    count_u: int = 180
    spans_v: int = 70
    stiffness: float = 0.001
    tolerance_mm: float = 0.25
    passes: int = 2
    needed_share: float = 0.9
    closure_share: float = 0.06
    soft_mm: float = 4.0
    soft_share: float = 0.02
    closure_weight: float = 0.003


@dataclass(frozen=True)
class FootSurface:
    """A fitted foot.

    Attributes:
        tube: The skin from the board (v = 0, flat at z = 0) to the cut (v = 1, flat).
        cut: Where and why the leg was cut.
        closure: The rule that shaped the assumed skin.
        length_mm: Longest extent of the cloud seen from above.
        xyz_world: `(n, 3)` the points fitted (below the cut, strays left out).
        weight: `(n,)` their weight in the last fit.
        laser: `(n,)` 0 right, 1 left.
        u: `(n,)` parameters of their feet on the surface.
        v: Same.
        residual_mm: `(n,)` signed distance from the surface, positive outside.
        lowest_u: `(A,)` columns at which the lowest seen skin is known.
        lowest_v: `(A,)` v of it.
        strays: Points left out because they stand apart from the foot.
    """

    tube: SplineTube
    cut: LegCut
    closure: ClosureRule
    length_mm: float
    xyz_world: Floats = field(repr=False)
    weight: Floats = field(repr=False)
    laser: Ints = field(repr=False)
    u: Floats = field(repr=False)
    v: Floats = field(repr=False)
    residual_mm: Floats = field(repr=False)
    lowest_u: Floats = field(repr=False)
    lowest_v: Floats = field(repr=False)
    strays: int = 0

    @property
    def rms_mm(self) -> float:
        """Weighted RMS of the points' distances from the surface."""
        return float(np.sqrt((self.weight * self.residual_mm**2).sum() / max(float(self.weight.sum()), 1e-12)))

    def mirrored(self) -> "FootSurface":
        """Everything mirrored in the plane y = 0."""
        return replace(
            self,
            tube=mirrored_tube(self.tube),
            xyz_world=self.xyz_world * np.array([1.0, -1.0, 1.0]),
            u=np.mod(-self.u, 1.0),
            lowest_u=np.mod(-self.lowest_u, 1.0),
        )

    def moved(self, move: Callable[[Floats], Floats]) -> "FootSurface":
        """Control points and points `(n, 3)` carried by a gentle bend; residuals stay those of the fit."""
        net = move(self.tube.net_mm.reshape(-1, 3)).reshape(self.tube.net_mm.shape)
        return replace(self, tube=replace(self.tube, net_mm=net), xyz_world=move(self.xyz_world))

    def with_tube(self, tube: SplineTube) -> "FootSurface":
        """The same points with another surface; residuals follow."""
        return replace(self, tube=tube, residual_mm=distance_mm(tube, self.u, self.v, self.xyz_world))


@dataclass(frozen=True)
class _Cloud:
    xyz: Floats
    weight: Floats
    u: Floats
    v: Floats


def fit_foot_surface(
    xyz_world: Floats,
    weight: Floats,
    laser: Ints,
    settings: SurfaceSettings | None = None,
    xy_board: Floats | None = None,
    *,
    mirrored: bool = False,
) -> FootSurface:
    """Fit a closed NURBS foot to a cleaned cloud.

    Args:
        xyz_world: `(n, 3)` mm, z = 0 the board, any heading.
        weight: `(n,)` 0..1.
        laser: `(n,)` 0 right, 1 left.
        settings: What may be chosen; None for the defaults.
        xy_board: `(m, 2)` places where the bare board was seen; None when nobody looked.
        mirrored: Fit the mirror image and mirror the result: two feet that are mirror images get surfaces that are.

    Returns:
        The surface with its points, residuals and the border of what was seen.

    Raises:
        EmptyScanError: Too few points.
        MeshError: No foot, two objects, or a foot partly outside the view.
    """
    settings = settings or SurfaceSettings()
    check_arrays(xyz_world, weight, laser)
    check_border(xyz_world)
    kept = main_object(xyz_world)
    length = check_shape(xyz_world[kept])
    hand = np.array([1.0, -1.0 if mirrored else 1.0, 1.0])
    cut = find_leg_cut(xyz_world[kept] * hand, settings.needed_share)
    kept &= xyz_world[:, 2] < cut.z_mm
    board = np.empty((0, 2)) if xy_board is None else xy_board
    xyz, weight = np.ascontiguousarray(xyz_world[kept], dtype=np.float64), weight[kept].astype(np.float64)
    strays = int(len(xyz_world) - kept.sum() - (xyz_world[:, 2] >= cut.z_mm).sum())
    surface = _fit_one(xyz * hand, weight, laser[kept], board * hand[:2], cut, length, settings)
    return replace(surface.mirrored() if mirrored else surface, strays=strays)


def _fit_one(
    points: Floats,
    weights: Floats,
    laser: Ints,
    xy_board: Floats,
    cut: LegCut,
    length: float,
    settings: SurfaceSettings,
) -> FootSurface:
    """Fit checked points of one foot below its cut."""
    chart = build_chart(points, weights, cut.z_mm)
    soft = settings.soft_mm + settings.soft_share * length
    rule = ClosureRule("curvature-rounded", settings.closure_share * length, soft)
    cloud = _Cloud(points, weights, *chart.parameters(points))
    cloud, bottom = _first_fit(cloud, chart, rule, settings, xy_board)
    rule = replace(rule, name="bare-board" if bottom.board_known else "curvature-rounded")
    tube, cloud = _fine_fit(cloud, bottom, cut.z_mm, weights, settings)
    residual = distance_mm(tube, cloud.u, cloud.v, points)
    lowest = bottom.lowest_u, bottom.lowest_v
    return FootSurface(tube, cut, rule, length, points, cloud.weight, laser, cloud.u, cloud.v, residual, *lowest)


def _first_fit(
    cloud: _Cloud, chart: FootChart, rule: ClosureRule, settings: SurfaceSettings, xy_board: Floats
) -> tuple[_Cloud, AssumedSkin]:
    """A coarse fit of the seen skin: drops gross errors and shows how the skin leans where it was last seen."""
    around, spans = _counts(_FIRST, len(cloud.u), settings)
    knots = row_knots(spans)
    stiffness = _stiffness(cloud.weight, around, knots, settings)
    tube = fit_tube(cloud.u, cloud.v, cloud.xyz, cloud.weight, around, knots, stiffness)
    gone = np.abs(distance_mm(tube, cloud.u, cloud.v, cloud.xyz)) > _TUKEY * _FIRST_TOLERANCE_MM
    if gone.mean() > 0.2:
        raise MeshError(
            f"{gone.mean():.0%} of the points lie more than {_TUKEY * _FIRST_TOLERANCE_MM:.1f} mm from any smooth "
            "foot; this is no foot, or it moved: scan again"
        )
    cloud = replace(cloud, weight=np.where(gone, 0.0, cloud.weight))
    return cloud, assume_bottom(tube, cloud.u[~gone], cloud.v[~gone], chart.axis, rule, xy_board)


def _fine_fit(
    cloud: _Cloud, bottom: AssumedSkin, z_cut_mm: float, prior: Floats, settings: SurfaceSettings
) -> tuple[SplineTube, _Cloud]:
    """Alternate between fitting, correcting parameters and re-weighting (Tukey)."""
    around, spans = _counts((settings.count_u, settings.spans_v), len(cloud.u), settings)
    knots = row_knots(spans)
    largest_step = (0.5 / around, 0.5 / spans)
    assumed = np.full(len(bottom.u), settings.closure_weight * float(cloud.weight.mean()))
    target = np.concatenate([cloud.xyz, bottom.xyz_mm])
    tube = SplineTube(np.zeros((len(knots) - 4, around, 3)), knots)
    for k in range(settings.passes):
        u, v = np.concatenate([cloud.u, bottom.u]), np.concatenate([cloud.v, bottom.v])
        weight = np.concatenate([cloud.weight, assumed])
        tube = fit_tube(u, v, target, weight, around, knots, _stiffness(cloud.weight, around, knots, settings))
        u, v = nearer_parameters(tube, cloud.u, cloud.v, cloud.xyz, largest_step)
        cloud = replace(cloud, u=u, v=v)
        if k + 1 < settings.passes:
            ratio = distance_mm(tube, u, v, cloud.xyz) / (_TUKEY * settings.tolerance_mm)
            fade = np.where(np.abs(ratio) < 1.0, (1.0 - ratio**2) ** 2, 0.0)
            cloud = replace(cloud, weight=prior * fade * (cloud.weight > 0.0))
    return flat_ends(tube, z_cut_mm), cloud


def _counts(wanted: tuple[int, int], points: int, settings: SurfaceSettings) -> tuple[int, int]:
    """Control columns and spans, fewer where there are few points."""
    full = settings.count_u * settings.spans_v * _FEWEST_PER_CONTROL
    shrink = min(1.0, float(np.sqrt(points / full)))
    return max(32, 2 * round(0.5 * wanted[0] * shrink)), max(16, round(wanted[1] * shrink))


def row_knots(spans: int) -> Floats:
    """Clamped knots of the direction up, denser in the lower part, where the toes are."""
    v = np.linspace(0.0, 1.0, 101)
    return clamped_knots(graded_breaks(np.interp(v, [_TOE_SHARE, _TOE_SHARE + 0.1], [_TOE_DENSITY, 1.0]), spans))


def _stiffness(weight: Floats, around: int, knots: Floats, settings: SurfaceSettings) -> Floats:
    rows = len(knots) - 4
    return np.full((rows, around), settings.stiffness * float(weight.sum()) / (rows * around))


def flat_ends(tube: SplineTube, z_cut_mm: float) -> SplineTube:
    """The same tube with its first row exactly on the board, its last exactly in the cut, and nothing beyond either."""
    net = tube.net_mm.copy()
    net[..., 2] = np.clip(net[..., 2], 0.0, z_cut_mm)
    net[0, :, 2], net[-1, :, 2] = 0.0, z_cut_mm
    return replace(tube, net_mm=net)
