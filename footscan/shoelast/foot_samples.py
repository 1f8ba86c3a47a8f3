"""Places of a foot's skin, evenly spread and the same every time: what comparing, fitting and proving look at."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats, Ints
from footscan.foot.shell import Shell, area_mm2
from footscan.foot.skin_origin import Origin
from footscan.shoelast.foot_pose import PosedFoot

_R2 = np.array([0.7548776662466927, 0.5698402909980532])
"""Steps of a sequence that fills the unit square evenly (Roberts' R2)."""


@dataclass(frozen=True)
class FootSamples:
    """Places of skin, in the last's frame and on the flat foot.

    Attributes:
        xyz: `(n, 3)` in the last's frame.
        normal_foot: `(n, 3)` outward unit normals on the flat foot.
        place: `(n,)` along the foot: 0 at the back, 1 at the line between the metatarsal heads.
        face: `(n,)` faces of the foot's shell.
        weight: `(n, 3)` barycentric weights there.
        seen: `(n,)` whether the skin was seen.
        bridged: `(n,)` whether it was not, but lies between seen skin (no assumed sole, no cut).
    """

    xyz: Floats
    normal_foot: Floats
    place: Floats
    face: Ints
    weight: Floats
    seen: Bools
    bridged: Bools

    def of(self, mask: Bools) -> "FootSamples":
        """Some of them."""
        return FootSamples(
            self.xyz[mask],
            self.normal_foot[mask],
            self.place[mask],
            self.face[mask],
            self.weight[mask],
            self.seen[mask],
            self.bridged[mask],
        )

    def moved(self, shell: Shell) -> "FootSamples":
        """The same places of the same foot lying elsewhere."""
        xyz = np.einsum("nk,nkc->nc", self.weight, shell.xyz[shell.faces[self.face]])
        return FootSamples(xyz, self.normal_foot, self.place, self.face, self.weight, self.seen, self.bridged)


def sample_foot(
    posed: PosedFoot, count: int, highest_mm: float = np.inf, unseen_share: float = 1.0, faces: Bools | None = None
) -> FootSamples:
    """Spread places over a foot by area.

    Args:
        posed: The foot.
        count: About how many.
        highest_mm: Faces of the flat foot above this height get none.
        unseen_share: How densely skin that was not seen is sampled beside seen skin.
        faces: `(m,)` faces that get samples; None for all.
    """
    flat = posed.foot.shell
    area = area_mm2(flat) * (flat.xyz[flat.faces][:, :, 2].min(axis=1) < highest_mm)
    area *= np.where(posed.foot.face_seen, 1.0, unseen_share)
    area *= 1.0 if faces is None else faces
    total = np.cumsum(area)
    face = np.searchsorted(total, (np.arange(count) + 0.5) / count * total[-1])
    first, second = np.modf(np.outer(_R2, np.arange(1, count + 1)))[0]
    over = first + second > 1.0
    first, second = np.where(over, 1.0 - first, first), np.where(over, 1.0 - second, second)
    weight = np.column_stack([1.0 - first - second, first, second])
    corner = flat.xyz[flat.faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    xyz_foot = np.einsum("nk,nkc->nc", weight, corner[face])
    xyz = np.einsum("nk,nkc->nc", weight, posed.shell.xyz[posed.shell.faces[face]])
    seen = posed.foot.face_seen[face]
    bridged = ~seen & _between_seen(flat)[face]
    return FootSamples(xyz, normal[face], place_along(posed, xyz_foot), face, weight, seen, bridged)


def _between_seen(shell: Shell) -> Bools:
    """`(m,)` faces whose corners were all seen or bridged; none when nobody said where the skin comes from."""
    if shell.origin is None:
        return np.zeros(len(shell.faces), dtype=np.bool_)
    return np.asarray((shell.origin[shell.faces] <= Origin.BRIDGED).all(axis=1), dtype=np.bool_)


def place_along(posed: PosedFoot, xyz_foot: Floats) -> Floats:
    """Places `(n,)` along the foot: 0 at the back, 1 at the line between the metatarsal heads."""
    medial, lateral = (posed.foot.points[name] for name in ("metatarsale_tibiale", "metatarsale_fibulare"))
    share = np.clip((xyz_foot[:, 1] - lateral[1]) / max(float(medial[1] - lateral[1]), 1.0), -0.2, 1.2)
    return xyz_foot[:, 0] / (lateral[0] + share * (medial[0] - lateral[0]))
