"""The displacement between one last and one foot: found, looked at on the mesh, raised where it lacks, and proved."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import sparse as scipy_sparse

from footscan.coordinates import Floats, Ints
from footscan.foot.nurbs_fit import evaluate_at
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.geometry.nearest import PointTree
from footscan.shoelast.change_region import find_free
from footscan.shoelast.chart import Chart, Sparse, bending_matrix, build_chart, greville_places
from footscan.shoelast.chord import breaks_within, chord_error
from footscan.shoelast.custom_last import CustomLast
from footscan.shoelast.custom_report import find_dimensions, find_held, find_smoothness, find_unmet
from footscan.shoelast.custom_settings import CustomSettings
from footscan.shoelast.dimensions import with_points_and_lines
from footscan.shoelast.foot_pose import PosedFoot
from footscan.shoelast.girth_wish import girth_places, girth_pulls
from footscan.shoelast.judged_skin import judged_samples, seen_share, wanted_room
from footscan.shoelast.model import Shoelast
from footscan.shoelast.need import CELLS, Need, find_need, parameters_at
from footscan.shoelast.nets import coarse_space
from footscan.shoelast.obstacle import Pull, Rows, Unknowns, find_unknowns, solve_smoothest
from footscan.shoelast.patches import lower_edge, with_boundary
from footscan.shoelast.profile import Profile
from footscan.shoelast.proof import prove
from footscan.shoelast.refusals import check_no_spike, check_not_everywhere, overshoot_mm
from footscan.shoelast.registration import Registration
from footscan.shoelast.skin import Breaks, LastSkin, Sampling, even_breaks, skin_of
from footscan.shoelast.top_line import TopLine, find_top_line
from footscan.shoelast.widening import Widening, find_widening, no_rolling_under

sparse: Any = scipy_sparse
CHANGED_MM = 0.01
MESH_CHORD_MM = 0.017
"""Largest chord error of the mesh when it is laid out; the corrections after that leave it within 0.02 mm."""
MOST_ROUNDS = 8
_ASKS_MM, _LEAST_LOSS_MM, _LOSS_SLACK = 0.01, 0.1, 1.2
_SAFE_MM, _RAISED_MM, _ENOUGH_MM, _BESIDE_MM = 0.03, 0.05, 0.03, 0.05
"""Room beyond the least that is asked of the smooth surface, for what lies between the places asked and for the facets
of the mesh, at first and where it lacked; what a round leaves alone."""
_HOLD_MM, _CLOSE_SHARE = 6.0, 0.6
"""Over about this length holding wins against stiffness; and over this share of the transition length the surface
leaves the foot for the sake of smoothness (the d^2 beside l^4 |Hessian|^2 of the functional)."""
_SPAN_SHARE = 0.6
"""Spans of the displacement's own net are at most this share of the transition length."""
_LEAST_SAY = 0.05
_RISE_REACH = 2.0
"""A later rise may reach over so many transition lengths, but not beyond what may change at all."""


@dataclass(frozen=True)
class _State:
    """A displaced last: coefficients, the last itself and its mesh."""

    coefficients: Floats
    shoelast: Shoelast
    skin: LastSkin
    mesh: DistanceMesh


@dataclass(frozen=True)
class _Asked:
    """What is asked of a displacement.

    Attributes:
        places: `(n, 3)` of the upper that ask for a change.
        wanted: The field at those of them that need room.
        rows: Conditions.
        pulls: Wishes.
        fixed: `(n_v, n_u)` coefficients that are there whatever is found: a widened feather edge.
        least: `(n_v, n_u)` lower bounds.
    """

    places: Floats
    wanted: Sparse
    rows: tuple[Rows, ...]
    pulls: tuple[Pull, ...]
    fixed: Floats
    least: Floats


