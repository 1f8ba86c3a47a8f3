"""`customise(shoelast, foot, clearance)`: the smoothest change of a last that holds a foot, with its proof."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import trimesh
from scipy import sparse as scipy_sparse

from footscan.coordinates import Bools, Floats, Ints
from footscan.errors import QualityError
from footscan.foot.nurbs import DEGREE
from footscan.foot.nurbs_fit import evaluate_at
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.geometry.nearest import PointTree
from footscan.shoelast.change_region import find_free
from footscan.shoelast.chart import Chart, Sparse, bending_matrix, build_chart, coarse_space, greville_places, refined
from footscan.shoelast.custom_last import CustomLast
from footscan.shoelast.custom_report import find_dimensions, find_held, find_smoothness, find_unmet
from footscan.shoelast.dimensions import with_points_and_lines
from footscan.shoelast.foot_pose import InsoleStack, PosedFoot, pose_foot
from footscan.shoelast.foot_pose_joints import Joints
from footscan.shoelast.foot_samples import FootSamples, sample_foot
from footscan.shoelast.girth_wish import check_girths, girth_places, girth_pulls
from footscan.shoelast.model import Shoelast
from footscan.shoelast.need import Need, Room, find_need, parameters_at
from footscan.shoelast.obstacle import Pull, Rows, Unknowns, find_unknowns, solve_smoothest
from footscan.shoelast.patches import lower_edge, with_boundary
from footscan.shoelast.pins import Pin, pinned_mm
from footscan.shoelast.prepared_foot import PreparedFoot, prepare_foot
from footscan.shoelast.profile import Profile, load_profile, most_loss_mm, room_mm, uniform_profile
from footscan.shoelast.proof import Judged, judge, prove
from footscan.shoelast.refusals import check_no_spike, check_not_everywhere, check_side, check_size
from footscan.shoelast.registration import Registration, register
from footscan.shoelast.skin import LastSkin, skin_of
from footscan.shoelast.top_line import FeatherLine, TopLine, find_top_line
from footscan.shoelast.widening import Widening, find_widening, no_rolling_under

sparse: Any = scipy_sparse
REGISTERING = 9000
SEEN_SAMPLES = 106_000
CHANGED_MM = 0.01
MOST_ROUNDS = 4
_EVERY = 4
"""Every so many samples are looked at to find the need; all of them in the proof."""
_ASKS_MM, _LEAST_LOSS_MM, _LOSS_SLACK = 0.01, 0.1, 1.2
_SAFE_MM, _ENOUGH_MM, _BESIDE_MM = 0.02, 0.03, 0.05
"""Room beyond the least that is asked of the smooth surface, for the facets of the mesh; what a round leaves alone."""
_HOLD_MM, _CLOSE_SHARE = 6.0, 0.6
"""Over about this length holding wins against stiffness; and over this share of the transition length the surface
leaves the foot for the sake of smoothness (the d^2 beside l^4 |Hessian|^2 of the functional)."""
_CELLS = 2
_SPAN_SHARE = 0.5
"""Spans of the displacement's own net are at most this share of the transition length."""
_LEAST_SAY, _LEAST_SHARE, _UNSEEN_SHARE = 0.05, 0.05, 0.2


@dataclass(frozen=True)
class CustomSettings:
    """How to customise.

    Attributes:
        transition_mm: How far a change may reach beyond the skin that asks for it.
        stack: Insole under the foot.
        joints: What each joint of the foot may do.
        hold: Whether heel sides, waist and instep may lose material where the foot has too much room.
        pins: Spot allowances.
        girths_mm: Wanted tape girths of the last, name -> mm (ball_girth, waist_girth, instep_girth).
    """

    transition_mm: float = 10.0
    stack: InsoleStack = field(default_factory=InsoleStack)
    joints: Joints = field(default_factory=Joints)
    hold: bool = True
    pins: tuple[Pin, ...] = ()
    girths_mm: Mapping[str, float] = field(default_factory=dict[str, float])


def customise(
    shoelast: Shoelast,
    foot: PreparedFoot | trimesh.Trimesh,
    clearance: Profile | str | float = "therapeutic",
    settings: CustomSettings | None = None,
) -> CustomLast:
    """Change a last as smoothly as possible so that it holds a foot.

    Args:
        shoelast: In its frame, with its points.
        foot: Prepared, or a mesh in mm standing on z = 0 (taken to be of the last's side).
        clearance: A profile, its name, or one clearance (mm) for everywhere.
        settings: Transition length, insole, joints, pins, girths; None for the defaults.

    Raises:
        InputError: The wrong side, an unknown profile, or a mesh that is no foot.
        QualityError: The last is about two sizes short or smaller than the foot everywhere (grade first), its pitch
            needs a scan on a wedge, or no displacement meets all that is asked.
    """
    settings = settings or CustomSettings()
    profile = _profile(clearance)
    prepared = prepare_foot(foot, shoelast.side) if isinstance(foot, trimesh.Trimesh) else foot
    check_girths(settings.girths_mm)
    check_side(shoelast, prepared)
    posed = pose_foot(prepared, shoelast, settings.stack, settings.joints)
    posed, registration = register(posed, shoelast, sample_foot(posed, REGISTERING), profile)
    check_size(shoelast, posed, registration)
    task = _Task(_fine_enough(shoelast, settings.transition_mm), posed, profile, settings)
    return task.solved(registration)


