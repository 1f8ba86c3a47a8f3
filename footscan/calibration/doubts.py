"""What may be wrong when corners do not fit, each tried by giving it freedom: boards that differ, bend or were moved, a
lens that was knocked, an encoder that counts the other way.
"""

from dataclasses import dataclass, replace

import numpy as np

from footscan.calibration.charuco import half_size_mm
from footscan.calibration.design_gates import camera_gates
from footscan.calibration.estimate import LENS, POSE, SHAPE, Estimate
from footscan.calibration.first_guess import guess_estimate
from footscan.calibration.gates import Gate, Limits, Reason, placement_corners
from footscan.calibration.intake import Intake
from footscan.calibration.joint import CORNERS_ONLY
from footscan.calibration.misfit import corner_misfit_px, head_angles
from footscan.calibration.sightings import NO_STRIPES, Corners, Sightings
from footscan.calibration.solve import Fit, fit_estimate
from footscan.calibration.unknowns import POSES_ONLY, Unknowns
from footscan.coordinates import Floats
from footscan.geometry.rigid import inverse_rigid
from footscan.optics.scanner import calibration_from_design

MOST_UNEQUAL = 4e-4
MOST_SCALED = 6e-4
MOST_SAG_MM = 0.15
MOST_KNOCK_PX = np.array([0.07, 0.2])
"""Jump of the picture along the rows and the columns of the sensor; the second one hides behind the boards' height."""
_SURE = 5.0
_MOVED_MM = 0.15
_TOLERANCE_PX = 0.5
_HELPS = 0.5
_REJECTS = 0.05
_FREE_LENS = tuple(name for name in CORNERS_ONLY.machine if not name.startswith(("principal", "latency")))


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
    return _shape_of(_freed_shape(intake, corners_fit), intake)


def _freed_shape(intake: Intake, corners_fit: Fit) -> Fit:
    sightings = Sightings(intake.times, intake.corners, NO_STRIPES, intake.placement_names)
    return fit_estimate(corners_fit.estimate, sightings, Unknowns(CORNERS_ONLY.machine, POSE + SHAPE))


def _shape_of(free: Fit, intake: Intake) -> BoardShape:
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


@dataclass(frozen=True)
class PictureJumps:
    """Shift of the picture on the sensor from placement to placement, `(p - 1, 2)` px, and what may be chance."""

    jump_px: Floats
    chance_px: Floats

    def ratio(self) -> Floats:
        """Each jump `(p - 1,)` relative to what is allowed."""
        return np.max(np.abs(self.jump_px) / np.maximum(MOST_KNOCK_PX, self.chance_px), axis=1)


def picture_jumps(intake: Intake, corners_fit: Fit) -> tuple[PictureJumps, Fit]:
    """Let the picture sit elsewhere on the sensor in every placement, at the stops; returns the jumps and the fit."""
    at_stops = intake.corners.kept(~intake.corners.moving)
    sightings = Sightings(intake.times, at_stops, NO_STRIPES, intake.placement_names)
    free = fit_estimate(corners_fit.estimate, sightings, Unknowns(_FREE_LENS, POSE + LENS))
    names, spread = free.unknowns.names(free.estimate.placements), free.spread()
    jump = np.diff(free.estimate.doubts[:, len(SHAPE) :], axis=0)
    chance = np.zeros_like(jump)
    for column, name in enumerate(LENS):
        for p in range(len(jump)):
            i, j = names.index(f"{name}[{p}]"), names.index(f"{name}[{p + 1}]")
            chance[p, column] = _SURE * np.sqrt(max(0.0, spread[i, i] + spread[j, j] - 2.0 * spread[i, j]))
    return PictureJumps(jump, chance), free


def jump_gate(jumps: PictureJumps, names: tuple[str, ...]) -> Gate:
    """Gate on the lens: the picture must not jump between placements."""
    ratio = jumps.ratio()
    at = int(np.argmax(ratio))
    size = float(np.hypot(*jumps.jump_px[at]))
    return Gate(
        "picture_jump_of_allowed",
        float(ratio[at]),
        1.0,
        f"between placements {names[at]} and {names[at + 1]}",
        f"The picture jumps by {size:.2f} px: lens or camera was knocked. Fix both and record everything again.",
    )


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
            "enter them (--measured-x, --measured-y). If they hold, the camera's horizontal scale is not as designed: "
            "use --horizontal-scale.",
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


@dataclass(frozen=True)
class _Suspicion:
    """One explanation: how much of the misfit it leaves over (px RMS)."""

    left_px: float
    reason: Reason


def explain_corners(intake: Intake, fit: Fit, limits: Limits) -> Reason:
    """The likeliest reason why corners do not fit: the one whose freedom takes most of the misfit away."""
    bad = [p for p in range(len(intake.placement_names)) if _is_bad(fit, p, limits)]
    most = 2 * len(bad) > len(intake.placement_names)
    reverse = _reversed(intake) if most else None
    if reverse is not None and reverse.left_px < limits.placement_corner_px:
        return reverse.reason
    if most and _far_from_design(intake, fit):
        return _nothing(intake, fit)
    moved = [] if most else [_moved_one(intake, fit, p) for p in bad]
    suspicions = [reverse, *moved, _lens(intake, fit), _shape(intake, fit)]
    now = _misfit_px(fit)
    best = min((s for s in suspicions if s is not None), key=lambda s: s.left_px, default=None)
    if best is not None and best.left_px < max(_HELPS * now, 0.05) and best.left_px < now:
        return best.reason
    return _nothing(intake, fit)


def _is_bad(fit: Fit, placement: int, limits: Limits) -> bool:
    rms_px, rejected = placement_corners(fit, placement)
    return rms_px > limits.placement_corner_px or rejected > _REJECTS


