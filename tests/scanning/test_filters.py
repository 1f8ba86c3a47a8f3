import numpy as np
import pytest

from footscan.errors import InputError
from footscan.scanning.filters import FilterSettings, filtered


@pytest.fixture
def frame(rng):
    return rng.integers(0, 200, (60, 80), dtype=np.uint8)


def test_off_leaves_the_frame_alone(frame):
    assert filtered(frame, FilterSettings()) is frame


def test_a_median_removes_a_spark_and_keeps_the_original(frame):
    spark = np.full((60, 80), 10, np.uint8)
    spark[30, 40] = 255
    calm = filtered(spark, FilterSettings("median", size_px=3))

    assert calm.max() == 10
    assert spark.max() == 255


def test_a_gaussian_calms_noise(frame):
    calm = filtered(frame, FilterSettings("gaussian", sigma_px=1.0))

    assert calm.astype(float).std() < 0.5 * frame.astype(float).std()


def test_the_unlit_frame_is_subtracted_and_never_wraps_around(frame):
    dark = np.full_like(frame, 120)
    rest = filtered(frame, FilterSettings("unlit"), dark)

    np.testing.assert_array_equal(rest, np.maximum(frame.astype(int) - 120, 0))


def test_unlit_without_an_unlit_frame_is_refused(frame):
    with pytest.raises(InputError, match="recording has none"):
        filtered(frame, FilterSettings("unlit"))


@pytest.mark.parametrize("settings", [{"size_px": 4}, {"sigma_px": 9.0}])
def test_an_impossible_filter_is_refused(settings):
    with pytest.raises(InputError, match="allowed are"):
        FilterSettings("median", **settings)
