"""Everything that is compiled at first use, used once before time matters: compiling holds all other threads up."""

import numpy as np

from footscan.coordinates import Floats, LaserName
from footscan.optics.tables import LightTable
from footscan.scanning.stripe import find_stripe


def warm_up(width_px: int, height_px: int, tables: dict[LaserName, LightTable] | None) -> None:
    """Find a drawn stripe and look it up, as the check and the live view do."""
    frame = np.zeros((height_px, width_px), np.uint8)
    column = width_px // 2
    for off, grey in ((-2, 40), (-1, 120), (0, 200), (1, 120), (2, 40)):
        frame[:, column + off] = grey
    uv: Floats = find_stripe(frame, None).uv
    for table in (tables or {}).values():
        table.lookup(uv)
