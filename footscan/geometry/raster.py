"""An orthographic picture of a mesh: which facet is in front in every pixel."""

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import Floats, Ints


def front_facets(corners: Floats, low: Floats, pixel: float, shape: tuple[int, int]) -> Ints:
    """The facet nearest to the eye in every pixel.

    Args:
        corners: `(m, 3, 3)` facet corners as (right, up, towards the eye).
        low: `(2,)` right and up of the picture's lower left corner.
        pixel: Size of a pixel, in the unit of `corners`.
        shape: Rows and columns.

    Returns:
        `(rows, columns)` facet indices, row 0 at the bottom, -1 where nothing is.
    """
    facet = np.full(shape, -1, dtype=np.int64)
    scaled = np.array(corners, dtype=np.float64)
    scaled[:, :, :2] = (scaled[:, :, :2] - low) / pixel - 0.5
    _draw(scaled, np.full(shape, -np.inf), facet)
    return facet


@compiled
def _draw(corners: Floats, nearest: Floats, facet: Ints) -> None:
    rows, columns = facet.shape
    for m in range(corners.shape[0]):
        x0, y0, z0 = corners[m, 0, 0], corners[m, 0, 1], corners[m, 0, 2]
        x1, y1, z1 = corners[m, 1, 0], corners[m, 1, 1], corners[m, 1, 2]
        x2, y2, z2 = corners[m, 2, 0], corners[m, 2, 1], corners[m, 2, 2]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if area == 0.0:
            continue
        for row in range(max(int(np.ceil(min(y0, y1, y2))), 0), min(int(np.floor(max(y0, y1, y2))), rows - 1) + 1):
            for column in range(
                max(int(np.ceil(min(x0, x1, x2))), 0), min(int(np.floor(max(x0, x1, x2))), columns - 1) + 1
            ):
                b = ((column - x0) * (y2 - y0) - (x2 - x0) * (row - y0)) / area
                c = ((x1 - x0) * (row - y0) - (column - x0) * (y1 - y0)) / area
                if b >= -1e-9 and c >= -1e-9 and b + c <= 1.0 + 1e-9:
                    height = z0 + b * (z1 - z0) + c * (z2 - z0)
                    if height > nearest[row, column]:
                        nearest[row, column] = height
                        facet[row, column] = m
