"""The displacement between one last and one foot: found, looked at on the mesh, raised where it lacks, and proved."""

from collections.abc import Mapping
from concurrent.futures import Future
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import sparse as scipy_sparse

from footscan.coordinates import Bools, Floats, Ints
from footscan.foot.nurbs_fit import evaluate_at
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.shoelast.asked import ASKS_MM, Asked, ask, with_bridged, with_run_out
from footscan.shoelast.chart import Chart, Sparse
from footscan.shoelast.chord import breaks_within
from footscan.shoelast.custom_last import CustomLast
from footscan.shoelast.custom_report import Standard
from footscan.shoelast.custom_result import Displaced, Search, custom_last
from footscan.shoelast.fairing import faired, smoothing_of
from footscan.shoelast.fit_case import FitCase
from footscan.shoelast.girth_wish import girth_places, girth_pulls
from footscan.shoelast.need import Need, Room, find_need, parameters_at
from footscan.shoelast.obstacle import Pull, Rows, Unknowns, Watch, find_unknowns, solve_smoothest, unwatched
from footscan.shoelast.refusals import check_not_everywhere
from footscan.shoelast.registration import Registration
from footscan.shoelast.skin import Breaks, LastSkin, skin_of
from footscan.shoelast.widening import find_widening

sparse: Any = scipy_sparse
MESH_CHORD_MM = 0.017
"""Largest chord error of the mesh when it is laid out; the corrections after that leave it within 0.02 mm."""
MOST_ROUNDS, _MORE_ROUNDS, _GIRTH_ROUNDS = 8, 4, 2
_RAISED_MM, _ENOUGH_MM, _BESIDE_MM = 0.05, 0.03, 0.05
"""Room beyond the least that is asked where the mesh lacked, for its facets; what a round leaves alone."""
_DOUBTFUL_MM = 0.3
"""Samples further than this from lacking room are looked at when the displacement is found, not before."""
_LEAST_SAY = 0.05
_RISE_REACH = 3.0
"""A later rise may reach over so many transition lengths, but not beyond what may change at all."""


