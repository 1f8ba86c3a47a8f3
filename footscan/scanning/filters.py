"""The adjustable filter on the picture, before the stripe is looked for (the paper's numerical filtering)."""

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from footscan.coordinates import Frame
from footscan.errors import InputError

FilterKind = Literal["off", "median", "gaussian", "unlit"]


@dataclass(frozen=True)
class FilterSettings:
    """Which filter, and how strong.

    `median` of `size_px` x `size_px` pixels removes sparks; `gaussian` of `sigma_px` calms noise; `unlit` subtracts the
    nearest frame taken with both lasers off, which removes the light of the room.
    """

    kind: FilterKind = "off"
    size_px: int = 3
    sigma_px: float = 0.8

    def __post_init__(self) -> None:
        if self.size_px not in (3, 5):
            raise InputError(f"a median filter of {self.size_px} px was asked for, allowed are 3 and 5.")
        if not 0.3 <= self.sigma_px <= 3.0:
            raise InputError(f"a Gaussian filter of {self.sigma_px} px was asked for, allowed are 0.3 to 3.")


def filtered(frame: Frame, settings: FilterSettings, unlit: Frame | None = None) -> Frame:
    """Apply the filter to a copy of a frame; `off` returns the frame itself.

    Raises:
        InputError: `unlit` without an unlit frame.
    """
    if settings.kind == "median":
        return np.asarray(cv2.medianBlur(frame, settings.size_px), dtype=np.uint8)
    if settings.kind == "gaussian":
        return np.asarray(cv2.GaussianBlur(frame, (0, 0), settings.sigma_px), dtype=np.uint8)
    if settings.kind == "unlit":
        if unlit is None:
            raise InputError("the filter subtracts an unlit frame, but the recording has none; choose another filter.")
        return np.asarray(cv2.subtract(frame, unlit), dtype=np.uint8)
    return frame
