"""What may be wrong when corners do not fit, each tried by giving it freedom: boards that differ, bend or were moved, a
lens that was knocked, an encoder that counts the other way or another number of steps.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from footscan.calibration.board_shape import freed_shape, shape_gates, shape_of
from footscan.calibration.design_gates import camera_gates
from footscan.calibration.encoder_steps import counts_per_turn
from footscan.calibration.estimate import Estimate
from footscan.calibration.first_guess import guess_estimate
from footscan.calibration.gate import Gate, Reason
from footscan.calibration.gates import Limits, placement_corners
from footscan.calibration.intake import Intake
from footscan.calibration.joint import CORNERS_ONLY
from footscan.calibration.misfit import corner_misfit_px, head_angles
from footscan.calibration.picture_jumps import jump_gate, jumps_of, picture_jumps
from footscan.calibration.sightings import NO_STRIPES, Corners, Sightings
from footscan.calibration.solve import Fit, fit_estimate
from footscan.calibration.unknowns import POSES_ONLY, Unknowns
from footscan.coordinates import Floats
from footscan.geometry.rigid import inverse_rigid
from footscan.optics.scanner import calibration_from_design

_AT_STOPS = Unknowns(tuple(name for name in CORNERS_ONLY.machine if name != "latency_s"))
_MOVED_MM = 0.06
_TOLERANCE_PX = 0.5
_HELPS = 0.5
_REJECTS = 0.05
_SIMPLER = 1.2
_MISCOUNTED = 0.0008
_STEPS_DOUBT = 0.006
_STEPS_SEARCH = {"xatol": 2.0, "maxiter": 10}
_STEPS_ROUNDS = 8


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
    miscounted = _miscounted(intake) if most else None
    if miscounted is not None and miscounted.left_px < limits.placement_corner_px:
        return miscounted.reason
    if most and _far_from_design(intake, fit):
        return _nothing(intake, fit)
    moved = [] if most else [_moved_one(intake, fit, p) for p in bad]
    passed = _passed(intake, fit)
    suspicions = [reverse, *moved, passed, _lens(intake, fit), _shape(intake, fit)]
    now = _misfit_px(fit)
    best = min((s for s in suspicions if s is not None), key=lambda s: s.left_px, default=None)
    if best is not None and passed is not None and passed.left_px < _SIMPLER * best.left_px:
        best = passed  # it needs no freedom at all
    if best is not None and best.left_px < max(_HELPS * now, 0.05) and best.left_px < now:
        return best.reason
    return _nothing(intake, fit)


def explain_jump(intake: Intake, fit: Fit, free: Fit, gate: Gate) -> Reason:
    """Why the picture seems to jump between two placements: the lens, or a board that was moved in one of them."""
    jumps = jumps_of(free)
    after = int(np.argmax(jumps.ratio())) + 1
    moved = [_moved_one(intake, fit, p) for p in (after - 1, after)]
    suspicions = [_Suspicion(_misfit_px(free), gate.reason()), *(s for s in moved if s is not None)]
    return min(suspicions, key=lambda s: s.left_px).reason


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


def _miscounted(intake: Intake) -> _Suspicion | None:
    """A turn of the head has another number of counts than scanner.toml says."""
    own, seen = intake.recording.scanner.encoder.steps_per_rev, counts_per_turn(intake)
    if seen is None or abs(seen / own - 1.0) < _MISCOUNTED:
        return None
    search = (seen * (1.0 - _STEPS_DOUBT), seen * (1.0 + _STEPS_DOUBT))
    best = minimize_scalar(
        lambda steps: _left_with_steps(intake, float(steps)), bounds=search, method="bounded", options=_STEPS_SEARCH
    )
    sentence = (
        f"a turn of the head has about {best.x:.0f} counts in these pictures, scanner.toml says steps_per_rev {own}. "
        "Correct [encoder] steps_per_rev (or the count per line in the encoder's interface) and try again."
    )
    return _Suspicion(float(best.fun), Reason(sentence))


def _left_with_steps(intake: Intake, steps_per_rev: float) -> float:
    machine = calibration_from_design(intake.recording.scanner)
    machine = replace(machine, encoder=replace(machine.encoder, steps_per_rev=round(steps_per_rev)))
    sightings = Sightings(intake.times, intake.corners, NO_STRIPES, intake.placement_names)
    return _misfit_px(fit_estimate(guess_estimate(intake, machine), sightings, CORNERS_ONLY, rounds=_STEPS_ROUNDS))


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
    share, name = len(corners) / np.count_nonzero(~intake.corners.moving), intake.placement_names[placement]
    left = float(np.sqrt((1.0 - share) * _misfit_px(others) ** 2 + share * best[0] ** 2))
    sentence = (
        f"placement {name}: the board was moved by {best[1]:.1f} mm before frame "
        f"{intake.recording.frames[best[2]].frame}. Fix it firmly and repeat this placement."
    )
    return _Suspicion(left if best[0] < _TOLERANCE_PX else np.inf, Reason(sentence, repeat=name))


def _passed(intake: Intake, fit: Fit) -> _Suspicion | None:
    """Something moved between a placement's stops and the moving sweeps past it: without these the rest fits."""
    corners = intake.corners
    if not np.any(corners.moving):
        return None
    at_stops = Sightings(intake.times, corners.kept(~corners.moving), NO_STRIPES, intake.placement_names)
    alone = fit_estimate(fit.estimate, at_stops, _AT_STOPS)
    names = {intake.placement_names[p] for p in np.unique(corners.placement[corners.moving])}
    sentence = (
        f"placement {', '.join(sorted(names))}: its frames taken while the head turned contradict those at its stops. "
        "Between them the board was moved, or lens or camera was knocked: fix them and record everything again."
    )
    return _Suspicion(_misfit_px(alone), Reason(sentence))


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
    free = freed_shape(intake, fit)
    failed = [gate for gate in shape_gates(shape_of(free, intake), intake.placement_names) if not gate.passed]
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
    bad = [f for f in sorted(size, key=lambda f: -size[f])[:3] if size[f] > 0.5 * max(size.values())]
    which = ", ".join(f"{intake.recording.frames[f].frame} ({size[f]:.1f} px)" for f in sorted(bad))
    name = intake.placement_names[worst]
    sentence = (
        f"placement {name}: its frames contradict the others ({rms[worst]:.2f} px RMS), "
        f"worst in frames {which}. The board moved, or frames were exchanged: repeat this placement."
    )
    return Reason(sentence, repeat=name)
