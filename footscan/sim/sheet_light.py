"""The sheet of a laser as the picture draws it: thin layers of light, and where they cut the round footboard."""

import numpy as np

from footscan.coordinates import Floats
from footscan.optics import Calibration
from footscan.sim.cut import Cut


def split_sheet(sigma_mm: float, layers: int) -> tuple[Floats, Floats, float]:
    """Make a Gaussian sheet of several thin Gaussian ones.

    Returns:
        Distances `(layers,)` of the thin sheets from the middle (mm), their peaks `(layers,)` relative to the whole
        sheet's, and their common sigma (mm). Light and variance of the sum are those of the whole sheet.
    """
    if layers == 1:
        return np.zeros(1), np.ones(1), sigma_mm
    step = 3.2 / (layers - 1)  # the outermost stand at 1.6 sigma
    place: Floats = step * (np.arange(layers, dtype=np.float64) - (layers - 1) / 2.0)
    share = np.exp(-(place**2) / (2.0 * 0.8**2))
    share /= share.sum()
    thin = float(np.sqrt(1.0 - share @ place**2))
    return sigma_mm * place, share / thin, sigma_mm * thin


def floor_in_light(machine: Calibration, light_from_world: Floats) -> Floats:
    """The footboard's plane `(4,)` (normal, offset) in the light system."""
    normal = light_from_world[:3, :3] @ machine.floor.normal_array
    return np.array([*normal, machine.floor.offset_mm + float(normal @ light_from_world[:3, 3])])


def cut_footboard(floor: Floats, axis_light: Floats, layers_mm: Floats, radius_mm: float) -> Cut:
    """The light curves on the round footboard: a straight line per layer, in pieces of at most 4 mm."""
    normal, offset = floor[:3], floor[3]
    pieces, start = [np.empty((0, 7))], [0]
    for z_light in layers_mm:
        inside = radius_mm**2 - (z_light - axis_light[2]) ** 2
        half = np.sqrt(max(inside, 0.0))
        x = np.linspace(axis_light[0] - half, axis_light[0] + half, max(int(np.ceil(half / 2.0)), 1) + 1)
        y = (offset - normal[0] * x - normal[2] * z_light) / normal[1]
        ends = np.column_stack([x[:-1], y[:-1], x[1:], y[1:]])
        pieces.append(np.column_stack([ends, np.broadcast_to(normal, (len(ends), 3))]))
        start.append(start[-1] + len(ends))
    joined = np.ascontiguousarray(np.concatenate(pieces))
    return Cut(joined, np.full(len(joined), -1), np.array(start, dtype=np.int64))
