"""Between which bounds volume and surface lie, given that nobody saw the sole.

Least: below the lowest seen skin there is nothing, the sole runs straight across at the height of that skin. Most: a
vertical wall goes from it down to the board. These are the bounds that tape girths have. The true sole, arch and all,
lies between; the value itself is that of the assumed, flat sole, and a vaulted arch makes the foot smaller than it.
"""

import numpy as np
from scipy.spatial import KDTree

from footscan.coordinates import Bools, Floats, Ints
from footscan.foot.shell import Shell, area_mm2, volume_mm3
from footscan.foot.skin_origin import Origin

TRUST_MM = 0.05
"""How far seen skin may lie off on average: both bounds of a volume are moved out by this over the seen skin."""
BRIDGE_MM = 0.5
"""The same for bridged skin."""
AREA_SHARE = 0.003
"""Both bounds of a surface are moved out by this share: facets cut small bends short."""


def volume_interval_mm3(shell: Shell, top_mm: float, value_mm3: float) -> tuple[float, float]:
    """Least and most volume of a foot that stands on z = 0.

    Args:
        shell: In the foot frame, open at the top.
        top_mm: Height of the opening.
        value_mm3: Its volume with the assumed sole.
    """
    area, assumed = area_mm2(shell), _assumed_faces(shell)
    bridged = _bridged_faces(shell) & ~assumed
    margin = TRUST_MM * float(area[~assumed & ~bridged].sum()) + BRIDGE_MM * float(area[bridged].sum())
    apex = np.array([0.0, 0.0, top_mm])
    low = min(volume_mm3(_lifted(shell), apex), value_mm3)
    return low - margin, value_mm3 + _below_walls_mm3(shell, assumed) + margin


def area_interval_mm2(shell: Shell, value_mm2: float) -> tuple[float, float]:
    """Least and most surface of a foot that stands on z = 0, sole included.

    Args:
        shell: In the foot frame, open at the top.
        value_mm2: Its surface with the assumed sole.
    """
    assumed = _assumed_faces(shell)
    edge = assumed & (shell.xyz[shell.faces][:, :, 2].max(axis=1) > 1e-6)
    area = area_mm2(shell)
    across = abs(float(_shadow_mm2(shell, assumed).sum()))
    low = value_mm2 - float(area[assumed].sum()) + across
    beside = max(-float(_shadow_mm2(shell, edge).sum()), 0.0)
    high = value_mm2 - float(area[edge].sum()) + beside + _walls_mm2(shell)
    return min(low, value_mm2) * (1.0 - AREA_SHARE), max(high, value_mm2) * (1.0 + AREA_SHARE)


def _assumed(shell: Shell) -> Bools:
    """`(n,)` vertices of the assumed sole; without a known origin those too low to be seen."""
    if shell.origin is None:
        return ~shell.seen
    return np.asarray(shell.origin == Origin.ASSUMED_SOLE, dtype=np.bool_)


def _assumed_faces(shell: Shell) -> Bools:
    return np.asarray(_assumed(shell)[shell.faces].any(axis=1), dtype=np.bool_)


def _bridged_faces(shell: Shell) -> Bools:
    if shell.origin is None:
        return np.zeros(len(shell.faces), dtype=np.bool_)
    bridged = np.asarray(shell.origin == Origin.BRIDGED, dtype=np.bool_)
    return np.asarray(bridged[shell.faces].any(axis=1), dtype=np.bool_)


def _rim_edges(shell: Shell) -> Ints:
    """Edges `(k, 2)` of the lowest skin that is not assumed: those that face a single assumed vertex."""
    low = _assumed(shell)[shell.faces]
    beside = low.sum(axis=1) == 1
    alone, rows = low[beside].argmax(axis=1), np.arange(int(beside.sum()))
    faces = shell.faces[beside]
    return np.stack([faces[rows, (alone + 1) % 3], faces[rows, (alone + 2) % 3]], axis=1)


def _lifted(shell: Shell) -> Shell:
    """The shell with its assumed skin lifted to the height of the nearest lowest skin that is not assumed."""
    rim = np.unique(_rim_edges(shell))
    low = _assumed(shell)
    if len(rim) == 0 or not low.any():
        return shell
    xyz = shell.xyz.copy()
    nearest = KDTree(xyz[rim, :2]).query(xyz[low, :2])[1]
    xyz[low, 2] = np.maximum(xyz[low, 2], shell.xyz[rim[nearest], 2])
    return Shell(xyz, shell.faces, shell.origin)


def _shadow_mm2(shell: Shell, which: Bools) -> Floats:
    """Signed areas of faces seen from above; negative where they face the board."""
    a, b, c = (shell.xyz[shell.faces[which, k], :2] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def _below_walls_mm3(shell: Shell, assumed: Bools) -> float:
    """Room between the assumed skin that leans inwards and the board."""
    height = shell.xyz[shell.faces[assumed]][:, :, 2].mean(axis=1)
    return float((np.maximum(-_shadow_mm2(shell, assumed), 0.0) * height).sum())


def _walls_mm2(shell: Shell) -> float:
    """Area of vertical walls below the lowest skin that is not assumed."""
    ends = shell.xyz[_rim_edges(shell)]
    return float((np.linalg.norm(ends[:, 1, :2] - ends[:, 0, :2], axis=1) * ends[:, :, 2].mean(axis=1)).sum())
