"""What customising did to a last: dimensions, held properties, smoothness, and wishes that were not met."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse as scipy_sparse
from scipy.sparse import linalg as splinalg

from footscan.coordinates import Floats
from footscan.foot.nurbs import DEGREE, SplineTube
from footscan.shoelast.chart import Chart, Sparse, bending_matrix, greville_places
from footscan.shoelast.custom_last import Held, Smoothness
from footscan.shoelast.dimensions import Dimension, with_dimensions
from footscan.shoelast.model import Shoelast
from footscan.shoelast.need import Need
from footscan.shoelast.profile import Profile
from footscan.shoelast.proof import LIMIT_MM, Proof
from footscan.shoelast.registration import Registration

sparse: Any = scipy_sparse
solver: Any = splinalg
HELD_MM, HELD_DEG = 0.1, 0.2
GIRTH_MM = 1.5
_STEPS = 720
_BLEND_MM = 1.0
_SYMMETRIC = {"SymmetricMode": True}

Dims = dict[str, tuple[float, float, str]]


@dataclass(frozen=True)
class Measured:
    """A last measured for a report.

    Attributes:
        shoelast: With its points and lines.
        dimensions: All of `DEFINITIONS`.
        curvature_per_mm: Principal curvatures `(k, m, 2)`.
        curvature_step_per_mm2: Their largest change from place to place.
        feather_deg: `(360,)` angle of the feather edge.
    """

    shoelast: Shoelast
    dimensions: Mapping[str, Dimension]
    curvature_per_mm: Floats
    curvature_step_per_mm2: float
    feather_deg: Floats


def measure_last(shoelast: Shoelast) -> Measured:
    """Find points, lines, dimensions, curvatures and the feather edge's angle of a last."""
    found, dims = with_dimensions(shoelast)
    curvature = curvature_per_mm(shoelast.upper)
    step = _largest_step(shoelast.upper, curvature)
    return Measured(found, dims, curvature, step, feather_angle_deg(shoelast))


@dataclass(frozen=True)
class Standard:
    """The last that is customised: as measured, and the bending energy of displacements of it."""

    measured: Measured
    bending: Sparse


def measure_standard(shoelast: Shoelast) -> Standard:
    """Measure the last that is customised."""
    return Standard(measure_last(shoelast), bending_matrix(shoelast.upper))


def find_dimensions(before: Measured, after: Measured) -> Dims:
    """Name -> before, after, unit."""
    old, new = before.dimensions, after.dimensions
    return {name: (old[name].value, new[name].value, old[name].unit) for name in old}


def find_held(before: Shoelast, after: Shoelast, dims: Dims, widening_mm: float) -> dict[str, Held]:
    """What is held: pitch, toe spring, tread point, shank, back curve, cone top, and the bottom unless it was widened.

    The height of the toe box is stated; it may only grow, where the foot needs it.
    """
    moved = "bottom was widened" if widening_mm > 0 else ""
    bottom = None if moved else HELD_MM
    held = {name: Held(*dims[name][:2], HELD_MM, "mm") for name in ("pitch", "toe_spring")}
    held["toe_box_height"] = Held(*dims["toe_box_height"][:2], None, "mm")
    for name in ("tread_point", "seat_point"):
        held[f"{name}_z"] = Held(float(before.points[name][2]), float(after.points[name][2]), HELD_MM, "mm")
        held[f"{name}_x"] = Held(float(before.points[name][0]), float(after.points[name][0]), bottom, "mm")
    v = np.linspace(0.0, 1.0, 200)
    held["back_curve"] = Held(0.0, _most_apart(before.upper.grid(_ZERO, v), after.upper.grid(_ZERO, v)), HELD_MM, "mm")
    u = np.arange(_STEPS) / _STEPS
    held["cone_edge"] = Held(0.0, _most_apart(before.upper.grid(u, _ONE), after.upper.grid(u, _ONE)), HELD_MM, "mm")
    held["feather_line"] = Held(0.0, _most_apart(before.upper.grid(u, _ZERO), after.upper.grid(u, _ZERO)), bottom, "mm")
    s = np.linspace(0.0, 1.0, 200)
    middle = [last.bottom.grid(s, np.array([0.5])) for last in (before, after)]
    held["shank"] = Held(0.0, _most_apart(*middle), bottom, "mm")
    pattern = [last.bottom.grid(s, np.linspace(0.0, 1.0, 40)) for last in (before, after)]
    held["bottom_pattern"] = Held(0.0, _most_apart(*pattern), bottom, "mm")
    return held | _slopes(before, after)


