"""Which lasts suit a foot, by dimensions alone: bands per dimension, heel-to-ball and ball girth before length.

Every dimension of a last is compared with the foot's. Inside the profile's band a deviation from its middle costs
little, outside it costs its full weight per millimetre. The parts of a score are shown. A lower score is better.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Bools, Floats, Side
from footscan.errors import InputError
from footscan.shoelast.fitting_defaults import profile_data
from footscan.shoelast.last_library import LastEntry
from footscan.shoelast.pitch_of_scan import pitch_reason
from footscan.shoelast.prepared_foot import PreparedFoot
from footscan.shoelast.profile import Profile, load_profile
from footscan.shoelast.refusals import SIZE_RULE_ROOM_MM

WRONG_SIDE, WRONG_WIDTH, MIRRORED = 1000.0, 2000.0, 4000.0
"""Added to the score: a last of the wrong side can be mirrored exactly, one of the wrong width cannot be mended; one of
the wrong side whose mirror image is in the list as well is of no use at all."""
WRONG_PITCH = 1500.0
"""Added to the score of a last whose pitch is too far from what the foot was scanned on."""
_INSIDE = 0.2
"""Cost of a millimetre inside the band, as a share of one outside."""
FROM_FOOT = {
    "ball_length": ("ball_length", "ball_length"),
    "ball_girth": ("ball_girth", "ball_girth"),
    "length_room": ("stick_length", "foot_length"),
    "instep_girth": ("instep_girth", "instep_girth"),
    "waist_girth": ("waist_girth", "waist_girth"),
    "heel_width": ("heel_width", "heel_breadth"),
    "ball_width": ("ball_width", "foot_breadth"),
    "toe_box_height": ("toe_box_height", "toe_height"),
}
"""Part of the score -> dimension of the last, measurement of the foot."""
OTHER: Mapping[Side, Side] = {"left": "right", "right": "left"}
NEEDED_PARTS = ("ball_length", "ball_girth", "length_room")


@dataclass(frozen=True)
class Ranked:
    """A last's place in a ranking.

    Attributes:
        entry: The last.
        score: Sum of the parts; lower is better.
        parts: Part -> its share of the score.
        differences_mm: Part -> dimension of the last less that of the foot.
        reason: Why it cannot be taken, empty when it can.
    """

    entry: LastEntry
    score: float
    parts: Mapping[str, float]
    differences_mm: Mapping[str, float]
    reason: str = ""


def rank(entries: Sequence[LastEntry], foot: PreparedFoot, profile: Profile | str = "therapeutic") -> list[Ranked]:
    """All lasts, best first; those of the wrong side come last.

    Raises:
        InputError: No lasts, or an unknown profile.
        MeshError: The foot has no ball or no length.
    """
    if not entries:
        raise InputError("the library holds no lasts; add one with `footscan lasts add`.")
    wanted = load_profile(profile) if isinstance(profile, str) else profile
    ranked = rank_by_values(entries, foot_values(foot), foot.side, wanted)
    return sorted((_with_pitch(one, foot) for one in ranked), key=lambda one: one.score)


def _with_pitch(one: Ranked, foot: PreparedFoot) -> Ranked:
    """A last whose pitch the scan may not be bent to comes after all that it may, mirrored or not."""
    reason = "" if one.entry.pitch_mm is None else pitch_reason(foot, one.entry.pitch_mm)
    if not reason:
        return one
    return replace(
        one, score=one.score + WRONG_PITCH, reason="; ".join([part for part in (one.reason, reason) if part])
    )


def foot_values(foot: PreparedFoot) -> dict[str, float]:
    """The foot's measurements that take part, name -> mm; those it does not give are left out.

    Raises:
        MeshError: One is missing that ranking cannot do without.
    """
    values = {foot_name: foot.value(foot_name) for foot_name in (FROM_FOOT[part][1] for part in NEEDED_PARTS)}
    for _, foot_name in FROM_FOOT.values():
        found = foot.measurements[foot_name].value
        if found is not None:
            values[foot_name] = found
    return values


def rank_by_values(
    entries: Sequence[LastEntry], values: Mapping[str, float], side: Side, profile: Profile
) -> list[Ranked]:
    """Rank by a foot's measurements, name -> mm."""
    weights = profile_data()["weights_per_mm"]
    parts = [part for part, (_, foot_name) in FROM_FOOT.items() if foot_name in values]
    table = np.array([[entry.dimensions[FROM_FOOT[part][0]] for part in parts] for entry in entries])
    differences = table - np.array([values[FROM_FOOT[part][1]] for part in parts])
    bands = np.array([profile.bands[f"{part}_mm"] for part in parts])
    costs = _costs(differences, bands) * np.array([weights[part] for part in parts])
    wrong = np.array([entry.side != side for entry in entries])
    mirrored = wrong & _has_mirror_image(entries)
    fuller = _fuller_mm(differences, parts, bands)
    size = _size_costs(entries, values["foot_length"])
    width = np.abs(fuller) > _most_fuller_mm(np.abs(fuller[(size == 0.0) & ~wrong]))
    scores = costs.sum(axis=1) + size + WRONG_SIDE * wrong + WRONG_WIDTH * width + MIRRORED * mirrored
    return [
        Ranked(
            entries[k],
            float(scores[k]),
            {part: float(cost) for part, cost in zip(parts, costs[k], strict=True)} | {"size_eu": float(size[k])},
            {part: float(difference) for part, difference in zip(parts, differences[k], strict=True)},
            _reason(entries[k].side, side, wrong=bool(wrong[k]), fuller_mm=float(fuller[k]) if width[k] else 0.0),
        )
        for k in np.argsort(scores, kind="stable")
    ]


