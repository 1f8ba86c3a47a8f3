"""Both feet of a person: their lasts chosen together, made one pair, customised, and held against each other."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from footscan.config.toml_file import write_whole
from footscan.coordinates import Side
from footscan.errors import InputError, QualityError
from footscan.shoelast.custom_last import CustomLast
from footscan.shoelast.customise import CustomSettings, customise
from footscan.shoelast.last_library import LastLibrary
from footscan.shoelast.last_pair import Agreement, agreements, check_pair, with_even_cones
from footscan.shoelast.model import Shoelast
from footscan.shoelast.pair_rank import RankedPair, rank_pair
from footscan.shoelast.prepared_foot import PreparedFoot
from footscan.workflow.lasts_fit import load_foot, ranked_json, save_custom
from footscan.workflow.stored_foot import stored_subject

SIDES: tuple[Side, Side] = ("left", "right")
PAIR_FILE, PAIR_FORMAT = "pair.json", "footscan-last-pair/1"


@dataclass(frozen=True)
class CustomPair:
    """Two customised lasts, what they have in common, and by how much each cone was raised to the other's height."""

    left: CustomLast
    right: CustomLast
    agreements: Mapping[str, Agreement]
    cone_raised_mm: tuple[float, float]

    @property
    def both(self) -> tuple[tuple[Side, CustomLast], ...]:
        """Side and last, left first."""
        return (("left", self.left), ("right", self.right))


def load_pair(places: tuple[Path, Path], unit: str, wedge: float | None = None) -> tuple[PreparedFoot, PreparedFoot]:
    """A left and a right foot.

    Raises:
        InputError: A folder says the other side, or both shapes do: they were given the wrong way round.
    """
    for place, side in zip(places, SIDES, strict=True):
        known = stored_subject(place).side
        if known not in (None, side):
            raise InputError(f"{place} holds a {known} foot; give the left foot first, then the right one.")
    left, right = (load_foot(place, unit, side, wedge) for place, side in zip(places, SIDES, strict=True))
    if (left.measurements.shape_side, right.measurements.shape_side) == ("right", "left"):
        raise InputError(
            f"{places[0]} looks like a right foot and {places[1]} like a left one; give the left foot first, then the "
            "right one."
        )
    return left, right


def choose_pair(
    library: LastLibrary, feet: tuple[PreparedFoot, PreparedFoot], profile: str, style: str | None = None
) -> tuple[Shoelast, Shoelast]:
    """The best two lasts of one design for both feet together, each foot with its own size and width.

    Raises:
        InputError: No such style, or no pair in the library.
    """
    entries = [entry for entry in library.entries() if style in (None, entry.style)]
    best = rank_pair(entries, feet, profile)[0]
    return library.load(best.left.entry.id), library.load(best.right.entry.id)


def customise_pair(
    shoelasts: tuple[Shoelast, Shoelast],
    feet: tuple[PreparedFoot, PreparedFoot],
    clearance: str,
    settings: CustomSettings | tuple[CustomSettings, CustomSettings],
) -> CustomPair:
    """Left and right lasts of one style, pitch, toe and cone height; sizes, widths and girths per foot.

    Args:
        shoelasts: For left and right, of either side: the other one is the mirror image. They may be the same one.
        feet: Left and right.
        clearance: Name of a profile.
        settings: For both, or one for each.

    Raises:
        InputError: The lasts cannot become one pair of shoes.
    """
    each = (settings, settings) if isinstance(settings, CustomSettings) else settings
    check_pair(*shoelasts)
    given = [_of_side(one, foot.side) for one, foot in zip(shoelasts, feet, strict=True)]
    both = with_even_cones(given[0], given[1])
    raised = [
        float(new.points["cone_back"][2] - old.points["cone_back"][2]) for new, old in zip(both, given, strict=True)
    ]
    left, right = (
        customise(shoelast, foot, clearance, wishes) for shoelast, foot, wishes in zip(both, feet, each, strict=True)
    )
    return CustomPair(left, right, agreements(left.shoelast, right.shoelast), (raised[0], raised[1]))


def _of_side(shoelast: Shoelast, side: Side) -> Shoelast:
    name = shoelast.name.removesuffix("-left").removesuffix("-right")
    return replace(shoelast, side=side, name=f"{name} {side}")


def pair_ranking_json(pairs: Sequence[RankedPair]) -> dict[str, Any]:
    """What `lasts rank --other --json` prints: left and right in turn, the best pair first."""
    return {
        "ranking": [
            ranked_json(one) | {"pair_score": round(pair.score, 4), "alike": pair.alike}
            for pair in pairs
            for one in (pair.left, pair.right)
        ]
    }


def pair_json(pair: CustomPair) -> dict[str, Any]:
    """The content of pair.json: which lasts, and every property that a pair of shoes shares."""
    return {
        "format": PAIR_FORMAT,
        "lasts": {
            side: {"name": one.original.name, "size_eu": one.original.size_eu, "fitting": one.original.fitting}
            for side, one in pair.both
        },
        "style": pair.left.original.style,
        "cone_raised_mm": dict(zip(SIDES, pair.cone_raised_mm, strict=True)),
        "agreements": {
            name: {"left": one.left, "right": one.right, "unit": one.unit, "limit": one.limit, "kept": one.kept}
            for name, one in pair.agreements.items()
        },
        "holds": {side: one.proof.holds for side, one in pair.both},
    }


def save_pair(pair: CustomPair, folder: Path) -> None:
    """Write pair.json, and both lasts into the folders left and right, also when one does not hold its foot.

    Raises:
        StorageError: The folder cannot be written.
        QualityError: A last does not hold its foot.
    """
    (folder / PAIR_FILE).unlink(missing_ok=True)
    refused = [found for side, custom in pair.both if (found := _refusal(custom, folder / side)) is not None]
    write_whole(folder / PAIR_FILE, (json.dumps(pair_json(pair), indent=1) + "\n").encode())
    if refused:
        raise refused[0]


def _refusal(custom: CustomLast, folder: Path) -> QualityError | None:
    try:
        save_custom(custom, folder)
    except QualityError as err:
        return err
    return None
