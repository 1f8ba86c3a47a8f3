"""Fitting profiles: how much room a foot gets, by region and aspect. All numbers are in profiles.json, indicative."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from footscan.coordinates import Floats, Ints
from footscan.errors import InputError
from footscan.foot.sole_bend import smooth_step
from footscan.shoelast.fitting_defaults import profile_data

Region = Literal["heel", "instep", "waist", "ball", "toe"]
REGIONS: tuple[Region, ...] = get_args(Region)
HOLDING: tuple[Region, ...] = ("heel", "instep", "waist")
"""Regions that may lose material; ball and toes never do."""

_TOP_SLOPE = (0.25, 0.85)
"""Skin whose normal points up by less than the first is side, by more than the second is top."""
_BACK_SLOPE = (0.5, 0.9)
_LOOSE_MM = 10.0


@dataclass(frozen=True)
class Profile:
    """Room by region. Pairs are the least and the most clearance in mm; the least may be negative.

    Attributes:
        name: therapeutic, comfort or dress.
        side_mm: Region -> pair on the sides.
        top_mm: Region -> pair on the dorsum.
        heel_back_mm: Pair behind the heel.
        toe_room_mm: Pair of room in front of the longest toe.
        most_loss_mm: Holding region -> most material the last may lose.
        most_overhang_mm: How far a side may stand out over the feather edge before the bottom is widened.
        bands: Dimension of the last less that of the foot -> pair, for ranking.
    """

    name: str
    side_mm: Mapping[str, tuple[float, float]]
    top_mm: Mapping[str, tuple[float, float]]
    heel_back_mm: tuple[float, float]
    toe_room_mm: tuple[float, float]
    most_loss_mm: Mapping[str, float]
    most_overhang_mm: float
    bands: Mapping[str, tuple[float, float]]


def load_profile(name: str) -> Profile:
    """A profile by its name.

    Raises:
        InputError: There is none of that name.
    """
    known = profile_data()["profiles"]
    if name not in known:
        raise InputError(f"profile {name!r}: not known; allowed are {', '.join(known)}.")
    entry = known[name]
    return Profile(
        name=name,
        side_mm=_pairs(entry["side_mm"]),
        top_mm=_pairs(entry["top_mm"]),
        heel_back_mm=tuple(entry["heel_back_mm"]),
        toe_room_mm=tuple(entry["toe_room_mm"]),
        most_loss_mm=entry["most_loss_mm"],
        most_overhang_mm=float(entry["most_overhang_mm"]),
        bands=_pairs(entry["bands"]),
    )


def uniform_profile(clearance_mm: float) -> Profile:
    """One least clearance for all skin, without holding; ranges for ranking as in the therapeutic profile."""
    base = load_profile("therapeutic")
    pair = dict.fromkeys(REGIONS, (clearance_mm, clearance_mm + _LOOSE_MM))
    back = (clearance_mm, clearance_mm + _LOOSE_MM)
    return replace(base, name=f"{clearance_mm:g} mm", side_mm=pair, top_mm=pair, heel_back_mm=back, most_loss_mm={})


def _pairs(table: Mapping[str, list[float]]) -> dict[str, tuple[float, float]]:
    return {name: (float(pair[0]), float(pair[1])) for name, pair in table.items()}


def region_of(place: Floats) -> Ints:
    """Number `(n,)` in `REGIONS` of places along the foot (1 at the line between the metatarsal heads)."""
    return np.searchsorted(np.array(profile_data()["region_ends"]), place).astype(np.int64)


def room_mm(profile: Profile, place: Floats, normal_foot: Floats) -> tuple[Floats, Floats]:
    """Least and most clearance `(n,)` of skin, going over smoothly from region to region and from side to top.

    Args:
        profile: The numbers.
        place: `(n,)` along the foot, 1 at the line between the metatarsal heads.
        normal_foot: `(n, 3)` outward unit normals of the flat foot.
    """
    centres = np.array(profile_data()["region_centres"])
    top = smooth_step((normal_foot[:, 2] - _TOP_SLOPE[0]) / (_TOP_SLOPE[1] - _TOP_SLOPE[0]))
    back = smooth_step((-normal_foot[:, 0] - _BACK_SLOPE[0]) / (_BACK_SLOPE[1] - _BACK_SLOPE[0])) * (place < centres[0])
    rooms: list[Floats] = []
    for k in range(2):
        side = np.interp(place, centres, [profile.side_mm[name][k] for name in REGIONS])
        dorsal = np.interp(place, centres, [profile.top_mm[name][k] for name in REGIONS])
        room = (1.0 - top) * side + top * dorsal
        rooms.append((1.0 - back) * room + back * profile.heel_back_mm[k])
    return rooms[0], rooms[1]


def most_loss_mm(profile: Profile, place: Floats) -> Floats:
    """Most material `(n,)` the last may lose beside places along the foot, fading to nothing before the ball."""
    centres = np.array(profile_data()["region_centres"])
    losses = np.array([profile.most_loss_mm.get(name, 0.0) for name in REGIONS])
    return np.interp(place, centres, losses) * (1.0 - smooth_step((place - centres[2]) / (centres[3] - centres[2])))
