"""Wanted tape girths of a last, as a pull on its displacement."""

from collections.abc import Mapping

import numpy as np
from scipy import sparse

from footscan.coordinates import Floats
from footscan.errors import InputError
from footscan.foot.crossing import convex_hull, hull_perimeter_mm
from footscan.foot.nurbs_fit import evaluate_at
from footscan.foot.sections import cut_shell, plane_axes
from footscan.foot.shell import Shell
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.shoelast.chart import Chart, Sparse
from footscan.shoelast.dimensions import TapePlane, tape_planes
from footscan.shoelast.need import parameters_at
from footscan.shoelast.obstacle import Pull
from footscan.shoelast.skin import LastSkin

GIRTHS = ("ball_girth", "waist_girth", "instep_girth")
_BESIDE_MM = (-15.0, -10.0, -5.0, 0.0, 5.0, 10.0, 15.0)
_WEIGHT = 60.0
"""Per mm2 of a missed girth, beside the bending energy of the displacement."""


def check_girths(girths_mm: Mapping[str, float]) -> None:
    """Refuse girths that cannot be asked for.

    Raises:
        InputError: An unknown name, or a number that is no girth.
    """
    for name, value in girths_mm.items():
        if name not in GIRTHS:
            raise InputError(f"girth {name!r}: not known; allowed are {', '.join(GIRTHS)}.")
        if not 100.0 <= value <= 450.0:
            raise InputError(f"{name} of {value:g} mm was asked for, allowed are 100 to 450 mm.")


def girth_places(skin: LastSkin, points: Mapping[str, Floats], girths_mm: Mapping[str, float]) -> Floats:
    """Places `(k, 3)` of the last that the tapes of the wanted girths touch, and beside them: they may change.

    A girth is given by a long stretch of the last: were only the tape's own places free, it would come out as a hoop.
    """
    planes = tape_planes(points)
    beside = [
        TapePlane(planes[name].origin + shift * planes[name].normal, planes[name].normal)
        for name in girths_mm
        for shift in _BESIDE_MM
    ]
    return np.vstack([np.zeros((0, 3)), *(_corners(skin, plane)[0] for plane in beside)])


def girth_pulls(
    chart: Chart,
    coefficients: Floats,
    skin: LastSkin,
    mesh: DistanceMesh,
    points: Mapping[str, Floats],
    girths_mm: Mapping[str, float],
) -> list[Pull]:
    """Pulls towards girths, linear about the last as it is now.

    Args:
        chart: Its `tube` is the upper as `skin` shows it.
        coefficients: `(n_v, n_u)` that made it so.
        skin: Of the last now.
        mesh: The same.
        points: The last's own, through which the tapes run.
        girths_mm: Wanted.
    """
    planes = tape_planes(points)
    return [_pull(chart, coefficients, skin, mesh, planes[name], wanted) for name, wanted in girths_mm.items()]


def _corners(skin: LastSkin, plane: TapePlane) -> tuple[Floats, Floats, Floats]:
    """Corners `(k, 3)` of the stretched tape, in the plane `(k, 2)`, and the plane's axes `(3, 2)`."""
    axes = np.stack(plane_axes(plane.normal), axis=1)
    shell = Shell(skin.xyz_shoelast, np.ascontiguousarray(skin.faces))
    cut = cut_shell(shell, plane.origin, plane.normal).xyz.reshape(-1, 3)
    corner = cut[convex_hull(cut @ axes)]
    return corner, corner @ axes, axes


def _pull(
    chart: Chart, coefficients: Floats, skin: LastSkin, mesh: DistanceMesh, plane: TapePlane, wanted: float
) -> Pull:
    xyz, flat, axes = _corners(skin, plane)
    near = mesh.nearest(xyz)
    on_upper = skin.faces[near.face].max(axis=1) < len(skin.uv)
    u, v = parameters_at(skin, near.face, near.weight, near.xyz)
    ahead, behind = np.roll(flat, -1, axis=0) - flat, flat - np.roll(flat, 1, axis=0)
    pulling = _units(behind) - _units(ahead)
    normal = near.normal @ axes
    slope = (pulling * normal).sum(axis=1) / np.maximum((normal**2).sum(axis=1), _LEAST_IN_PLANE)
    slope = np.maximum(slope, 0.0)  # at the feather edge the nearest face may look past the tape: no material, no way
    along = (near.normal * evaluate_at(chart.direction, u, v).xyz_mm).sum(axis=1)
    row: Sparse = sparse.csr_matrix((slope * along * on_upper)[None]) @ chart.rows(u, v)
    missing = max(wanted - hull_perimeter_mm(flat), -_MOST_LESS_MM)
    return Pull(row, missing + row @ coefficients.ravel(), np.array([_WEIGHT]))


_LEAST_IN_PLANE = 0.2
_MOST_LESS_MM = 3.0
"""Less is asked at once at most: a girth far below what the foot leaves would drown everything else in the solver."""


def _units(way: Floats) -> Floats:
    return way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