def _profile(clearance: Profile | str | float) -> Profile:
    if isinstance(clearance, str):
        return load_profile(clearance)
    return clearance if isinstance(clearance, Profile) else uniform_profile(float(clearance))


def _fine_enough(shoelast: Shoelast, transition_mm: float) -> Shoelast:
    """The same last on a net whose spans are short beside the transition."""
    tube = shoelast.upper
    breaks = tube.knots_v[DEGREE:-DEGREE]
    grid = tube.grid(np.arange(2 * tube.count_u) / (2 * tube.count_u), breaks)
    around = np.linalg.norm(np.diff(grid, axis=1), axis=2).sum(axis=1).max() / tube.count_u
    times = 1
    while around / times > _SPAN_SHARE * transition_mm:
        times *= 2
    up = np.linalg.norm(np.diff(grid, axis=0), axis=2).max(axis=1)
    long = up > 0.9 * transition_mm
    extra = 0.5 * (breaks[:-1] + breaks[1:])[long]
    return refined(shoelast, times, extra) if times > 1 or len(extra) else shoelast


@dataclass(frozen=True)
class _State:
    """A displaced last: coefficients, the last itself, its mesh, and the samples' signed distances from it."""

    coefficients: Floats
    shoelast: Shoelast
    skin: LastSkin
    mesh: DistanceMesh
    signed_mm: Floats


