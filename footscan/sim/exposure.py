"""From light to bytes: speckle, shot and read noise, saturation, black level. All of it follows from the seed."""

from statistics import NormalDist

import numpy as np

from footscan.compiled import compiled, compiled_inline
from footscan.coordinates import Bytes, Floats32

_QUANTILES = 4096
_BITS = np.uint64(12)


def normal_quantiles() -> Floats32:
    """`(4096,)` values of a standard normal, each as likely as the others; variance 1."""
    shares = (np.arange(_QUANTILES) + 0.5) / _QUANTILES
    quantile = np.array([NormalDist().inv_cdf(share) for share in shares.tolist()])
    return (quantile / np.sqrt(np.mean(quantile**2))).astype(np.float32)


@compiled
def expose(
    ambient: Floats32,
    laser: Floats32,
    brightness: float,
    speckle: float,
    electrons_per_grey: float,
    read_noise: float,
    black_level: int,
    seed: int,
    quantiles: Floats32,
    frame: Bytes,
) -> None:
    """Turn light into an 8-bit frame.

    Args:
        ambient: `(height, width)` ambient light, grey values.
        laser: `(height, width)` laser light, grey values; may go beyond 255.
        brightness: Factor on all light.
        speckle: Standard deviation of the laser light relative to itself, per pixel.
        electrons_per_grey: Shot noise has the variance grey / electrons_per_grey; 0 is none.
        read_noise: Standard deviation, grey values.
        black_level: Smaller values are written as 0.
        seed: One number for this frame.
        quantiles: `normal_quantiles`.
        frame: `(height, width)` result.
    """
    state = _mixed(np.uint64(seed))
    mask = np.uint64(_QUANTILES - 1)
    shot = 1.0 / electrons_per_grey if electrons_per_grey > 0.0 else 0.0
    for row in range(frame.shape[0]):
        for column in range(frame.shape[1]):
            state += np.uint64(0x9E3779B97F4A7C15)
            random = _mixed(state)
            light = brightness * laser[row, column]
            grey = brightness * ambient[row, column]
            if light > 0.0:
                grey += light * max(np.float32(1.0) + np.float32(speckle) * quantiles[random & mask], np.float32(0.0))
            noise = np.float32(np.sqrt(read_noise * read_noise + shot * grey))
            grey += noise * quantiles[(random >> _BITS) & mask]
            value = min(max(int(np.floor(grey + 0.5)), 0), 255)
            frame[row, column] = value if value >= black_level else 0


@compiled_inline
def _mixed(state: np.uint64) -> np.uint64:
    """SplitMix64 (Steele, Lea and Flood 2014)."""
    state = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    state = (state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return state ^ (state >> np.uint64(31))