_ZERO, _ONE = np.array([0.0]), np.array([1.0])


def _slopes(before: Shoelast, after: Shoelast) -> dict[str, Held]:
    """Directions (degrees) of the bottom's middle at the seat, shank and toes, and of the cone top."""
    found: dict[str, Held] = {}
    for name, (low, high) in {
        "seat_slope": (0.05, 0.25),
        "shank_slope": (0.3, 0.55),
        "toe_slope": (0.85, 0.98),
    }.items():
        found[name] = Held(slope_deg(before, low, high), slope_deg(after, low, high), HELD_DEG, "deg")
    return found


def slope_deg(shoelast: Shoelast, low: float, high: float) -> float:
    """How steeply the middle of the bottom rises between two shares of its length."""
    rear, front = shoelast.bottom.grid(np.array([low, high]), np.array([0.5]))[:, 0]
    return float(np.degrees(np.arctan2(front[2] - rear[2], front[0] - rear[0])))


def _most_apart(a: Floats, b: Floats) -> float:
    return float(np.linalg.norm(a - b, axis=-1).max())


def find_smoothness(standard: Standard, coefficients: Floats, after: Measured) -> Smoothness:
    """Energy, curvatures and the feather edge's angle."""
    flat, before, energy = coefficients.ravel(), standard.measured, standard.bending
    edge = (before.feather_deg, after.feather_deg)
    return Smoothness(
        energy=float(flat @ (energy @ flat)),
        curvature_change_per_mm=float(np.abs(after.curvature_per_mm - before.curvature_per_mm).max()),
        curvature_step_per_mm2=(before.curvature_step_per_mm2, after.curvature_step_per_mm2),
        feather_deg=(float(edge[0].max()), float(edge[1].max())),
        feather_change_deg=float(np.abs(edge[1] - edge[0]).max()),
    )


def _places(tube: SplineTube) -> tuple[Floats, Floats]:
    breaks = tube.knots_v[DEGREE:-DEGREE]
    v = np.concatenate([breaks[:-1] + share * np.diff(breaks) for share in (0.25, 0.75)])
    return np.arange(2 * tube.count_u) / (2 * tube.count_u), np.sort(v)


def curvature_per_mm(tube: SplineTube) -> Floats:
    """Principal curvatures `(k, m, 2)` on a grid of two places per span and direction."""
    u, v = _places(tube)
    su, sv = tube.grid(u, v, order_u=1), tube.grid(u, v, order_v=1)
    normal = np.cross(sv, su)
    normal /= np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-12)
    first = np.stack([(su * su).sum(2), (su * sv).sum(2), (sv * sv).sum(2)])
    orders = ((2, 0), (1, 1), (0, 2))
    second = np.stack([(tube.grid(u, v, order_u=a, order_v=b) * normal).sum(2) for a, b in orders])
    det = np.maximum(first[0] * first[2] - first[1] ** 2, 1e-12)
    mean = (first[2] * second[0] - 2.0 * first[1] * second[1] + first[0] * second[2]) / (2.0 * det)
    root = np.sqrt(np.maximum(mean**2 - (second[0] * second[2] - second[1] ** 2) / det, 0.0))
    return np.stack([mean - root, mean + root], axis=2)