class _Task:
    """One last, one foot, and the displacement between them."""

    def __init__(self, shoelast: Shoelast, posed: PosedFoot, profile: Profile, settings: CustomSettings) -> None:
        self.shoelast, self.posed, self.profile, self.settings = shoelast, posed, profile, settings
        self.chart: Chart = build_chart(shoelast)
        self.skin: LastSkin = skin_of(shoelast)
        self.mesh = DistanceMesh(self.skin.xyz_shoelast, self.skin.faces)
        self.top_line: TopLine = find_top_line(shoelast, posed)
        self.samples, self.judged = _enough_samples(posed, shoelast, self.top_line)
        self.room = wanted_room(self.samples, posed, profile, settings)
        self.energy: Sparse = bending_matrix(self.chart.tube)

    def solved(self, registration: Registration) -> CustomLast:
        """Find the displacement, look at the mesh, and raise it where it lacks, until the mesh holds the foot."""
        some = np.flatnonzero(self.judged.seen)[::_EVERY]
        xyz, room = self.samples.xyz[some], self.room.of(some)
        need, signed = find_need(self.chart, self.skin, self.mesh, xyz, room)
        check_not_everywhere(self.shoelast, signed)
        need = worst_per_cell(need, room, self.chart)
        asking, pull = self._asking(need)
        widening = find_widening(self.chart, need, self.profile.most_overhang_mm)
        asking = np.vstack([asking, widening.places, self._tapes()])
        free = find_free(self.chart, asking, self.settings.transition_mm)
        unknowns = self._unknowns(free, widening, need)
        rows = [no_rolling_under(self.chart), self._held_out(need)]
        state = self._solve(unknowns, rows, pull + self._girths(np.zeros(self.chart.shape), self.skin, self.mesh))
        rounds = 1
        while rounds < MOST_ROUNDS and (len(lacking := self._lacking(state)) or (rounds == 1 and self._wanted_girths)):
            if len(lacking):
                more, places = self._raised(state, lacking)
                rows += [more, self._raised_nearest(state, lacking)]
                asking = np.vstack([asking, places])
                free = find_free(self.chart, asking, self.settings.transition_mm)
                unknowns = self._unknowns(free, widening, need)
            state = self._solve(unknowns, rows, pull + self._girths(state.coefficients, state.skin, state.mesh))
            rounds += 1
        return self._finished(registration, state, need, widening, rounds)

    @property
    def _wanted_girths(self) -> Mapping[str, float]:
        return self.settings.girths_mm

    def _tapes(self) -> Floats:
        return girth_places(self.skin, self.shoelast.points, self._wanted_girths)

    def _girths(self, coefficients: Floats, skin: LastSkin, mesh: DistanceMesh) -> list[Pull]:
        now = Chart(self.chart.displaced(coefficients), self.chart.direction)
        return girth_pulls(now, coefficients, skin, mesh, self.shoelast.points, self._wanted_girths)

    def _asking(self, need: Need) -> tuple[Floats, list[Pull]]:
        """Places of the upper that ask for a change, and the wishes to hold the foot closer."""
        out = need.known & (need.move_mm > _ASKS_MM)
        loose = need.known & (need.loss_mm > _LEAST_LOSS_MM) & (need.hold_mm < -_LEAST_LOSS_MM) & self.settings.hold
        asking = out | loose
        wish = np.where(loose, -np.minimum(-need.hold_mm, need.loss_mm), np.maximum(need.move_mm, 0.0))[asking]
        length = np.where(loose[asking], _HOLD_MM, _CLOSE_SHARE * self.settings.transition_mm)
        pull = Pull(self.chart.rows(need.u[asking], need.v[asking]), wish, self._cell_area(need.of(asking)) / length**4)
        return evaluate_at(self.chart.tube, need.u[asking], need.v[asking]).xyz_mm, [pull]

    def _cell_area(self, need: Need) -> Floats:
        """Area (mm2) of the cell of each place."""
        here = evaluate_at(self.chart.tube, need.u, need.v)
        area = np.linalg.norm(np.cross(here.along_u, here.along_v), axis=1)
        return area / float(np.prod(self.chart.shape) * _CELLS**2)

    def _unknowns(self, free: Bools, widening: Widening, need: Need) -> Unknowns:
        coarse = coarse_space(self.chart.tube, _SPAN_SHARE * self.settings.transition_mm)
        fixed = np.outer(coarse.edge, widening.edge)
        least = np.zeros(self.chart.shape)
        loose = need.known & (need.loss_mm > _LEAST_LOSS_MM) & (need.hold_mm < -_LEAST_LOSS_MM)
        if self.settings.hold and loose.any():
            places = evaluate_at(self.chart.tube, need.u[loose], need.v[loose]).xyz_mm
            u, v = greville_places(self.chart.tube)
            grid = self.chart.tube.grid(u, v).reshape(-1, 3)
            gap, which = PointTree(places).nearest(grid, 1, self.settings.transition_mm)
            near = np.isfinite(gap[:, 0])
            least.reshape(-1)[near] = -_LOSS_SLACK * need.loss_mm[loose][which[near, 0]]
        return find_unknowns(free, fixed, least, coarse)

    def _held_out(self, need: Need) -> Rows:
        """The foot stays inside: d(u, v) >= what each cell needs."""
        used = need.known & (need.move_mm > -_LOSS_SLACK * need.loss_mm - _ASKS_MM)
        return Rows(
            self.chart.rows(need.u[used], need.v[used]), need.move_mm[used] + _SAFE_MM * (need.move_mm[used] > 0)
        )

    def _solve(self, unknowns: Unknowns, rows: list[Rows], pull: list[Pull]) -> _State:
        reachable = [_reachable(row, unknowns) for row in rows]
        found = unknowns.coefficients(solve_smoothest(self.energy, unknowns, reachable, pull), self.chart.shape)
        upper = self.chart.displaced(found)
        moved = replace(self.shoelast, upper=upper, bottom=with_boundary(self.shoelast.bottom, lower_edge(upper)))
        skin = skin_of(moved)
        mesh = self.mesh.moved(skin.xyz_shoelast)
        signed = np.full(len(self.samples.xyz), np.nan)
        judged = self.judged.seen
        signed[judged] = mesh.nearest(self.samples.xyz[judged]).signed
        return _State(found, moved, skin, mesh, signed)

    def _lacking(self, state: _State) -> Ints:
        """Samples that lack room, with those that have next to none beside them; none when all have enough."""
        lack = np.where(self.judged.seen, state.signed_mm + self.room.least_mm, -1.0)
        return np.flatnonzero(lack > -_BESIDE_MM) if lack.max() > _ENOUGH_MM else np.empty(0, dtype=np.int64)

    def _raised(self, state: _State, lacking: Ints) -> tuple[Rows, Floats]:
        """Conditions from places that lack room, followed to the surface as it is now; and where it asks for more."""
        room = self.room.of(lacking)
        now = Chart(state.shoelast.upper, self.chart.direction)
        need, _ = find_need(now, state.skin, state.mesh, self.samples.xyz[lacking], room)
        need = worst_per_cell(need, room, self.chart)
        used = need.known & (need.move_mm > -2.0 * _BESIDE_MM)
        rows = self.chart.rows(need.u[used], need.v[used])
        asks = need.known & (need.move_mm > _ASKS_MM)
        places = evaluate_at(self.chart.tube, need.u[asks], need.v[asks]).xyz_mm
        return Rows(rows, rows @ state.coefficients.ravel() + need.move_mm[used] + _SAFE_MM), places

    def _raised_nearest(self, state: _State, lacking: Ints) -> Rows:
        """The same with the nearest places: beside a steep rim they are not those straight out."""
        lacking = lacking[state.signed_mm[lacking] + self.room.least_mm[lacking] > 0.0]
        near = state.mesh.nearest(self.samples.xyz[lacking])
        u, v = parameters_at(state.skin, near.face, near.weight, near.xyz)
        along = (near.normal * evaluate_at(self.chart.direction, u, v).xyz_mm).sum(axis=1)
        rows: Sparse = sparse.diags(along) @ self.chart.rows(u, v)
        lack = near.signed + self.room.least_mm[lacking]
        return Rows(rows, rows @ state.coefficients.ravel() + lack + _SAFE_MM)

    def _finished(
        self, registration: Registration, state: _State, need: Need, widening: Widening, rounds: int
    ) -> CustomLast:
        rest = ~self.judged.seen
        signed = state.signed_mm.copy()
        signed[rest] = state.mesh.nearest(self.samples.xyz[rest]).signed
        proof = prove(self.samples, self.judged, self.room.least_mm, signed, self.top_line)
        after = with_points_and_lines(state.shoelast)
        dims = find_dimensions(self.shoelast, after)
        moved = np.zeros(len(state.skin.xyz_shoelast))
        rows = self.chart.rows(state.skin.uv[:, 0], state.skin.uv[:, 1])
        moved[: len(state.skin.uv)] = rows @ state.coefficients.ravel()
        way = np.linalg.norm(state.skin.xyz_shoelast - self.skin.xyz_shoelast, axis=1)
        moved[len(state.skin.uv) :] = way[len(state.skin.uv) :]  # bottom and cone top move with their edges
        check_no_spike(self.shoelast, moved, need.move_mm)
        changed = way > CHANGED_MM
        return CustomLast(
            shoelast=after,
            original=self.shoelast,
            skin=state.skin,
            displacement_mm=moved,
            changed=changed,
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
        )


