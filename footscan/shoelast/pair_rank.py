"""Which two lasts suit both feet of a person together: of one style and design, each foot with its own size and width.

Two lasts are of one design when style and name agree once size, width and side are taken out of the names.
Unlike lasts need two patterns of everything, so they must be better than the best like ones by a stated cost.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from footscan.coordinates import Side
from footscan.errors import InputError
from footscan.shoelast.fitting_defaults import profile_data
from footscan.shoelast.last_library import LastEntry
from footscan.shoelast.last_pair import SHARED_MM
from footscan.shoelast.prepared_foot import PreparedFoot
from footscan.shoelast.profile import Profile
from footscan.shoelast.rank import Ranked, rank

_LEFT_OUT = frozenset({"left", "right", "graded"})
_SIZE = re.compile(r"(eu)?[2-5]\d([_.,]\d)?")
_WIDTHS = re.compile(r"[+-][\d.]+ widths")
Design = tuple[str, ...]


@dataclass(frozen=True)
class RankedPair:
    """A left and a right last for both feet.

    Attributes:
        left: Its last may be the mirror image of a right one, which its reason says.
        right: The same.
        alike: Of one size and width.
        cost: Of being unlike.
    """

    left: Ranked
    right: Ranked
    alike: bool
    cost: float

    @property
    def score(self) -> float:
        """Of both feet together; lower is better."""
        return self.left.score + self.right.score + self.cost


def rank_pair(
    entries: Sequence[LastEntry], feet: tuple[PreparedFoot, PreparedFoot], profile: Profile | str = "therapeutic"
) -> list[RankedPair]:
    """Pairs for both feet of a person, best first: every like pair, and of every design the best unlike one.

    A last whose twin of the other side is not in the library stands for its mirror image too.

    Args:
        entries: Lasts of either side.
        feet: Left and right.
        profile: Room wanted, or its name.

    Raises:
        InputError: Two feet of one side, or no lasts.
    """
    left, right = feet
    if (left.side, right.side) != ("left", "right"):
        raise InputError(f"a pair is a left and a right foot, found {left.side} and {right.side}.")
    lefts, rights = (_by_design(entries, foot, profile) for foot in feet)
    pairs = [pair for design, found in lefts.items() for pair in _pairs(found, rights[design])]
    if not pairs:
        raise InputError(
            "the library holds no two lasts of one design, pitch and toe spring; see `footscan lasts list`."
        )
    return sorted(pairs, key=lambda pair: pair.score)


def _by_design(
    entries: Sequence[LastEntry], foot: PreparedFoot, profile: Profile | str
) -> Mapping[Design, list[Ranked]]:
    """Design -> its lasts for one foot, best first."""
    found = dict[Design, list[Ranked]]()
    sides = {entry.id: entry.side for entry in entries}
    for one in rank(_for_side(entries, foot.side), foot, profile):
        side = sides[one.entry.id]
        reasons = [one.reason, "" if side == foot.side else f"the mirror image of a {side} last"]
        found.setdefault(pair_design(one.entry), []).append(replace(one, reason="; ".join(filter(None, reasons))))
    return found


def _for_side(entries: Sequence[LastEntry], side: Side) -> list[LastEntry]:
    """Lasts of a side, and mirror images of those whose twin of this side is not there."""
    own = [entry for entry in entries if entry.side == side]
    known = {(pair_design(entry), _size(entry)) for entry in own}
    others = [entry for entry in entries if entry.side != side]
    return own + [replace(one, side=side) for one in others if (pair_design(one), _size(one)) not in known]


def _pairs(lefts: Sequence[Ranked], rights: Sequence[Ranked]) -> list[RankedPair]:
    by_size = {_size(one.entry): one for one in reversed(rights)}
    both = [(one, by_size[_size(one.entry)]) for one in lefts if _size(one.entry) in by_size]
    alike = [RankedPair(*pair, alike=True, cost=0.0) for pair in both if _agree(*pair)]
    best = next(((lefts[0], one) for one in rights if _agree(lefts[0], one)), None)
    if best is None or _size(best[0].entry) == _size(best[1].entry):
        return alike
    return [*alike, RankedPair(*best, alike=False, cost=float(profile_data()["pair_rule"]["unlike"]))]


def _agree(left: Ranked, right: Ranked) -> bool:
    one, other = left.entry.dimensions, right.entry.dimensions
    return all(abs(one[name] - other[name]) <= limit for name, limit in SHARED_MM.items())


def _size(entry: LastEntry) -> tuple[float | None, str]:
    return entry.size_eu, entry.fitting.lower()


def pair_design(entry: LastEntry) -> Design:
    """What the lasts of one pair have in common: style, and the name without size, width and side."""
    fitting = re.split(r"[+-]", entry.fitting.lower())[0]
    words = re.split(r"[\s-]+", _WIDTHS.sub("", entry.name.lower()))
    kept = [word for word in words if word not in _LEFT_OUT and word != fitting and not _SIZE.fullmatch(word)]
    return (entry.style, *filter(None, kept))
