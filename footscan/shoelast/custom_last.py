"""What customising gives: the new last, its displacement map, what was held, what was missed, and the proof."""

from dataclasses import dataclass
from typing import Any

from footscan.coordinates import Bools, Floats
from footscan.shoelast.foot_pose import PosedFoot
from footscan.shoelast.model import Shoelast
from footscan.shoelast.need import Need
from footscan.shoelast.profile import Profile
from footscan.shoelast.proof import Proof
from footscan.shoelast.registration import Registration
from footscan.shoelast.skin import Breaks, LastSkin

FULL_SHARE = 0.5
"""With less seen skin than this a result says so."""


@dataclass(frozen=True)
class Held:
    """A property before and after, and how far it may move (None: it may, and is only stated)."""

    before: float
    after: float
    limit: float | None
    unit: str

    @property
    def kept(self) -> bool:
        """Whether it stayed within its limit."""
        return self.limit is None or abs(self.after - self.before) <= self.limit


@dataclass(frozen=True)
class Smoothness:
    """How smooth the change is.

    Attributes:
        energy: Bending energy of the displacement.
        curvature_change_per_mm: Largest change of a principal curvature.
        curvature_step_per_mm2: Largest change of a principal curvature per mm of way on the surface, before and after;
            the surface itself is twice continuously differentiable, so there is no jump.
        feather_deg: Bluntest angle of the feather edge, before and after; 180 would be no edge.
        feather_change_deg: Largest change of that angle anywhere.
    """

    energy: float
    curvature_change_per_mm: float
    curvature_step_per_mm2: tuple[float, float]
    feather_deg: tuple[float, float]
    feather_change_deg: float


@dataclass(frozen=True)
class Smoothing:
    """What smoothing did to a copy of the result; the conditions that the result meets are those of the copy as well.

    Attributes:
        limit_mm: How far it was allowed to move the result.
        most_mm: How far it did.
        variation: Squared change of the bend per mm, summed over the displacement, before and after.
        before: How smooth the result was before.
        dimensions: Name -> before, after, unit.
        unsmoothed: The result before.
    """

    limit_mm: float
    most_mm: float
    variation: tuple[float, float]
    before: Smoothness
    dimensions: dict[str, tuple[float, float, str]]
    unsmoothed: Shoelast


@dataclass(frozen=True)
class CustomLast:
    """A customised last.

    Attributes:
        shoelast: The new last; a NURBS with the original's surface wherever nothing changed.
        original: The last it was made from, on the same control net.
        skin: Closed mesh of the new last (the one the proof is about), in the last's frame in memory.
        breaks: Where it samples the last.
        chord_error_mm: Bound of its distance from the NURBS.
        displacement_mm: `(n,)` per vertex of `skin`: how far it moved, positive outwards.
        changed: `(n,)` which vertices moved by more than 0.01 mm.
        posed: The foot as posed and registered.
        registration: How it was laid in.
        profile: The room that was asked for.
        transition_mm: How far changes reach beyond what asks for them.
        dimensions: Name -> (before, after, unit).
        held: Name -> before and after.
        widening_mm: How far the bottom was widened at most.
        smoothness: See there.
        smoothing: What was smoothed on request, None when nothing was.
        unmet: Wishes that could not be met, in words.
        proof: See there.
        rounds: How often the displacement was solved.
        need: What the foot asked of the original, cell by cell.
        overshoot_mm: How far the displacement goes beyond what any skin near asks for.
        outside_mm: How far the upper moved beyond the transition length from every place that asks, at most.
        seen_share: Share of the skin between feather line and top line that was seen.
    """

    shoelast: Shoelast
    original: Shoelast
    skin: LastSkin
    breaks: Breaks
    chord_error_mm: float
    displacement_mm: Floats
    changed: Bools
    posed: PosedFoot
    registration: Registration
    profile: Profile
    transition_mm: float
    dimensions: dict[str, tuple[float, float, str]]
    held: dict[str, Held]
    widening_mm: float
    smoothness: Smoothness
    smoothing: Smoothing | None
    unmet: tuple[str, ...]
    proof: Proof
    rounds: int
    need: Need
    overshoot_mm: float
    outside_mm: float
    seen_share: float

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a reader must know."""
        if self.seen_share >= FULL_SHARE:
            return self.posed.remarks
        return (
            *self.posed.remarks,
            f"only {self.seen_share:.0%} of the skin between feather line and top line was seen: the proof is about "
            "that alone, and between it the last follows bridged skin. A fuller scan makes a better last.",
        )


def held_json(custom: CustomLast) -> dict[str, Any]:
    """Name -> before, after, limit, unit and whether it was kept."""
    return {
        name: {"before": one.before, "after": one.after, "limit": one.limit, "unit": one.unit, "kept": one.kept}
        for name, one in custom.held.items()
    }