class DisplacementTask:
    """One last, one foot, and the displacement between them."""

    def __init__(self, shoelast: Shoelast, posed: PosedFoot, profile: Profile, settings: CustomSettings) -> None:
        """Take a last on a fine enough net and a foot that lies in it."""
        self.shoelast, self.posed, self.profile, self.settings = shoelast, posed, profile, settings
        self.chart: Chart = build_chart(shoelast)
        self.breaks = even_breaks(Sampling())
        self.skin: LastSkin = skin_of(shoelast, self.breaks)
        self.mesh = DistanceMesh(self.skin.xyz_shoelast, self.skin.faces)
        self.top_line: TopLine = find_top_line(shoelast, posed)
        self.samples, self.judged = judged_samples(posed, shoelast, self.top_line)
        self.room = wanted_room(self.samples, posed, profile, settings)
        self.energy: Sparse = bending_matrix(self.chart.tube)
        self._between: tuple[Need, ...] = ()
        self.coarse = coarse_space(self.chart.tube, _SPAN_SHARE * settings.transition_mm)

    def solved(self, registration: Registration) -> CustomLast:
        """Find the displacement, look at the mesh, and raise it where it lacks, until the mesh holds the foot."""
        seen = np.flatnonzero(self.judged.seen)
        need, before = find_need(self.chart, self.skin, self.mesh, self.samples.xyz[seen], self.room.of(seen))
        check_not_everywhere(self.shoelast, before)
        widening = find_widening(self.chart, need, self.profile.most_overhang_mm)
        asked = self._with_bridged(self._asked(need, widening))
        state = self._first(asked)
        signed, lacking = self._look(state, seen)
        rounds = 1
        while rounds < MOST_ROUNDS and len(lacking):
            asked, raised = self._with_raised(asked, state, lacking, signed)
            state = self._corrected(state, asked, raised)
            signed, lacking = self._look(state, seen)
            rounds += 1
        return self._finished(registration, state, signed, need, widening, rounds, asked.places)

    def _asked(self, need: Need, widening: Widening) -> _Asked:
        """What a foot asks of the standard last."""
        asking, pull = self._asking(need)
        places = np.vstack([self._on_upper(asking), widening.places, self._tapes()])
        wanted = self.chart.rows(asking.u, asking.v)
        rows = (no_rolling_under(self.chart), self._held_out(need))
        fixed = np.outer(self.coarse.edge, widening.edge)
        return _Asked(places, wanted, rows, tuple(pull), fixed, self._least(need))

    def _with_bridged(self, asked: _Asked) -> _Asked:
        """The wish that skin between seen skin gets its room as well, so that no ridge stands between two stripes.

        It is a wish alone: bridged skin sets no condition, has no say in the widening, and is not judged.
        """
        between = np.flatnonzero(self.judged.unseen & self.samples.bridged)
        if len(between) == 0:
            return asked
        need, _ = find_need(self.chart, self.skin, self.mesh, self.samples.xyz[between], self.room.of(between))
        need = need.of(need.known & (need.move_mm > _ASKS_MM))
        self._between = (need,)
        weight = self._cell_area(need) / (_CLOSE_SHARE * self.settings.transition_mm) ** 4
        pull = Pull(self.chart.rows(need.u, need.v), need.move_mm, weight)
        return replace(asked, places=np.vstack([asked.places, self._on_upper(need)]), pulls=(*asked.pulls, pull))

    def _first(self, asked: _Asked) -> _State:
        """The smoothest displacement; wanted girths are looked at once more on the last that it makes."""
        free = find_free(self.chart, asked.places, self.settings.transition_mm)
        unknowns = find_unknowns(free, asked.fixed, asked.least, self.coarse, asked.wanted)
        girths = self._girths(np.zeros(self.chart.shape), self.skin, self.mesh)
        found = self._solve(unknowns, asked.rows, (*asked.pulls, *girths))
        if self._wanted_girths:
            state = self._state(found, self.breaks)
            girths = self._girths(found, state.skin, state.mesh)
            found = self._solve(unknowns, asked.rows, (*asked.pulls, *girths))
        self.breaks = breaks_within(self._displaced(found), MESH_CHORD_MM)[0]
        self.skin = skin_of(self.shoelast, self.breaks)
        return self._state(found, self.breaks)

    def _corrected(self, state: _State, asked: _Asked, raised: Need) -> _State:
        """The smoothest rise that gives room where it lacks, beside what is there already."""
        near = find_free(self.chart, self._on_upper(raised), _RISE_REACH * self.settings.transition_mm)
        free = near & find_free(self.chart, asked.places, self.settings.transition_mm)
        wanted = self.chart.rows(raised.u, raised.v)
        none = np.zeros(self.chart.shape)
        unknowns = find_unknowns(free, state.coefficients, none, self.coarse, wanted)
        return self._state(self._solve(unknowns, asked.rows, asked.pulls), self.breaks)

    def _with_raised(self, asked: _Asked, state: _State, lacking: Ints, signed: Floats) -> tuple[_Asked, Need]:
        more, raised = self._raised(state, lacking)
        rows = (*asked.rows, more, self._raised_nearest(state, lacking, signed))
        return replace(asked, places=np.vstack([asked.places, self._on_upper(raised)]), rows=rows), raised

    @property
    def _wanted_girths(self) -> Mapping[str, float]:
        return self.settings.girths_mm

    def _tapes(self) -> Floats:
        return girth_places(self.skin, self.shoelast.points, self._wanted_girths)

    def _girths(self, coefficients: Floats, skin: LastSkin, mesh: DistanceMesh) -> list[Pull]:
        now = Chart(self.chart.displaced(coefficients), self.chart.direction)
        return girth_pulls(now, coefficients, skin, mesh, self.shoelast.points, self._wanted_girths)

    def _on_upper(self, need: Need) -> Floats:
        return evaluate_at(self.chart.tube, need.u, need.v).xyz_mm

    def _asking(self, need: Need) -> tuple[Need, list[Pull]]:
        """Places that ask for a change, and the wishes to hold the foot closer."""
        out = need.known & (need.move_mm > _ASKS_MM)
        loose = need.known & (need.loss_mm > _LEAST_LOSS_MM) & (need.hold_mm < -_LEAST_LOSS_MM) & self.settings.hold
        asking = need.of(out | loose)
        wish = np.where(loose, -np.minimum(-need.hold_mm, need.loss_mm), np.maximum(need.move_mm, 0.0))[out | loose]
        length = np.where(loose[out | loose], _HOLD_MM, _CLOSE_SHARE * self.settings.transition_mm)
        pull = Pull(self.chart.rows(asking.u, asking.v), wish, self._cell_area(asking) / length**4)
        return asking, [pull]

    def _cell_area(self, need: Need) -> Floats:
        """Area (mm2) of the cell of each place."""
        here = evaluate_at(self.chart.tube, need.u, need.v)
        area = np.linalg.norm(np.cross(here.along_u, here.along_v), axis=1)
        return area / float(CELLS[0] * CELLS[1])

    def _least(self, need: Need) -> Floats:
        """Lower bounds `(n_v, n_u)` of the coefficients: what the last may lose near places that are too roomy."""
        least = np.zeros(self.chart.shape)
        loose = need.known & (need.loss_mm > _LEAST_LOSS_MM) & (need.hold_mm < -_LEAST_LOSS_MM)
        if self.settings.hold and loose.any():
            u, v = greville_places(self.chart.tube)
            grid = self.chart.tube.grid(u, v).reshape(-1, 3)
            gap, which = PointTree(self._on_upper(need.of(loose))).nearest(grid, 1, self.settings.transition_mm)
            near = np.isfinite(gap[:, 0])
            least.reshape(-1)[near] = -_LOSS_SLACK * need.loss_mm[loose][which[near, 0]]
        return least

    def _held_out(self, need: Need) -> Rows:
        """The foot stays inside: d(u, v) >= what each cell needs."""
        used = need.known & (need.move_mm > -_LOSS_SLACK * need.loss_mm - _ASKS_MM)
        return Rows(
            self.chart.rows(need.u[used], need.v[used]), need.move_mm[used] + _SAFE_MM * (need.move_mm[used] > 0)
        )

    def _solve(self, unknowns: Unknowns, rows: tuple[Rows, ...], pulls: tuple[Pull, ...]) -> Floats:
        reachable = [_reachable(row, unknowns) for row in rows]
        return unknowns.coefficients(solve_smoothest(self.energy, unknowns, reachable, list(pulls)), self.chart.shape)

    def _displaced(self, coefficients: Floats) -> Shoelast:
        upper = self.chart.displaced(coefficients)
        return replace(self.shoelast, upper=upper, bottom=with_boundary(self.shoelast.bottom, lower_edge(upper)))

    def _state(self, coefficients: Floats, breaks: Breaks | None) -> _State:
        moved = self._displaced(coefficients)
        skin = skin_of(moved, breaks)
        same = self.mesh.xyz.shape == skin.xyz_shoelast.shape
        mesh = self.mesh.moved(skin.xyz_shoelast) if same else DistanceMesh(skin.xyz_shoelast, skin.faces)
        self.mesh = mesh
        return _State(coefficients, moved, skin, mesh)

    def _look(self, state: _State, seen: Ints) -> tuple[Floats, Ints]:
        """Signed distances of the judged samples, and those that lack room.

        Returns:
            `(n,)` distances, NaN where nobody looked, and indices of samples that lack room or have next to none beside
            one that lacks it; none when all have enough.
        """
        signed = np.full(len(self.samples.xyz), np.nan)
        signed[seen] = state.mesh.nearest(self.samples.xyz[seen]).signed
        lack = signed[seen] + self.room.least_mm[seen]
        enough = lack.max(initial=-np.inf) <= _ENOUGH_MM
        return signed, np.empty(0, dtype=np.int64) if enough else seen[lack > -_BESIDE_MM]

    def _raised(self, state: _State, lacking: Ints) -> tuple[Rows, Need]:
        """Conditions from places that lack room, followed to the surface as it is now; and where it asks for more."""
        now = Chart(state.shoelast.upper, self.chart.direction)
        need, _ = find_need(now, state.skin, state.mesh, self.samples.xyz[lacking], self.room.of(lacking))
        used = need.of(need.known & (need.move_mm > -2.0 * _BESIDE_MM))
        rows = self.chart.rows(used.u, used.v)
        right = rows @ state.coefficients.ravel() + used.move_mm + _RAISED_MM
        return Rows(rows, right), used.of(used.move_mm > _ASKS_MM)

    def _raised_nearest(self, state: _State, lacking: Ints, signed: Floats) -> Rows:
        """The same with the nearest places: beside a steep rim they are not those straight out."""
        lacking = lacking[signed[lacking] + self.room.least_mm[lacking] > 0.0]
        near = state.mesh.nearest(self.samples.xyz[lacking])
        u, v = parameters_at(state.skin, near.face, near.weight, near.xyz)
        along = (near.normal * evaluate_at(self.chart.direction, u, v).xyz_mm).sum(axis=1)
        rows: Sparse = sparse.diags(along) @ self.chart.rows(u, v)
        lack = near.signed + self.room.least_mm[lacking]
        return Rows(rows, rows @ state.coefficients.ravel() + lack + _RAISED_MM)

    def _finished(
        self,
        registration: Registration,
        state: _State,
        signed: Floats,
        need: Need,
        widening: Widening,
        rounds: int,
        places: Floats,
    ) -> CustomLast:
        rest = np.isnan(signed)
        signed[rest] = state.mesh.nearest(self.samples.xyz[rest]).signed
        proof = prove(self.samples, self.judged, self.room.least_mm, signed, self.top_line)
        after = with_points_and_lines(state.shoelast)
        dims = find_dimensions(self.shoelast, after)
        way = np.linalg.norm(state.skin.xyz_shoelast - self.skin.xyz_shoelast, axis=1)
        moved = self._displacement(state, way)
        beyond = self._overshoot(need, moved)
        check_no_spike(self.shoelast, beyond)
        return CustomLast(
            shoelast=after,
            original=self.shoelast,
            skin=state.skin,
            breaks=self.breaks,
            chord_error_mm=chord_error(after, self.breaks).bound_mm,
            displacement_mm=moved,
            changed=way > CHANGED_MM,
            posed=self.posed,
            registration=registration,
            profile=self.profile,
            transition_mm=self.settings.transition_mm,
            dimensions=dims,
            held=find_held(self.shoelast, after, dims, widening.most_mm),
            widening_mm=widening.most_mm,
            smoothness=find_smoothness(self.chart, self.energy, state.coefficients, self.shoelast, after),
            unmet=find_unmet(proof, dims, registration, self.profile, self.settings.girths_mm),
            proof=proof,
            rounds=rounds,
            need=need,
            overshoot_mm=beyond,
            outside_mm=self._moved_outside(places, way),
            seen_share=seen_share(self.judged),
        )

    def _moved_outside(self, places: Floats, way_mm: Floats) -> float:
        """The largest movement of the upper further from every place that asks than the transition length."""
        count = len(self.skin.uv)
        if len(places) == 0:
            return float(way_mm[:count].max())
        upper = np.ascontiguousarray(self.skin.xyz_shoelast[:count])
        gap = PointTree(np.ascontiguousarray(places)).nearest(upper, 1, self.settings.transition_mm)[0][:, 0]
        return float(way_mm[:count][~np.isfinite(gap)].max(initial=0.0))

    def _overshoot(self, need: Need, moved_mm: Floats) -> float:
        both = [need.of(need.known & (need.move_mm > 0.0)), *self._between]
        places = np.vstack([self._on_upper(one) for one in both])
        move = np.concatenate([one.move_mm for one in both])
        count, reach = len(self.skin.uv), self.settings.transition_mm
        return overshoot_mm(places, move, self.skin.xyz_shoelast[:count], moved_mm[:count], reach)

    def _displacement(self, state: _State, way_mm: Floats) -> Floats:
        """Displacements `(n,)` of the mesh along the directions; bottom and cone top move with their edges."""
        count = len(state.skin.uv)
        rows = self.chart.rows(state.skin.uv[:, 0], state.skin.uv[:, 1])
        return np.concatenate([rows @ state.coefficients.ravel(), way_mm[count:]])


def _reachable(rows: Rows, unknowns: Unknowns) -> Rows:
    """Without conditions on which no unknown has a say: they stay in the proof."""
    say = np.asarray(abs(rows.matrix @ unknowns.spread).sum(axis=1)).ravel()
    kept = say > _LEAST_SAY
    return Rows(rows.matrix[kept], rows.right[kept])