def _largest_step(tube: SplineTube, curvature: Floats) -> float:
    """Largest change of a principal curvature from place to place, per mm of way."""
    xyz = tube.grid(*_places(tube))
    steps: list[float] = []
    for axis in (0, 1):
        way = np.maximum(np.linalg.norm(np.diff(xyz, axis=axis), axis=2, keepdims=True), 0.2)
        steps.append(float((np.abs(np.diff(curvature, axis=axis)) / way).max()))
    return max(steps)


def feather_angle_deg(shoelast: Shoelast) -> Floats:
    """Angle inside the last between bottom and upper along the feather edge, `(360,)`; 180 would be no edge."""
    share: Floats = (np.arange(180, dtype=np.float64) + 0.5) / 180.0
    angles: list[Floats] = []
    halves: tuple[tuple[float, Floats], ...] = ((1.0, 0.5 * share), (0.0, 1.0 - 0.5 * share))
    for t, u in halves:
        along = shoelast.upper.grid(u, _ZERO, order_u=1)[0]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        up = shoelast.upper.grid(u, _ZERO, order_v=1)[0]
        across = shoelast.bottom.grid(share, np.array([t]), order_t=1)[:, 0] * (1.0 if t == 0.0 else -1.0)
        pair = [way - (way * along).sum(axis=1, keepdims=True) * along for way in (up, across)]
        pair = [way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12) for way in pair]
        angles.append(np.degrees(np.arccos(np.clip((pair[0] * pair[1]).sum(axis=1), -1.0, 1.0))))
    return np.concatenate(angles)


def plain_maximum_energy(chart: Chart, energy: Sparse, need: Need) -> float:
    """Bending energy of the plain smooth maximum of last and foot: (g + sqrt(g^2 + e^2)) / 2, in the same splines."""
    used = need.known & (need.move_mm > -3.0 * _BLEND_MM)
    move = need.move_mm[used]
    wanted = 0.5 * (move + np.sqrt(move**2 + _BLEND_MM**2))
    u, v = (part.ravel() for part in np.meshgrid(*greville_places(chart.tube)))
    free = np.abs(chart.rows(need.u[used], need.v[used])).sum(axis=0)
    quiet = np.asarray(free).ravel() == 0.0
    rows = sparse.vstack([chart.rows(need.u[used], need.v[used]), chart.rows(u[quiet], v[quiet])])
    right = np.concatenate([wanted, np.zeros(int(quiet.sum()))])
    normal = (rows.T @ rows + 1e-6 * energy + 1e-9 * sparse.identity(rows.shape[1])).tocsc()
    found = np.asarray(solver.splu(normal, permc_spec="MMD_AT_PLUS_A", options=_SYMMETRIC).solve(rows.T @ right))
    return float(found @ (energy @ found))


def find_unmet(
    proof: Proof, dims: Dims, lie: Registration, profile: Profile, girths_mm: Mapping[str, float]
) -> tuple[str, ...]:
    """Wishes that were not met, in words."""
    unmet: list[str] = []
    if proof.worst_violation_mm > LIMIT_MM:
        at = ", ".join(f"{x:.0f}" for x in proof.worst_at)
        unmet.append(f"{proof.worst_violation_mm:.2f} mm of room is missing at ({at}) mm of the last's frame")
    least, most = profile.toe_room_mm
    if not least <= lie.toe_mm <= most:
        word = "less" if lie.toe_mm < least else "more"
        unmet.append(
            f"{lie.toe_mm:.1f} mm of room in front of the toes, {word} than the {least:g} to {most:g} mm wanted"
        )
    for name, wanted in girths_mm.items():
        if abs(dims[name][1] - wanted) > GIRTH_MM:
            unmet.append(f"{name} is {dims[name][1]:.1f} mm, {wanted:.1f} +- {GIRTH_MM} mm was wanted")
    return tuple(unmet)
