"""A foot ready to be measured: aligned, cut at a stated height, with its landmarks."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.foot.align import HEEL_BREADTH_SHARE, Alignment
from footscan.foot.clip import cut_below
from footscan.foot.outline import side_at
from footscan.foot.sections import cut_shell
from footscan.foot.shell import Shell, moved

CUT_HEIGHT_SHARE = 0.52
"""Everything is measured on the skin below this share of the length (141 mm of 271): above the smallest ankle girth
(80 to 140 mm on adults), below the calf. A taller mesh is cut there first."""
VOLUME_HEIGHT_SHARE = 0.35
"""Volume and surface count up to this share of the length, so that scans with and without a leg compare."""
STUMP_SHARE = 0.17
"""Dorsum height at 90 % of the length, over the length, from which the front is a stump (toes: 0.08 to 0.12)."""
HEEL_BREADTHS_PER_LENGTH = 3.7
"""Foot length over heel breadth (ANSUR II: 3.74 men, 3.67 women), for feet whose front is missing."""

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
        uncut_z: Heights of the vertices before the cut, as the outline counts them.
        given: Landmarks by hand, in the foot frame.
        absent: Missing anatomy, as in the values of `PARTS`.
        remarks: What a reader should know.
    """

    shell: Shell
    alignment: Alignment
    length_mm: float
    top_mm: float
    uncut_z: Floats
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
        return float(self.uncut_z[vertex])


def stand(shell: Shell, alignment: Alignment, given: Mapping[str, Floats], declared: tuple[str, ...]) -> StandingFoot:
    """Bring an aligned foot into its frame, cut it, and see what of it is missing."""
    upright = moved(shell, alignment.foot_from_input)
    unknown = [name for name in declared if name not in PARTS]
    remarks = [f"declared absent: {name!r}, which switches no measurement off" for name in unknown]
    absent = frozenset(part for name in declared for part in PARTS.get(name, ()))
    length = alignment.length_mm
    if _is_stump(upright, length):
        if not absent:
            remarks.append("the front looks like a closed stump: what needs toes or the ball is not applicable")
            absent = frozenset(PARTS["forefoot"])
        length = max(length, HEEL_BREADTHS_PER_LENGTH * _heel_breadth(alignment))
    cut = cut_below(upright, CUT_HEIGHT_SHARE * length)
    top = float(cut.xyz[:, 2].max())
    if cut is not upright:
        remarks.append(f"the leg was cut off at {top:.0f} mm ({CUT_HEIGHT_SHARE:.0%} of the length)")
    hands = {name: _in_frame(alignment, xyz) for name, xyz in given.items()}
    return StandingFoot(cut, alignment, length, top, upright.xyz[:, 2], hands, absent, tuple(remarks))


def _in_frame(alignment: Alignment, xyz: Floats) -> Floats:
    transform = alignment.foot_from_input
    return transform[:3, :3] @ np.asarray(xyz, dtype=np.float64) + transform[:3, 3]


def _is_stump(upright: Shell, length_mm: float) -> bool:
    across = np.array([1.0, 0.0, 0.0])
    xyz = cut_shell(upright, 0.9 * length_mm * across, across).xyz.reshape(-1, 3)
    return len(xyz) > 0 and float(xyz[:, 2].max()) > STUMP_SHARE * length_mm


def _heel_breadth(alignment: Alignment) -> float:
    """Breadth (mm) of the outline at the share of the length that it itself leads one to expect."""
    length = alignment.length_mm
    for _ in range(8):
        x = np.array([HEEL_BREADTH_SHARE * length])
        xy = alignment.outline.xy
        length = HEEL_BREADTHS_PER_LENGTH * float(side_at(xy, x, 1.0)[0] - side_at(xy, x, -1.0)[0])
    return length / HEEL_BREADTHS_PER_LENGTH
