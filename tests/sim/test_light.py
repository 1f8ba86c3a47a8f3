import numpy as np
import pytest

from footscan.optics.calibration import Calibration
from footscan.sim import light
from footscan.sim.optics_loops import lens_numbers


@pytest.mark.parametrize("ahead_mm", [1e-9, 1e-3, 1.0])
def test_a_surface_just_in_front_of_the_lens_does_not_take_for_ever(ideal: Calibration, ahead_mm: float) -> None:
    camera = ideal.camera
    numbers = np.full(light.NUMBERS, 0.1)
    piece = np.array([ahead_mm, -2.0, ahead_mm, 2.0, 1.0, 0.0, 0.0])
    drawn = light.find_strokes(
        piece, 0.0, 1.0, numbers, np.eye(4), lens_numbers(camera), camera.height_px, camera.width_px
    )

    assert drawn[0] <= light.MOST_STROKES
    assert np.all(np.isfinite(drawn))


def test_what_lies_wholly_beside_the_picture_is_not_drawn(ideal: Calibration) -> None:
    camera = ideal.camera
    numbers = np.full(light.NUMBERS, 0.1)
    piece = np.array([1.0, 200.0, 1.0, 210.0, 1.0, 0.0, 0.0])
    drawn = light.find_strokes(
        piece, 0.0, 1.0, numbers, np.eye(4), lens_numbers(camera), camera.height_px, camera.width_px
    )

    assert drawn[0] == 0