def _reachable(rows: Rows, unknowns: Unknowns) -> Rows:
    """Without conditions on which no unknown has a say: they stay in the proof."""
    say = np.asarray(abs(rows.matrix @ unknowns.spread).sum(axis=1)).ravel()
    kept = say > _LEAST_SAY
    return Rows(rows.matrix[kept], rows.right[kept])


def worst_per_cell(need: Need, room: Room, chart: Chart) -> Need:
    """Of all places in one small cell of the chart, the one that asks most."""
    rows, columns = chart.shape
    cell = np.floor(need.u * _CELLS * columns).astype(np.int64) * (_CELLS * rows) + np.floor(
        np.minimum(need.v, 1.0 - 1e-9) * _CELLS * rows
    ).astype(np.int64)
    order = np.lexsort((-np.where(need.known, need.move_mm, -np.inf), cell))
    first = order[np.concatenate([[True], np.diff(cell[order]) > 0])]
    return need.of(first)


def wanted_room(samples: FootSamples, posed: PosedFoot, profile: Profile, settings: CustomSettings) -> Room:
    """What is wanted of every sample; pins add to it."""
    least, most = room_mm(profile, samples.place, samples.normal_foot)
    extra = pinned_mm(settings.pins, posed, samples)
    return Room(least + extra, np.maximum(most, least) + extra, most_loss_mm(profile, samples.place))


def _enough_samples(posed: PosedFoot, shoelast: Shoelast, top_line: TopLine) -> tuple[FootSamples, Judged]:
    """Samples of which at least the proof's number are judged."""
    feather = FeatherLine(shoelast)
    low = np.asarray(top_line.below(posed.shell.xyz)[posed.shell.faces].any(axis=1), dtype=np.bool_)
    plain = sample_foot(posed, 4000, faces=low)
    share = float(judge(plain, feather.height_mm(plain.xyz), top_line).seen.mean())
    if share < _LEAST_SHARE:
        raise QualityError(
            f"only {share:.0%} of the skin below the top line was seen; at least {_LEAST_SHARE:.0%} are needed to "
            "prove that the last holds the foot. Scan again with more of the foot in view."
        )
    rough = sample_foot(posed, 8000, unseen_share=_UNSEEN_SHARE, faces=low)
    share = float(judge(rough, feather.height_mm(rough.xyz), top_line).seen.mean())
    samples = sample_foot(posed, int(SEEN_SAMPLES / share), unseen_share=_UNSEEN_SHARE, faces=low)
    return samples, judge(samples, feather.height_mm(samples.xyz), top_line)
