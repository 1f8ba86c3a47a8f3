"""From a displacement that was found to the customised last: proof, dimensions, what was held, and what moved."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.foot.nurbs import SplineTube
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.geometry.nearest import PointTree
from footscan.shoelast.chord import chord_error
from footscan.shoelast.custom_last import CustomLast, Smoothing
from footscan.shoelast.custom_report import (
    Standard,
    find_dimensions,
    find_held,
    find_smoothness,
    find_unmet,
    measure_last,
)
from footscan.shoelast.fit_case import FitCase
from footscan.shoelast.judged_skin import seen_share
from footscan.shoelast.model import Shoelast
from footscan.shoelast.need import Need
from footscan.shoelast.proof import prove
from footscan.shoelast.refusals import check_no_spike, overshoot_mm
from footscan.shoelast.registration import Registration
from footscan.shoelast.skin import Breaks, LastSkin
from footscan.shoelast.widening import Widening

CHANGED_MM = 0.01


@dataclass(frozen=True)
class Displaced:
    """A displaced last: coefficients `(n_v, n_u)`, the last itself and its mesh."""

    coefficients: Floats
    shoelast: Shoelast
    skin: LastSkin
    mesh: DistanceMesh


@dataclass(frozen=True)
class Search:
    """How a displacement was found.

    Attributes:
        skin: The standard last on the final mesh.
        breaks: Where that samples it.
        need: What the foot needs of the standard last.
        beside: The same of skin between seen skin, and above the top line.
        widening: Of the bottom.
        rounds: How often it was solved.
        places: `(n, 3)` of the upper that ask for a change.
        smoothing: What was smoothed.
    """

    skin: LastSkin
    breaks: Breaks
    need: Need
    beside: tuple[Need, ...]
    widening: Widening
    rounds: int
    places: Floats
    smoothing: Smoothing | None


def custom_last(
    case: FitCase, registration: Registration, state: Displaced, signed_mm: Floats, search: Search, before: Standard
) -> CustomLast:
    """Prove and measure what was found.

    Args:
        case: Last and foot.
        registration: How the foot was laid in.
        state: The displaced last.
        signed_mm: `(n,)` signed distances of the samples from its mesh; NaN where nobody looked.
        search: How it was found.
        before: The standard last, measured.

    Raises:
        QualityError: It swings far beyond what the foot asks for.
    """
    rest = np.isnan(signed_mm)
    signed_mm[rest] = state.mesh.nearest(case.samples.xyz[rest]).signed
    proof = prove(case.samples, case.judged, case.room.least_mm, signed_mm, case.top_line)
    measured = measure_last(state.shoelast)
    after, dims = measured.shoelast, find_dimensions(before.measured, measured)
    way = np.linalg.norm(state.skin.xyz_shoelast - search.skin.xyz_shoelast, axis=1)
    moved = _displacement(case, state, search.breaks, way)
    beyond = _overshoot(case, search, moved)
    check_no_spike(case.shoelast, beyond)
    most = search.widening.most_mm
    return CustomLast(
        shoelast=after,
        original=case.shoelast,
        skin=state.skin,
        breaks=search.breaks,
        chord_error_mm=chord_error(after, search.breaks).bound_mm,
        displacement_mm=moved,
        changed=way > CHANGED_MM,
        posed=case.posed,
        registration=registration,
        profile=case.profile,
        transition_mm=case.transition_mm,
        dimensions=dims,
        held=find_held(case.shoelast, after, dims, most),
        widening_mm=most,
        smoothness=find_smoothness(before, state.coefficients, measured),
        smoothing=search.smoothing,
        unmet=find_unmet(proof, dims, registration, case.profile, case.settings.girths_mm),
        proof=proof,
        rounds=search.rounds,
        need=search.need,
        overshoot_mm=beyond,
        outside_mm=_moved_outside(case, search, way),
        seen_share=seen_share(case.judged),
    )


def _displacement(case: FitCase, state: Displaced, breaks: Breaks, way_mm: Floats) -> Floats:
    """Displacements `(n,)` of the mesh along the directions; bottom and cone top move with their edges."""
    field = SplineTube(state.coefficients[..., None], case.chart.tube.knots_v)
    return np.concatenate([field.grid(breaks.around, breaks.up).ravel(), way_mm[len(state.skin.uv) :]])


def _moved_outside(case: FitCase, search: Search, way_mm: Floats) -> float:
    """The largest movement of the upper further from every place that asks than the transition length."""
    count = len(search.skin.uv)
    if len(search.places) == 0:
        return float(way_mm[:count].max())
    upper = np.ascontiguousarray(search.skin.xyz_shoelast[:count])
    gap = PointTree(np.ascontiguousarray(search.places)).nearest(upper, 1, case.transition_mm)[0][:, 0]
    return float(way_mm[:count][~np.isfinite(gap)].max(initial=0.0))


def _overshoot(case: FitCase, search: Search, moved_mm: Floats) -> float:
    need = search.need
    both = [need.of(need.known & (need.move_mm > 0.0)), *search.beside]
    places = np.vstack([case.on_upper(one) for one in both])
    move = np.concatenate([one.move_mm for one in both])
    count = len(search.skin.uv)
    return overshoot_mm(places, move, search.skin.xyz_shoelast[:count], moved_mm[:count], case.transition_mm)
