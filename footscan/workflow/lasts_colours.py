"""The fixed colours of clearance and change, for pictures and for the page alike."""

import numpy as np

from footscan.coordinates import Bytes, Floats

CLEARANCE_MM = (-6.0, 10.0)
"""Ends of the colour scale; beyond them the end colours stay."""
WHITE_HALF_MM = 0.5
"""Half of the white band at the wanted clearance."""

UNSEEN = (150, 150, 150)
UNCHANGED = (176, 128, 80)
CHANGED = (214, 214, 214)
"""Pale grey, as in the paper's figure of a customised last."""

_STOPS = (0.0, 0.25, 1.0)
_TIGHT = np.array([[255, 226, 200], [250, 150, 90], [140, 10, 20]], dtype=np.float64)
_LOOSE = np.array([[205, 232, 250], [110, 180, 235], [15, 45, 120]], dtype=np.float64)


def clearance_colours(clearance_mm: Floats, target_mm: float = 0.0) -> Bytes:
    """Colours of signed clearances (positive: the last stands away from the skin).

    Args:
        clearance_mm: `(n,)`; NaN where the skin was never seen.
        target_mm: Clearance that is white.

    Returns:
        `(n, 3)` red, green, blue: tight is red, loose is blue, unseen is grey.
    """
    low, high = CLEARANCE_MM
    away = np.asarray(clearance_mm, dtype=np.float64) - target_mm
    tight = np.clip((-away - WHITE_HALF_MM) / (target_mm - low - WHITE_HALF_MM), 0.0, 1.0)
    loose = np.clip((away - WHITE_HALF_MM) / (high - target_mm - WHITE_HALF_MM), 0.0, 1.0)
    rgb = np.full((len(away), 3), 255.0)
    rgb = np.where((away < -WHITE_HALF_MM)[:, None], _shade(tight, _TIGHT), rgb)
    rgb = np.where((away > WHITE_HALF_MM)[:, None], _shade(loose, _LOOSE), rgb)
    rgb[np.isnan(away)] = UNSEEN
    return np.round(rgb).astype(np.uint8)


def _shade(share: Floats, stops: Floats) -> Floats:
    return np.column_stack([np.interp(share, _STOPS, stops[:, k]) for k in range(3)])


def change_colours(displacement_mm: Floats, least_mm: float = 0.01) -> Bytes:
    """Colours of a customised last: pale grey where it moved by more than `least_mm`, else brown; `(n, 3)`."""
    moved = np.abs(np.asarray(displacement_mm, dtype=np.float64)) > least_mm
    return np.where(moved[:, None], np.array(CHANGED), np.array(UNCHANGED)).astype(np.uint8)
