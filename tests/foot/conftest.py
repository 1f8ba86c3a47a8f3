"""A smooth foot made of formulas: heel, arch, ball, hints of five toes, malleoli, leg. A right foot, toes to +x."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import trimesh
from threadpoolctl import threadpool_limits

LENGTH_MM = 260.0


@pytest.fixture(scope="package", autouse=True)
def one_blas_thread() -> Iterator[None]:
    """As `workflow.foot` runs: two threads that wait for each other cost more than they bring."""
    with threadpool_limits(1):
        yield


def _outline(angle: np.ndarray) -> np.ndarray:
    """Sole outline in shares of the length; angle 0 at the toes, growing towards the medial side (+y)."""
    x = 0.5 + 0.5 * np.cos(angle)
    medial = 0.118 + 0.105 * np.exp(-(((x - 0.74) / 0.17) ** 2)) + 0.035 * np.exp(-(((x - 0.14) / 0.14) ** 2))
    lateral = 0.128 + 0.070 * np.exp(-(((x - 0.61) / 0.20) ** 2)) + 0.022 * np.exp(-(((x - 0.14) / 0.14) ** 2))
    medial = medial - 0.03 * np.exp(-(((x - 0.42) / 0.12) ** 2))
    rounding = np.sqrt(np.abs(np.sin(angle)))
    y = np.where(np.sin(angle) >= 0, medial, -lateral) * rounding
    bend = 0.05 * np.clip(x - 0.75, 0.0, None) / 0.25
    toes = 0.004 * np.cos(11 * angle) * np.exp(-((np.sin(angle / 2.0) / 0.25) ** 2))
    return np.stack([x + toes, y + bend], axis=-1)


_FRONT_Z = np.array([0.0, 0.05, 0.095, 0.13, 0.17, 0.22, 0.27, 0.31, 0.345, 0.40, 0.50, 0.92])
_FRONT_X = np.array([1.0, 1.0, 0.955, 0.80, 0.68, 0.58, 0.51, 0.465, 0.445, 0.43, 0.43, 0.46])
_BACK_Z = np.array([0.0, 0.09, 0.20, 0.30, 0.42, 0.60, 0.92])
_BACK_X = np.array([0.0, 0.0, 0.025, 0.05, 0.062, 0.045, 0.005])
_HALF_Z = np.array([0.0, 0.2, 0.3, 0.42, 0.6, 0.92])
_HALF_Y = np.array([0.150, 0.138, 0.128, 0.118, 0.135, 0.185])


def _smooth(z: np.ndarray, knots: np.ndarray, values: np.ndarray) -> np.ndarray:
    fine = np.linspace(knots[0], knots[-1], 2000)
    kernel = np.exp(-(np.linspace(-2.5, 2.5, 61) ** 2))
    padded = np.pad(np.interp(fine, knots, values), 30, mode="edge")
    return np.interp(z, fine, np.convolve(padded, kernel / kernel.sum(), mode="valid"))


def _level(angle: np.ndarray, z: float) -> np.ndarray:
    """Contour `(n, 2)` at a height, in shares of the length."""
    front, back = (float(_smooth(np.array([z]), k, v)[0]) for k, v in ((_FRONT_Z, _FRONT_X), (_BACK_Z, _BACK_X)))
    flat = _outline(angle)
    leg = float(np.clip((z - 0.05) / 0.27, 0.0, 1.0))
    leg = leg * leg * (3.0 - 2.0 * leg)
    half = float(_smooth(np.array([z]), _HALF_Z, _HALF_Y)[0])
    ellipse = np.stack([0.5 + 0.5 * np.cos(angle), half * np.sin(angle) + 0.012], axis=-1)
    contour = (1.0 - leg) * flat + leg * ellipse
    edge = 0.045 * (1.0 - np.sqrt(1.0 - np.clip(1.0 - z / 0.045, 0.0, 1.0) ** 2))
    x = back + edge + contour[:, 0] * (front - back - 2.0 * edge)
    y = contour[:, 1] * (1.0 - edge / 0.15)
    inner = 0.05 * np.exp(-(((x - 0.25) / 0.06) ** 2) - ((z - 0.315) / 0.035) ** 2)
    outer = 0.05 * np.exp(-(((x - 0.21) / 0.06) ** 2) - ((z - 0.265) / 0.035) ** 2)
    return np.stack([x, y + inner * np.clip(y / 0.1, 0.0, 1.0) - outer * np.clip(-y / 0.1, 0.0, 1.0)], axis=-1)


def build_foot(length_mm: float = LENGTH_MM, top_mm: float = 238.0, around: int = 120, up: int = 70) -> trimesh.Trimesh:
    """The closed mesh; `top_mm` is for a foot of 260 mm and scales with the length."""
    angle = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    top = top_mm / LENGTH_MM
    low = np.linspace(0.0, 0.10, up // 3, endpoint=False)
    heights = np.concatenate([low, np.linspace(0.10, top, up - len(low))])
    rings = np.array([np.column_stack([_level(angle, z), np.full(around, z)]) for z in heights])
    ring = np.arange(around)
    following = np.roll(ring, -1)
    faces = []
    for k in range(len(heights) - 1):
        a, b = k * around, (k + 1) * around
        faces.append(np.stack([a + ring, a + following, b + following], axis=1))
        faces.append(np.stack([a + ring, b + following, b + ring], axis=1))
    count = len(heights) * around
    faces.append(np.stack([following, ring, np.full(around, count)], axis=1))
    faces.append(np.stack([count - around + ring, count - around + following, np.full(around, count + 1)], axis=1))
    middles = np.array([rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    xyz = np.concatenate([rings.reshape(-1, 3), middles]) * length_mm
    return trimesh.Trimesh(xyz, np.concatenate(faces), process=False)


@pytest.fixture(scope="session")
def foot() -> trimesh.Trimesh:
    """A right foot of 260 mm with a leg up to 238 mm."""
    return build_foot()


@pytest.fixture(scope="session")
def make_foot() -> Callable[..., trimesh.Trimesh]:
    """`build_foot`."""
    return build_foot


@pytest.fixture(scope="session")
def shared_feet() -> Path:
    """The folder of shared feet and recordings; skips without it."""
    root = os.environ.get("FOOTSCAN_SHARED")
    if not root or not (Path(root) / "data" / "feet").is_dir():
        pytest.skip("FOOTSCAN_SHARED does not name the shared data")
    return Path(root) / "data"