class DisplacementTask:
    """The displacement of one case."""

    def __init__(self, case: FitCase, drawn_in_mm: float = 0.0, watch: Watch = unwatched) -> None:
        """Begin with the standard last's mesh.

        Args:
            case: Last and foot.
            drawn_in_mm: How much nearer than the transition length the change has to end.
            watch: Called before every step; what it raises ends the work.
        """
        self._watch = watch
        self.case, self._reach_mm = case, case.transition_mm - drawn_in_mm
        self.breaks, self.skin, self.mesh = case.breaks, case.skin, case.mesh
        self._fine: Ints = np.empty(0, dtype=np.int64)

    def solved(self, registration: Registration, before: "Future[Standard]") -> CustomLast:
        """Find the displacement, look at the mesh, and raise it where it lacks, until the mesh holds the foot.

        Args:
            registration: How the foot was laid in.
            before: The standard last, measured meanwhile.
        """
        case = self.case
        some = np.flatnonzero(case.judged.seen)
        need, signed_mm = find_need(case.chart, self.skin, self.mesh, case.samples.xyz[some], case.room.of(some))
        check_not_everywhere(case.shoelast, signed_mm)
        self._watch()
        widening = find_widening(case.chart, need, case.profile.most_overhang_mm)
        asked = ask(case, need, widening, girth_places(self.skin, case.shoelast.points, self._wanted_girths))
        self._watch()
        bridged = self._bridged()
        for one in bridged:
            asked = with_bridged(case, asked, one)
        self._watch()
        beyond = self._beyond_top_line()
        for one in beyond:
            asked = with_run_out(case, asked, one)
        self._near = case.region.near(asked.places, self._reach_mm)
        doubtful = some[signed_mm + case.room.least_mm[some] > -self._most_loss(asked) - _DOUBTFUL_MM]
        state = self._first(asked)
        state, signed, asked, rounds = self._raised_until_held(asked, state, doubtful, MOST_ROUNDS)
        smoothing = None
        if case.settings.smooth_mm > 0.0:
            plain, limit = state, case.settings.smooth_mm
            girths = self._girths(plain.coefficients, plain.skin, plain.mesh)
            moved = faired(case, replace(asked, pulls=tuple(girths)), plain.coefficients, self._free(), self._fine)
            state = self._state(moved, self.breaks)
            state, signed, asked, more = self._raised_until_held(asked, state, doubtful, _MORE_ROUNDS)
            smoothing, rounds = smoothing_of(case, before.result(), plain, state, limit), rounds + more
        search = Search(self.skin, self.breaks, need, (*bridged, *beyond), widening, rounds, asked.places, smoothing)
        return custom_last(case, registration, state, signed, search, before.result())

    def _most_loss(self, asked: Asked) -> float:
        return float(-asked.least.min(initial=0.0))

    def _bridged(self) -> tuple[Need, ...]:
        """What skin between seen skin needs."""
        case = self.case
        between = np.flatnonzero(case.judged.unseen & case.samples.bridged)
        if len(between) == 0:
            return ()
        need, _ = find_need(case.chart, self.skin, self.mesh, case.samples.xyz[between], case.room.of(between))
        return (need.of(need.known & (need.move_mm > ASKS_MM)),)

    def _beyond_top_line(self) -> tuple[Need, ...]:
        """Where skin above the top line stands out of the last."""
        case = self.case
        if len(case.run_out) == 0:
            return ()
        none = np.zeros(len(case.run_out))
        need, _ = find_need(case.chart, self.skin, self.mesh, case.run_out, Room(none, none, none))
        return (need.of(need.known & (need.move_mm > ASKS_MM)),)

    def _first(self, asked: Asked) -> Displaced:
        """The smoothest displacement; wanted girths are pulled at twice on the last that it makes."""
        case = self.case
        unknowns = find_unknowns(self._free(), asked.fixed, asked.least, case.coarse, asked.wanted)
        found = self._solve(unknowns, asked.rows, asked.pulls)
        for _ in range(_GIRTH_ROUNDS if self._wanted_girths else 0):
            state = self._state(found, self.breaks)
            girths = self._girths(found, state.skin, state.mesh)
            found = self._solve(unknowns, asked.rows, (*asked.pulls, *girths))
        self.breaks = breaks_within(case.displaced(found), MESH_CHORD_MM)[0]
        self.skin = skin_of(case.shoelast, self.breaks)
        return self._state(found, self.breaks)

    def _raised_until_held(
        self, asked: Asked, state: Displaced, doubtful: Ints, most: int
    ) -> tuple[Displaced, Floats, Asked, int]:
        """Look, and raise where room is missing, until the mesh holds the foot or `most` rounds are over.

        Returns:
            The last, signed distances of the judged samples (NaN for the others), what was asked, and the rounds.
        """
        seen = np.flatnonzero(self.case.judged.seen)
        rounds = 1
        signed, lacking = self._look(state, doubtful)
        while True:
            if len(lacking) == 0:
                signed, lacking = self._look(state, seen, signed)
                doubtful = seen if len(lacking) else doubtful
            if len(lacking) == 0 or rounds == most:
                break
            asked, raised = self._with_raised(asked, state, lacking, signed)
            state = self._corrected(state, asked, raised)
            signed, lacking = self._look(state, doubtful)
            rounds += 1
        signed = self._look(state, seen, signed)[0] if len(lacking) else signed
        return state, signed, asked, rounds

    def _corrected(self, state: Displaced, asked: Asked, raised: tuple[Floats, Floats]) -> Displaced:
        """The smoothest rise that gives room where it lacks, at (u, v), beside what is there already."""
        case = self.case
        places = evaluate_at(case.chart.tube, *raised).xyz_mm
        self._near |= case.region.near(places, self._reach_mm)
        free = self._free() & case.region.free(case.region.near(places, _RISE_REACH * case.transition_mm))
        wanted = case.chart.rows(*raised)
        none = np.zeros(case.chart.shape)
        unknowns = find_unknowns(free, state.coefficients, none, case.coarse, wanted)
        return self._state(self._solve(unknowns, asked.rows, asked.pulls), self.breaks)

    def _free(self) -> Bools:
        return self.case.region.free(self._near)

    def _with_raised(
        self, asked: Asked, state: Displaced, lacking: Ints, signed: Floats
    ) -> tuple[Asked, tuple[Floats, Floats]]:
        """Conditions where room lacks, straight out and at the nearest places, and where (u, v) that is.

        A place beside a steep rim may be reached by no direction; then its nearest place alone asks.
        """
        straight, followed = self._raised(state, lacking)
        nearest, u, v = self._raised_nearest(state, lacking, signed)
        raised = (followed.u, followed.v) if len(followed.u) else (u, v)
        rows = (*asked.rows, straight, nearest)
        places = evaluate_at(self.case.chart.tube, *raised).xyz_mm
        return replace(asked, places=np.vstack([asked.places, places]), rows=rows), raised

    @property
    def _wanted_girths(self) -> Mapping[str, float]:
        return self.case.settings.girths_mm

    def _girths(self, coefficients: Floats, skin: LastSkin, mesh: DistanceMesh) -> list[Pull]:
        chart, points = self.case.chart, self.case.shoelast.points
        now = Chart(chart.displaced(coefficients), chart.direction)
        return girth_pulls(now, coefficients, skin, mesh, points, self._wanted_girths)

    def _solve(self, unknowns: Unknowns, rows: tuple[Rows, ...], pulls: tuple[Pull, ...]) -> Floats:
        self._fine = np.union1d(self._fine, unknowns.fine)
        reachable = [_reachable(row, unknowns) for row in rows]
        found = solve_smoothest(self.case.stiffness, unknowns, reachable, list(pulls), self._watch)
        return unknowns.coefficients(found, self.case.chart.shape)

    def _state(self, coefficients: Floats, breaks: Breaks | None) -> Displaced:
        self._watch()
        moved = self.case.displaced(coefficients)
        skin = skin_of(moved, breaks)
        same = self.mesh.xyz.shape == skin.xyz_shoelast.shape
        self.mesh = self.mesh.moved(skin.xyz_shoelast) if same else DistanceMesh(skin.xyz_shoelast, skin.faces)
        return Displaced(coefficients, moved, skin, self.mesh)

    def _look(self, state: Displaced, which: Ints, known: Floats | None = None) -> tuple[Floats, Ints]:
        """Signed distances of some samples, and those that lack room.

        Args:
            state: The last.
            which: Samples to look at.
            known: `(n,)` distances from the same last, NaN where nobody looked.

        Returns:
            `(n,)` distances, NaN where nobody looked, and indices of samples that lack room or have next to none beside
            one that lacks it; none when all have enough.
        """
        self._watch()
        case = self.case
        signed = np.full(len(case.samples.xyz), np.nan) if known is None else known.copy()
        new = which[np.isnan(signed[which])]
        signed[new] = state.mesh.nearest(case.samples.xyz[new]).signed
        lack = signed[which] + case.room.least_mm[which]
        enough = lack.max(initial=-np.inf) <= _ENOUGH_MM
        return signed, np.empty(0, dtype=np.int64) if enough else which[lack > -_BESIDE_MM]

    def _raised(self, state: Displaced, lacking: Ints) -> tuple[Rows, Need]:
        """Conditions from places that lack room, followed to the surface as it is now; and where it asks for more."""
        case = self.case
        now = Chart(state.shoelast.upper, case.chart.direction)
        need, _ = find_need(now, state.skin, state.mesh, case.samples.xyz[lacking], case.room.of(lacking))
        used = need.of(need.known & (need.move_mm > ASKS_MM))
        rows = case.chart.rows(used.u, used.v)
        return Rows(rows, rows @ state.coefficients.ravel() + used.move_mm + _RAISED_MM), used

    def _raised_nearest(self, state: Displaced, lacking: Ints, signed: Floats) -> tuple[Rows, Floats, Floats]:
        """The same with the nearest places (u, v): beside a steep rim they are not those straight out."""
        case = self.case
        lacking = lacking[signed[lacking] + case.room.least_mm[lacking] > ASKS_MM]
        near = state.mesh.nearest(case.samples.xyz[lacking])
        u, v = parameters_at(state.skin, near.face, near.weight, near.xyz)
        along = (near.normal * evaluate_at(case.chart.direction, u, v).xyz_mm).sum(axis=1)
        lack = near.signed + case.room.least_mm[lacking]
        rows: Sparse = sparse.diags(along) @ case.chart.rows(u, v)
        return Rows(rows, rows @ state.coefficients.ravel() + lack + _RAISED_MM), u, v


def _reachable(rows: Rows, unknowns: Unknowns) -> Rows:
    """Without conditions on which no unknown has a say: they stay in the proof."""
    say = np.asarray(abs(rows.matrix @ unknowns.spread).sum(axis=1)).ravel()
    kept = say > _LEAST_SAY
    return Rows(rows.matrix[kept], rows.right[kept])
