"""Is the board what board.toml says, the same in every placement, and flat?"""

from dataclasses import dataclass

import numpy as np

from footscan.calibration.charuco import half_size_mm
from footscan.calibration.estimate import POSE, SHAPE
from footscan.calibration.gate import Gate
from footscan.calibration.intake import Intake
from footscan.calibration.joint import CORNERS_ONLY
from footscan.calibration.sightings import NO_STRIPES, Sightings
from footscan.calibration.solve import Fit, fit_estimate
from footscan.calibration.unknowns import Unknowns
from footscan.coordinates import Floats

MOST_UNEQUAL = 4e-4
MOST_SCALED = 6e-4
MOST_SAG_MM = 0.15
_SURE = 5.0


@dataclass(frozen=True)
class BoardShape:
    """What the pictures say about the print and flatness of the board, and what of it may be chance.

    Attributes:
        unequal: Height over width of the print, relative to what board.toml says, minus one; mean of all placements.
        surely_unequal: Below this a difference may be chance.
        scaled: `(p,)` size of the board in each placement relative to the mean of all, minus one.
        surely_scaled: `(p,)` below this it may be chance.
        sag_mm: `(p,)` largest departure from flatness over the board.
        surely_bent_mm: `(p,)` below this it may be chance.
    """

    unequal: float
    surely_unequal: float
    scaled: Floats
    surely_scaled: Floats
    sag_mm: Floats
    surely_bent_mm: Floats


def board_shape(intake: Intake, corners_fit: Fit) -> BoardShape:
    """Estimate stretch and bend of the board of every placement, beside everything that corners show."""
    return shape_of(freed_shape(intake, corners_fit), intake)


def freed_shape(intake: Intake, corners_fit: Fit) -> Fit:
    """The corners-only fit with stretch and bend of every board free."""
    sightings = Sightings(intake.times, intake.corners, NO_STRIPES, intake.placement_names)
    return fit_estimate(corners_fit.estimate, sightings, Unknowns(CORNERS_ONLY.machine, POSE + SHAPE))


def shape_of(free: Fit, intake: Intake) -> BoardShape:
    """What a fit with free boards says about them."""
    stretch = free.estimate.doubts[:, :2]
    half_x, half_y = half_size_mm(intake.board)
    reach = {"bend_xx_per_mm": half_x**2, "bend_yy_per_mm": half_y**2, "bend_xy_per_mm": half_x * half_y}
    bend = np.abs(free.estimate.doubts[:, 2:5] * np.array(list(reach.values())))
    doubt = np.stack([_deviations(free, {name: size}) for name, size in reach.items()], axis=-1)
    worst = np.argmax(bend, axis=1)
    each = np.arange(len(bend))
    size = stretch.mean(axis=1)
    difference = _deviations(free, {"stretch_x": 1.0, "stretch_y": -1.0})
    return BoardShape(
        float(np.median(stretch[:, 1] - stretch[:, 0])),
        _SURE * float(np.median(difference)) / float(np.sqrt(len(stretch))),
        size - np.median(size),
        _SURE * _deviations(free, {"stretch_x": 0.5, "stretch_y": 0.5}, against_others=True),
        bend[each, worst],
        _SURE * doubt[each, worst],
    )


def _deviations(fit: Fit, sum_of: dict[str, float], against_others: bool = False) -> Floats:
    """Standard deviation `(p,)` of a weighted sum of each board's doubts, or of what it is off the mean of the boards'.

    The size of all boards together cannot be seen; only differences between placements can.
    """
    names, spread, placements = fit.unknowns.names(fit.estimate.placements), fit.spread(), fit.estimate.placements
    row = np.zeros((placements, len(names)))
    for p in range(placements):
        for name, share in sum_of.items():
            row[p, names.index(f"{name}[{p}]")] = share
    row = row - row.mean(axis=0) if against_others else row
    return np.sqrt(np.maximum(np.einsum("pi,ij,pj->p", row, spread, row), 0.0))


def shape_gates(shape: BoardShape, names: tuple[str, ...]) -> list[Gate]:
    """Gates on the board itself."""
    most_scaled = np.maximum(MOST_SCALED, shape.surely_scaled)
    most_bent_mm = np.maximum(MOST_SAG_MM, shape.surely_bent_mm)
    scaled = int(np.argmax(np.abs(shape.scaled) / most_scaled))
    bent = int(np.argmax(shape.sag_mm / most_bent_mm))
    return [
        Gate(
            "print_scale_unequal",
            abs(shape.unequal),
            max(MOST_UNEQUAL, shape.surely_unequal),
            "",
            "The print is scaled differently in x and y than board.toml says: measure both lengths with a calliper and "
            "calibrate with both. If they hold, the camera's horizontal scale is not as designed: use "
            "footscan calibrate --horizontal-scale.",
        ),
        Gate(
            "board_of_other_size",
            float(abs(shape.scaled[scaled])),
            float(most_scaled[scaled]),
            f"placement {names[scaled]}",
            "The board of this placement has another size than the others; use one and the same board throughout.",
            repeat=names[scaled],
        ),
        Gate(
            "board_bent_mm",
            float(shape.sag_mm[bent]),
            float(most_bent_mm[bent]),
            f"placement {names[bent]}",
            "The board is bent; glue it on a stiff flat plate and repeat the placement.",
            repeat=names[bent],
        ),
    ]
