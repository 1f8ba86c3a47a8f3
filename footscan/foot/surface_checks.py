"""Is this cloud one foot that can be fitted? Everything that is not is refused with what was found."""

from typing import cast

import numpy as np
from scipy.ndimage import label

from footscan.coordinates import WORKING_RADIUS_MM, Bools, Floats, Ints
from footscan.errors import EmptyScanError, MeshError
from footscan.foot.surface_chart import principal_box
from footscan.foot.units import FOOT_LENGTH_MM

FEWEST_POINTS = 1500
_BORDER_MM = 2.0
_BORDER_POINTS = 20
_VOXEL_MM = 10.0
_SECOND_OBJECT = 0.04  # of the points: a smaller separate cluster is a stray and left out
_LEAST_BREADTH = 0.2  # of the length
_SPHERE_RESIDUAL = 0.03  # of the radius
_LEAST_HEIGHT = 0.1  # of the length: a plantar scan is lower


def check_arrays(xyz_world: Floats, weight: Floats, laser: Ints) -> None:
    """Check shapes, numbers and amount of a cloud.

    Raises:
        ValueError: The arrays do not belong together.
        EmptyScanError: Too few points.
        MeshError: NaN or infinite values.
    """
    count = len(xyz_world)
    if xyz_world.shape != (count, 3) or weight.shape != (count,) or laser.shape != (count,):
        raise ValueError(f"a cloud needs (n, 3), (n,) and (n,), found {xyz_world.shape}, {weight.shape}, {laser.shape}")
    if count < FEWEST_POINTS:
        raise EmptyScanError(
            f"only {count} points of skin were found, a foot needs at least {FEWEST_POINTS}; "
            "check lasers and threshold and scan again"
        )
    bad = int(count - (np.isfinite(xyz_world).all(axis=1) & np.isfinite(weight) & (weight >= 0.0)).sum())
    if bad:
        raise MeshError(
            f"{bad} of {count} points have a place that is no number or a negative weight; all must be finite, "
            "process the recording again"
        )


def check_border(xyz_world: Floats) -> None:
    """Refuse a foot that reaches out of the working volume.

    Raises:
        MeshError: Points lie at its border, saying where.
    """
    radius = np.hypot(xyz_world[:, 0], xyz_world[:, 1])
    outside = radius > WORKING_RADIUS_MM - _BORDER_MM
    if int(outside.sum()) < _BORDER_POINTS:
        return
    x, y, z = np.median(xyz_world[outside], axis=0)
    raise MeshError(
        f"{int(outside.sum())} points end at the border of the view, {WORKING_RADIUS_MM:.0f} mm from the axis (around "
        f"x = {x:.0f}, y = {y:.0f}, z = {z:.0f} mm): the foot is partly outside; "
        "move it to the middle of the board and scan again"
    )


def main_object(xyz_world: Floats) -> Bools:
    """Which points belong to the one object; small separate strays do not.

    Args:
        xyz_world: `(n, 3)` points.

    Raises:
        MeshError: A second object of some size stands apart.
    """
    cell = np.floor((xyz_world - xyz_world.min(axis=0)) / _VOXEL_MM).astype(np.int64)
    space = np.zeros(cell.max(axis=0) + 1, bool)
    space[cell[:, 0], cell[:, 1], cell[:, 2]] = True
    names, count = cast("tuple[Ints, int]", label(space, np.ones((3, 3, 3))))
    which = names[cell[:, 0], cell[:, 1], cell[:, 2]]
    sizes = np.bincount(which, minlength=count + 1)
    order = np.argsort(sizes)[::-1]
    if count > 1 and sizes[order[1]] > _SECOND_OBJECT * len(xyz_world):
        places = [xyz_world[which == k].mean(axis=0) for k in order[:2]]
        raise MeshError(
            f"{int((sizes > _SECOND_OBJECT * len(xyz_world)).sum())} objects stand apart, around "
            f"({places[0][0]:.0f}, {places[0][1]:.0f}) and ({places[1][0]:.0f}, {places[1][1]:.0f}) mm: "
            "one foot at a time can be measured; remove the other and scan again"
        )
    return which == order[0]


def check_shape(xyz_world: Floats) -> float:
    """Refuse what cannot be a foot by its size or because it is a ball; return its length (mm).

    Raises:
        MeshError: Saying what was found.
    """
    _, (breadth, length) = principal_box(xyz_world[:, :2])
    height = float(np.percentile(xyz_world[:, 2], 99.5))
    if not FOOT_LENGTH_MM[0] <= length <= FOOT_LENGTH_MM[1]:
        raise MeshError(
            f"the object is {length:.0f} mm long, a foot has {FOOT_LENGTH_MM[0]:.0f} to {FOOT_LENGTH_MM[1]:.0f} mm; "
            "check that the lengths are in millimetres and that only a foot stands on the board"
        )
    if breadth < _LEAST_BREADTH * length:
        raise MeshError(
            f"the object is {length:.0f} mm long and only {breadth:.0f} mm wide, which is no foot; scan again"
        )
    if height < _LEAST_HEIGHT * length:
        raise MeshError(
            f"the skin is seen only up to {height:.0f} mm above the board, a foot of {length:.0f} mm reaches higher: "
            "this looks like a plantar scan; scan the foot from outside"
        )
    _refuse_ball(xyz_world)
    return length


def _refuse_ball(xyz_world: Floats) -> None:
    some = xyz_world[:: max(1, len(xyz_world) // 5000)]
    middle = some.mean(axis=0)
    equations = np.column_stack([2.0 * (some - middle), np.ones(len(some))])
    solved = np.linalg.lstsq(equations, ((some - middle) ** 2).sum(axis=1), rcond=None)[0]
    centre, radius = middle + solved[:3], float(np.sqrt(max(solved[3] + (solved[:3] ** 2).sum(), 1e-9)))
    residual = np.linalg.norm(some - centre, axis=1) - radius
    if float(np.sqrt((residual**2).mean())) < _SPHERE_RESIDUAL * radius:
        raise MeshError(f"the object is a ball of {2.0 * radius:.0f} mm diameter, not a foot; put a foot on the board")
