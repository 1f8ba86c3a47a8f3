"""Feet scaled up and down: is the first of the ranking the size and width that the size rule gives?"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import trimesh

from footscan.coordinates import Side
from footscan.shoelast.fitting_defaults import profile_data
from footscan.shoelast.last_library import LastEntry
from footscan.shoelast.prepared_foot import PreparedFoot, prepare_foot
from footscan.shoelast.profile import load_profile
from footscan.shoelast.rank import Ranked, rank
from footscan.shoelast.refusals import SIZE_RULE_ROOM_MM

SCALES = (0.85, 0.9, 0.95, 1.0, 1.05, 1.1)
MOST_SIZES, MOST_WIDTHS = 0.5, 1.0
WIDTH_MM = 6.0
"""Of ball girth, per width fitting (indicative)."""
_RIGHT_WIDTHS = 1.5
"""A last no further off than this may be taken."""


@dataclass(frozen=True)
class RankingOutcome:
    """The first of one foot's ranking, and where wrong lasts came.

    Attributes:
        name: Of the foot.
        scale: Times its real size.
        side: Of the foot.
        foot_length_mm: Of the scaled foot.
        ball_girth_mm: Likewise.
        first: The best last.
        sizes_off: EU size of the first less that of the size rule.
        widths_off: Ball girth of the first for its length less what the foot's wants, in widths.
        narrowest_off: Widths that the best-fitting last of the rule's size is off: what the library can do at all.
        wrong_above_median: Lasts of the wrong side in the better half, and lasts two widths off in the better half of
            the foot's side; where fewer than that half may be taken, among as many as may be.
    """

    name: str
    scale: float
    side: str
    foot_length_mm: float
    ball_girth_mm: float
    first: Ranked
    sizes_off: float
    widths_off: float
    narrowest_off: float
    wrong_above_median: int

    @property
    def well(self) -> bool:
        """Within half a size and one width, wrong ones behind."""
        near = abs(self.sizes_off) <= MOST_SIZES and abs(self.widths_off) <= MOST_WIDTHS
        return near and self.wrong_above_median == 0


def run_ranking_study(
    feet: Sequence[tuple[str, trimesh.Trimesh, Side | None]],
    entries: Sequence[LastEntry],
    scales: Sequence[float] = SCALES,
    profile: str = "therapeutic",
) -> Iterator[RankingOutcome]:
    """Rank for every foot (name, mesh in mm standing on z = 0, side) at every scale."""
    for name, mesh, side in feet:
        for scale in scales:
            foot = prepare_foot(_scaled(mesh, scale), side)
            yield ranking_outcome(name, scale, foot, entries, profile)


def _scaled(mesh: trimesh.Trimesh, scale: float) -> trimesh.Trimesh:
    """The same foot in another size, with the origin of its skin."""
    larger = mesh.copy()
    larger.vertices = np.asarray(mesh.vertices) * scale
    return larger


def ranking_outcome(
    name: str, scale: float, foot: PreparedFoot, entries: Sequence[LastEntry], profile: str
) -> RankingOutcome:
    """One foot's ranking judged by the size rule and the width that its ball girth asks for."""
    ranking = rank(entries, foot, profile)
    rule = profile_data()["size_rule"]
    wanted = rule["per_mm"] * foot.value("foot_length") + rule["offset"]
    off = np.array([_widths_off(one, profile) for one in ranking])
    wrong = np.array([one.entry.side != foot.side for one in ranking])
    of_size = np.array([abs((one.entry.size_eu or wanted) - wanted) <= MOST_SIZES for one in ranking])
    least = float(np.abs(off[of_size & ~wrong]).min(initial=np.inf))
    two_off, right = np.abs(off[~wrong]) > 2.0, np.abs(off[~wrong]) <= _RIGHT_WIDTHS
    better = min(len(right) // 2, int(right.sum()))
    first = ranking[0]
    return RankingOutcome(
        name=name,
        scale=scale,
        side=foot.side,
        foot_length_mm=foot.value("foot_length"),
        ball_girth_mm=foot.value("ball_girth"),
        first=first,
        sizes_off=(first.entry.size_eu or wanted) - wanted,
        widths_off=float(off[0]),
        narrowest_off=least if np.isfinite(least) else 0.0,
        wrong_above_median=int(wrong[: len(ranking) // 2].sum() + two_off[:better].sum()),
    )


def _widths_off(one: Ranked, profile: str) -> float:
    """How much fuller a last is for its own length than the foot wants for its own."""
    band = load_profile(profile).bands["ball_girth_mm"]
    per_mm = profile_data()["width_rule"]["girth_per_length_mm"]
    longer = one.differences_mm["length_room"] - SIZE_RULE_ROOM_MM
    return (one.differences_mm["ball_girth"] - 0.5 * (band[0] + band[1]) - per_mm * longer) / WIDTH_MM
