"""A foot ready to be measured: aligned, cut at a stated height, with its landmarks."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats, Ints
from footscan.foot.align import Alignment, Front
from footscan.foot.clip import cut_below
from footscan.foot.sections import cut_shell
from footscan.foot.shell import Shell, moved
from footscan.foot.skin_origin import Origin

CUT_HEIGHT_SHARE = 0.52
"""Everything is measured on the skin below this share of the length (141 mm of 271): above the smallest ankle girth
(80 to 140 mm on adults), below the calf. A taller mesh is cut there first."""
VOLUME_HEIGHT_SHARE = 0.35
"""Volume and surface count up to this share of the length, so that scans with and without a leg compare."""
TOP_MARGIN_SHARE = 0.015
"""What is within this share of the length below the highest skin may be cut off: the rim of a cut can be ragged."""
TOES = ("toe_1", "toe_2", "toe_3", "toe_4", "toe_5")
PARTS: dict[str, tuple[str, ...]] = {
    **{toe: (toe,) for toe in TOES},
    "toes": TOES,
    "ray_1": ("toe_1", "mth_1"),
    "ray_5": ("toe_5", "mth_5"),
    "forefoot": (*TOES, "mth_1", "mth_5"),
}
"""What can be declared absent, and the anatomy that goes with it."""


@dataclass(frozen=True)
class StandingFoot:
    """The foot in its own frame.

    Attributes:
        shell: Skin in the foot frame, cut at `CUT_HEIGHT_SHARE`.
        alignment: Where it was found.
        length_mm: The length that search windows scale with: the foot's own, or, when the front is missing, at
        least what
            the heel breadth leads one to expect.
        top_mm: Height of the highest skin.
        uncut_xyz: `(n, 3)` the vertices before the cut, as the outline counts them.
        uncut_unseen: `(n,)` which of them were not seen: by a known origin, and at holes that were closed.
        given: Landmarks by hand, in the foot frame.
        absent: Missing anatomy, as in the values of `PARTS`.
        remarks: What a reader should know.
    """

    shell: Shell
    alignment: Alignment
    length_mm: float
    top_mm: float
    uncut_xyz: Floats
    uncut_unseen: Bools
    given: Mapping[str, Floats]
    absent: frozenset[str]
    remarks: tuple[str, ...]

    def across(self, share: float) -> Floats:
        """Crossing points `(n, 3)` of the skin with the plane across the axis at a share of the length."""
        normal = np.array([1.0, 0.0, 0.0])
        return cut_shell(self.shell, share * self.length_mm * normal, normal).xyz.reshape(-1, 3)

    def across_top(self) -> float:
        """Foremost x (mm) of the leg just below the highest skin."""
        below = np.array([0.0, 0.0, self.top_mm - 0.002 * self.length_mm])
        return float(cut_shell(self.shell, below, np.array([0.0, 0.0, 1.0])).xyz[:, :, 0].max())

    def shell_height_at(self, vertex: int) -> float:
        """Height (mm) of a vertex of the outline, which counts in the uncut shell."""
        return float(self.uncut_xyz[vertex, 2])


def absent_parts(declared: tuple[str, ...]) -> frozenset[str]:
    """The missing anatomy behind some declared names; names that are not in `PARTS` add nothing."""
    return frozenset(part for name in declared for part in PARTS.get(name, ()))


def front_of(absent: frozenset[str]) -> Front | None:
    """What is left of the front after what was declared absent; None leaves it to the shape."""
    if {"mth_1", "mth_5"} <= absent:
        return "ball missing"
    if absent >= set(TOES):
        return "toes missing"
    return "whole" if absent else None


def stand(
    shell: Shell,
    alignment: Alignment,
    given: Mapping[str, Floats],
    declared: tuple[str, ...],
    bridged: Ints | None = None,
) -> StandingFoot:
    """Bring an aligned foot into its frame, cut it, and see what of it is missing.

    Args:
        shell: The repaired skin.
        alignment: Of it.
        given: Landmarks by hand, in the input's coordinates.
        declared: Parts said to be absent.
        bridged: Vertices at holes that were closed.
    """
    upright = moved(shell, alignment.foot_from_input)
    absent = absent_parts(declared)
    remarks = [f"declared absent: {name!r}, which switches nothing off" for name in declared if name not in PARTS]
    if alignment.front == "ball missing" and not absent:
        absent = frozenset(PARTS["forefoot"])
    cut = cut_below(upright, CUT_HEIGHT_SHARE * alignment.reference_mm)
    top = float(cut.xyz[:, 2].max())
    if cut is not upright:
        remarks.append(f"the leg was cut off at {top:.0f} mm ({CUT_HEIGHT_SHARE:.0%} of the length)")
    hands = {name: _in_frame(alignment, xyz) for name, xyz in given.items()}
    unseen = _unseen(shell, bridged)
    return StandingFoot(cut, alignment, alignment.reference_mm, top, upright.xyz, unseen, hands, absent, tuple(remarks))


def _unseen(shell: Shell, bridged: Ints | None) -> Bools:
    unseen = np.zeros(len(shell.xyz), dtype=np.bool_) if shell.origin is None else shell.origin != Origin.SEEN
    if bridged is not None:
        unseen[bridged] = True
    return unseen


def _in_frame(alignment: Alignment, xyz: Floats) -> Floats:
    transform = alignment.foot_from_input
    return transform[:3, :3] @ np.asarray(xyz, dtype=np.float64) + transform[:3, 3]
