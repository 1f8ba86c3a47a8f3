"""The joint estimate: robust Gauss-Newton with Levenberg's damping over everything at once."""

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from footscan.calibration.estimate import Estimate
from footscan.calibration.residuals import Problem, Rows
from footscan.calibration.sightings import Sightings
from footscan.calibration.unknowns import EVERYTHING, Unknowns, firmness
from footscan.coordinates import Bools, Floats

_ROUNDS = 40
_SETTLED = 0.01


@dataclass(frozen=True)
class Fit:
    """A solved estimate.

    Attributes:
        estimate: Where it settled.
        unknowns: What was free.
        residual_px: `(r,)` residuals.
        rows: What they belong to.
        scale_px: Robust standard deviation of each kind of residual.
        weight: `(r,)` weights 1 / scale^2 times the biweight.
        jacobian: `(r, k)` at the solution, px per unit.
        rounds: Rounds used.
    """

    estimate: Estimate
    unknowns: Unknowns
    residual_px: Floats
    rows: Rows
    scale_px: Floats
    weight: Floats
    jacobian: Floats
    rounds: int
    settled: bool

    def normal_matrix(self) -> Floats:
        """Weighted normal matrix `(k, k)`, what is known beforehand included."""
        with threadpool_limits(1):
            seen = (self.jacobian * self.weight[:, None]).T @ self.jacobian
        return np.asarray(seen + np.diag(self.firmness()))

    def firmness(self) -> Floats:
        """1 / variance `(k,)` with which each unknown is held."""
        return firmness(self.unknowns, self.estimate.placements)

    def spread(self) -> Floats:
        """Covariance `(k, k)` as the weights alone say; doubts are held where their common part cannot be seen."""
        matrix = self.normal_matrix()
        unit = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
        scaled = np.linalg.pinv(matrix * unit[:, None] * unit[None, :], rcond=1e-14, hermitian=True)
        return np.asarray(scaled * unit[:, None] * unit[None, :])

    def kept(self) -> Bools:
        """`(r,)` residuals that were not rejected as outliers."""
        return self.weight > 0.0


def fit_estimate(
    start: Estimate,
    sightings: Sightings,
    unknowns: Unknowns = EVERYTHING,
    scale_px: Floats | None = None,
    rounds: int = _ROUNDS,
) -> Fit:
    """Solve for all free unknowns at once.

    Args:
        start: First guess.
        sightings: Corners and stripe places.
        unknowns: What is free.
        scale_px: `(5,)` known scales of the residuals; found from the residuals when left out.
        rounds: At most so many rounds.

    Returns:
        The fit; `settled` says whether the steps became small.
    """
    with threadpool_limits(1):  # the products are small: two BLAS threads wait for each other
        return _iterate(start, Problem(sightings, unknowns, scale_px), rounds)


def _iterate(start: Estimate, problem: Problem, rounds: int) -> Fit:
    estimate, damping = start, 1e-6
    residual = problem.residual_px(estimate)
    jacobian = problem.jacobian(estimate)
    scale, weight = problem.weights(residual, first=True)
    settled = False
    done = 0
    for done in range(1, rounds + 1):
        step, size = _step(jacobian, residual, weight, damping, problem.firmness, problem.pull(estimate))
        trial = problem.moved(estimate, step)
        trial_residual = problem.residual_px(trial)
        before = problem.cost(residual, scale) + problem.strain(estimate)
        if problem.cost(trial_residual, scale) + problem.strain(trial) > before * (1.0 + 1e-9):
            damping = max(10.0 * damping, 1e-6)
            settled = size < _SETTLED
            if damping > 1e8 or settled:
                break
            continue
        damping = max(0.2 * damping, 1e-12)
        estimate, residual = trial, trial_residual
        scale, weight = problem.weights(residual, first=done < 3)
        jacobian = problem.jacobian(estimate)
        settled = size < _SETTLED
        if settled and done >= 4:
            break
    return Fit(estimate, problem.unknowns, residual, problem.rows, scale, weight, jacobian, done, settled)


def _step(
    jacobian: Floats, residual: Floats, weight: Floats, damping: float, firmness: Floats, pull: Floats
) -> tuple[Floats, float]:
    """The damped step, and its size in standard deviations of the unknowns."""
    weighted = jacobian * weight[:, None]
    matrix, slope = weighted.T @ jacobian, weighted.T @ residual + pull
    matrix[np.diag_indices_from(matrix)] += firmness
    unit = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    scaled = matrix * unit[:, None] * unit[None, :]
    scaled[np.diag_indices_from(scaled)] += damping + 1e-13
    step = -unit * np.linalg.solve(scaled, unit * slope)
    size = float(np.sqrt(max(0.0, -step @ slope) / max(len(step), 1)))
    return step, size