def _has_mirror_image(entries: Sequence[LastEntry]) -> Bools:
    """Which lasts have a last of the other side with the same dimensions beside them."""
    shapes = [tuple(round(value, 1) for value in entry.dimensions.values()) for entry in entries]
    of_side = {side: {s for s, entry in zip(shapes, entries, strict=True) if entry.side == side} for side in OTHER}
    return np.array([s in of_side[OTHER[entry.side]] for s, entry in zip(shapes, entries, strict=True)])


def _most_fuller_mm(of_the_size_mm: Floats) -> float:
    """From where on a last has the wrong width: never so little that no last of the foot's size is left."""
    rule = profile_data()["width_rule"]
    least = float(of_the_size_mm.min()) if len(of_the_size_mm) else 0.0
    return max(rule["most_off_mm"], least + rule["beyond_best_mm"])


def _size_costs(entries: Sequence[LastEntry], foot_length_mm: float) -> Floats:
    """Cost `(n,)` of a size beside the size rule's; a last whose size nobody said costs nothing."""
    rule = profile_data()["size_rule"]
    wanted = rule["per_mm"] * foot_length_mm + rule["offset"]
    off = np.array([0.0 if entry.size_eu is None else abs(entry.size_eu - wanted) for entry in entries])
    return rule["per_size"] * np.maximum(off - rule["free"], 0.0)


def _fuller_mm(differences: Floats, parts: list[str], bands: Floats) -> Floats:
    """How much wider `(n,)` lasts are for their own length than the foot for its: a width fitting is 5 to 7 mm."""
    girth, length = parts.index("ball_girth"), parts.index("length_room")
    longer = differences[:, length] - SIZE_RULE_ROOM_MM
    per_mm = profile_data()["width_rule"]["girth_per_length_mm"]
    return differences[:, girth] - bands[girth].mean() - per_mm * longer


def _reason(last_side: Side, side: Side, *, wrong: bool, fuller_mm: float) -> str:
    reasons = [f"a {last_side} last, the foot is a {side} one"] if wrong else []
    if fuller_mm:
        word = "wide" if fuller_mm > 0.0 else "narrow"
        reasons.append(f"{abs(fuller_mm):.0f} mm too {word} at the ball for its length: about two widths off")
    return "; ".join(reasons)


def _costs(differences: Floats, bands: Floats) -> Floats:
    """Millimetres `(n, k)` outside the bands `(k, 2)`, and a share of those off their middles."""
    middle, half = bands.mean(axis=1), 0.5 * np.ptp(bands, axis=1)
    off = np.abs(differences - middle)
    return np.maximum(off - half, 0.0) + _INSIDE * off
