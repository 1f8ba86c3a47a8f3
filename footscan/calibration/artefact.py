"""Test bodies in a cloud: spheres and planes found and fitted, and the figures of an acceptance test.

Names follow VDI/VDE 2634 and ISO 10360-13 as far as their public parts say (PF, PS, SD, F, D95); no conformity
is claimed.
"""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats
from footscan.errors import EmptyScanError
from footscan.geometry.plane import fit_plane

MOST_DROPPED = 0.003
"""Share of the points farthest off that may be left out."""
_TRIALS = 300
_NEAR_MM = 1.0
_FEWEST = 300
_ROUNDS = 20


@dataclass(frozen=True)
class FormFigures:
    """How points lie about a fitted body.

    Attributes:
        points: N.
        form_mm: Largest minus smallest residual, at most 3 per mille of the points left out (PF, F of a plane).
        d95_mm: Width that holds 95 % of the residuals.
        sigma_mm: Standard deviation of the residuals.
        size_error_mm: Fitted minus calibrated diameter (PS); NaN for a plane.
        coverage_deg: Half angle of the cap of the sphere that was seen; NaN for a plane.
    """

    points: int
    form_mm: float
    d95_mm: float
    sigma_mm: float
    size_error_mm: float
    coverage_deg: float


@dataclass(frozen=True)
class Sphere:
    """A fitted sphere: centre `(3,)` and diameter, mm."""

    centre: Floats
    diameter_mm: float


def fit_sphere(xyz: Floats, start: Floats, radius_mm: float | None = None) -> Sphere:
    """Least-squares sphere of `(n, 3)` points by Gauss-Newton from a centre; the radius is free unless given."""
    centre, radius = start.astype(np.float64).copy(), radius_mm or float(np.median(np.linalg.norm(xyz - start, axis=1)))
    for _ in range(_ROUNDS):
        away = xyz - centre
        distance = np.linalg.norm(away, axis=1)
        slope = -away / distance[:, None]
        matrix = slope if radius_mm is not None else np.column_stack([slope, -np.ones(len(xyz))])
        step = np.linalg.lstsq(matrix, radius - distance, rcond=None)[0]
        centre = centre + step[:3]
        radius += 0.0 if radius_mm is not None else float(step[3])
        if float(np.abs(step).max()) < 1e-9:
            break
    return Sphere(centre, 2.0 * radius)


def find_sphere(xyz: Floats, diameter_mm: float) -> tuple[Sphere, Bools]:
    """The sphere of about this diameter that most of `(n, 3)` points lie on, and which points those are.

    Raises:
        EmptyScanError: Too few points lie on any such sphere.
    """
    random = np.random.default_rng(7)
    best, most, middle = np.zeros(len(xyz), dtype=np.bool_), 0, np.zeros(3)
    for _ in range(_TRIALS if len(xyz) >= 4 else 0):
        centre = _centre_of_four(_near_each_other(xyz, random, diameter_mm), diameter_mm)
        if centre is None:
            continue
        near = np.abs(np.linalg.norm(xyz - centre, axis=1) - 0.5 * diameter_mm) < _NEAR_MM
        if np.count_nonzero(near) > most:
            best, most = near, int(np.count_nonzero(near))
            middle = centre
    if most < _FEWEST:
        raise EmptyScanError(
            f"only {most} points lie on a sphere of {diameter_mm:g} mm, at least {_FEWEST} are needed; check "
            "diameters_mm in artefact.toml and that the sphere was seen."
        )
    sphere = fit_sphere(xyz[best], middle)
    for _ in range(3):
        off = np.linalg.norm(xyz - sphere.centre, axis=1) - 0.5 * sphere.diameter_mm
        best = np.abs(off) < _NEAR_MM
        sphere = fit_sphere(xyz[best], sphere.centre)
    return sphere, best


def _near_each_other(xyz: Floats, random: np.random.Generator, diameter_mm: float) -> Floats:
    """Four random points, three of them within a diameter of the first."""
    first = xyz[random.integers(len(xyz))]
    close = np.flatnonzero(np.linalg.norm(xyz - first, axis=1) < diameter_mm)
    return np.vstack([first, xyz[random.choice(close, 3)]])


def _centre_of_four(four: Floats, diameter_mm: float) -> Floats | None:
    """The centre of the sphere through four points, or nothing where its size is far off."""
    matrix = 2.0 * (four[1:] - four[0])
    if abs(float(np.linalg.det(matrix))) < 1.0:
        return None
    centre = np.linalg.solve(matrix, np.sum(four[1:] ** 2, axis=1) - four[0] @ four[0])
    radius = float(np.linalg.norm(four[0] - centre))
    return centre if abs(2.0 * radius / diameter_mm - 1.0) < 0.1 else None


def sphere_figures(xyz: Floats, calibrated_mm: float, start: Floats) -> tuple[Sphere, FormFigures]:
    """Fit a sphere of free radius to its points `(n, 3)` and say how they lie about it."""
    sphere = fit_sphere(xyz, start)
    away = xyz - sphere.centre
    residual = np.linalg.norm(away, axis=1) - 0.5 * sphere.diameter_mm
    form = _form(residual)
    size = sphere.diameter_mm - calibrated_mm
    return sphere, FormFigures(len(xyz), *form, size, _cap_deg(away))


def _cap_deg(away: Floats) -> float:
    """Half angle of the cap around the mean direction that holds 99 % of the points."""
    unit = away / np.linalg.norm(away, axis=1, keepdims=True)
    mean = unit.mean(axis=0)
    length = float(np.linalg.norm(mean))
    if length < 1e-6:
        return 180.0
    return float(np.degrees(np.percentile(np.arccos(np.clip(unit @ (mean / length), -1.0, 1.0)), 99.0)))


def find_plane(xyz: Floats) -> Bools:
    """Points `(n,)` of the plane that most of `(n, 3)` points lie on.

    Raises:
        EmptyScanError: Too few points lie on any plane.
    """
    random = np.random.default_rng(7)
    best, most = np.zeros(len(xyz), dtype=np.bool_), 0
    for _ in range(_TRIALS if len(xyz) >= 3 else 0):
        one, two, three = xyz[random.choice(len(xyz), 3, replace=False)]
        normal = np.cross(two - one, three - one)
        length = float(np.linalg.norm(normal))
        if length < 10.0:
            continue
        near = np.abs((xyz - one) @ (normal / length)) < _NEAR_MM
        if np.count_nonzero(near) > most:
            best, most = near, int(np.count_nonzero(near))
    if most < _FEWEST:
        raise EmptyScanError(f"only {most} points lie on one plane, at least {_FEWEST} are needed; was the plane seen?")
    for _ in range(3):
        best = np.abs(fit_plane(xyz[best]).distance_mm(xyz)) < _NEAR_MM
    return best


def plane_figures(xyz: Floats) -> FormFigures:
    """Fit a plane to its points `(n, 3)` and say how they lie about it."""
    residual = fit_plane(xyz).distance_mm(xyz)
    return FormFigures(len(xyz), *_form(residual), float("nan"), float("nan"))


def _form(residual: Floats) -> tuple[float, float, float]:
    """Range with at most 3 per mille left out, 95 % width, standard deviation."""
    dropped = int(MOST_DROPPED * len(residual))
    kept = residual[np.argsort(np.abs(residual))[: len(residual) - dropped]]
    low, high = np.percentile(residual, [2.5, 97.5])
    return float(kept.max() - kept.min()), float(high - low), float(residual.std())