def _far_from_design(intake: Intake, fit: Fit) -> list[Gate]:
    return [gate for gate in camera_gates(fit.estimate.machine, intake.recording.scanner) if not gate.passed]


def _misfit_px(fit: Fit) -> float:
    """RMS of all corners at stops, each counted up to 3 px."""
    residual = np.minimum(np.abs(np.nan_to_num(fit.residual_px[fit.rows.group == 0], nan=3.0)), 3.0)
    return float(np.sqrt(np.mean(residual**2)))


def _reversed(intake: Intake) -> _Suspicion | None:
    """The encoder counts the other way than scanner.toml says."""
    machine = calibration_from_design(intake.recording.scanner)
    machine = replace(machine, encoder=replace(machine.encoder, direction=-machine.encoder.direction))
    sightings = Sightings(intake.times, intake.corners, NO_STRIPES, intake.placement_names)
    fit = fit_estimate(guess_estimate(intake, machine), sightings, CORNERS_ONLY)
    own = intake.recording.scanner.encoder.direction
    sentence = (
        f"the encoder counts the other way: scanner.toml says direction {own}, the pictures say {-own}. "
        "Correct [encoder] direction (or exchange the encoder's phases) and try again."
    )
    return _Suspicion(_misfit_px(fit), Reason(sentence))


def _moved_one(intake: Intake, fit: Fit, placement: int) -> _Suspicion | None:
    """A board that was moved once between two stops: the rest fitted alone, then this placement as two boards."""
    everything = Sightings(intake.times, intake.corners, NO_STRIPES, intake.placement_names)
    others = fit_estimate(fit.estimate, everything.without(placement), CORNERS_ONLY)
    corners = intake.corners.kept((intake.corners.placement == placement) & ~intake.corners.moving)
    frames = np.unique(corners.frame)
    best: tuple[float, float, int] | None = None
    for stop in frames[1:]:
        early = corners.frame < stop
        parts = [_posed(others.estimate, intake, corners.kept(half)) for half in (early, ~early)]
        rms = float(np.sqrt(np.mean(np.concatenate([part[0] for part in parts]) ** 2)))
        if best is None or rms < best[0]:
            best = (rms, float(np.linalg.norm(parts[0][1][:3, 3] - parts[1][1][:3, 3])), int(stop))
    if best is None or best[1] < _MOVED_MM:
        return None
    left, name = float(np.hypot(_misfit_px(others), best[0])), intake.placement_names[placement]
    sentence = (
        f"placement {name}: the board was moved by {best[1]:.1f} mm before frame "
        f"{intake.recording.frames[best[2]].frame}. Fix it firmly and repeat this placement."
    )
    return _Suspicion(left if best[0] < _TOLERANCE_PX else np.inf, Reason(sentence, repeat=name))


def _posed(estimate: Estimate, intake: Intake, corners: Corners) -> tuple[Floats, Floats]:
    """Residuals (px, up to 3) and pose of one board fitted to some corners, the machine held."""
    sightings = Sightings(intake.times, corners, NO_STRIPES, intake.placement_names)
    placement = int(corners.placement[0])
    fit = fit_estimate(estimate, sightings, POSES_ONLY, rounds=8)
    misfit = corner_misfit_px(fit.estimate, corners, head_angles(fit.estimate, sightings)).ravel()
    return np.minimum(np.abs(misfit), 3.0), inverse_rigid(inverse_rigid(fit.estimate.world_from_board[placement]))


def _lens(intake: Intake, fit: Fit) -> _Suspicion | None:
    """The picture sits elsewhere on the sensor from some placement on."""
    jumps, free = picture_jumps(intake, fit)
    gate = jump_gate(jumps, intake.placement_names)
    return None if gate.passed else _Suspicion(_misfit_px(free), gate.reason())


def _shape(intake: Intake, fit: Fit) -> _Suspicion | None:
    """The board itself: unequal scale, another size, or bent."""
    free = _freed_shape(intake, fit)
    failed = [gate for gate in shape_gates(_shape_of(free, intake), intake.placement_names) if not gate.passed]
    if not failed:
        return None
    worst = max(failed, key=lambda gate: gate.value / gate.limit)
    return _Suspicion(_misfit_px(free), worst.reason())


def _nothing(intake: Intake, fit: Fit) -> Reason:
    """No single explanation: another machine, or the worst placement and its worst frames."""
    rms = [placement_corners(fit, p)[0] for p in range(len(intake.placement_names))]
    worst = int(np.argmax(rms))
    far = _far_from_design(intake, fit)
    if far or min(rms) > 1.0:
        off = f" ({far[0].name.replace('_', ' ')}: {far[0].value:.3g}, at most {far[0].limit:g})" if far else ""
        return Reason(
            f"the corners fit no machine of this design{off}: scanner.toml (encoder steps, camera, head) or "
            "the frames belong to another machine. Correct scanner.toml, or record again."
        )
    own = (fit.rows.placement == worst) & (fit.rows.laser < 0)
    size = {int(f): float(np.median(np.abs(fit.residual_px[own & (fit.rows.frame == f)]))) for f in fit.rows.frame[own]}
    bad = sorted(size, key=lambda f: -size[f])[:3]
    which = ", ".join(f"{intake.recording.frames[f].frame} ({size[f]:.1f} px)" for f in sorted(bad))
    name = intake.placement_names[worst]
    sentence = (
        f"placement {name}: its frames contradict the others ({rms[worst]:.2f} px RMS), "
        f"worst in frames {which}. The board moved, or frames were exchanged: repeat this placement."
    )
    return Reason(sentence, repeat=name)
