from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from footscan.coordinates import pixel_from_uv, theta_from_count, uv_from_pixel
from footscan.optics.camera import (
    Camera,
    distorted_from_undistorted,
    estimate_horizontal_scale,
    image_from_pixel,
    pixel_from_camera,
    pixel_from_image,
    ray_from_pixel,
    undistorted_from_distorted,
)

CAMERA = Camera(582, 500, 0.0127, 0.0083, 8.0, 1.013, (286.9, 247.7), -5.6e-4, -1.1e-6)
PLACES = arrays(float, (7, 2), elements=st.floats(0.0, 499.0))


@given(PLACES)
def test_pixel_to_image_and_back(yz_pixel):
    np.testing.assert_allclose(pixel_from_image(image_from_pixel(yz_pixel, CAMERA), CAMERA), yz_pixel, atol=1e-9)


@given(PLACES, st.floats(-1.5e-3, 1.5e-3), st.floats(-2e-5, 2e-5))
def test_distortion_undone_and_done_again(yz_pixel, k1, k2):
    camera = replace(CAMERA, k1_per_mm2=k1, k2_per_mm4=k2)
    yz_image = image_from_pixel(yz_pixel, camera)
    undistorted = undistorted_from_distorted(yz_image, camera)

    np.testing.assert_allclose(distorted_from_undistorted(undistorted, camera), yz_image, atol=1e-9)


@given(PLACES, st.floats(100.0, 900.0))
def test_a_point_on_a_pixels_ray_projects_to_that_pixel(yz_pixel, depth_mm):
    ray = ray_from_pixel(yz_pixel, CAMERA)
    xyz_camera = np.array([CAMERA.focal_length_mm, 0.0, 0.0]) + depth_mm / CAMERA.focal_length_mm * ray

    np.testing.assert_allclose(pixel_from_camera(xyz_camera, CAMERA), yz_pixel, atol=1e-9)


@given(PLACES)
def test_the_upright_frame_is_the_papers_picture_with_rows_reversed(uv):
    yz_pixel = pixel_from_uv(uv, 500)

    np.testing.assert_allclose(yz_pixel[:, 0], uv[:, 0])
    np.testing.assert_allclose(yz_pixel[:, 1], 499.0 - uv[:, 1], atol=1e-12)
    np.testing.assert_allclose(uv_from_pixel(yz_pixel, 500), uv, atol=1e-12)


def test_a_point_behind_the_lens_has_no_picture():
    assert np.isnan(pixel_from_camera(np.array([[-100.0, 3.0, 4.0]]), CAMERA)).all()


def test_a_higher_point_of_the_scene_lies_higher_in_the_upright_frame(ideal):
    low, high = pixel_from_camera(np.array([[500.0, 0.0, -20.0], [500.0, 0.0, 20.0]]), ideal.camera)

    assert uv_from_pixel(high, 500)[1] < uv_from_pixel(low, 500)[1]


def test_folded_distortion_is_refused():
    with pytest.raises(ValueError, match="folds over"):
        distorted_from_undistorted(np.array([[20.0, 0.0]]), replace(CAMERA, k1_per_mm2=-0.05))


def test_horizontal_scale_is_elements_over_samples():
    assert estimate_horizontal_scale(752, 768) == pytest.approx(752 / 768)


def test_theta_is_zero_at_the_zero_count_and_follows_the_direction():
    theta = theta_from_count(np.array([4075.0, 6075.0]), 4075, 8000, 1)

    np.testing.assert_allclose(theta, [0.0, np.pi / 2])
    np.testing.assert_allclose(theta_from_count(np.array([6075.0]), 4075, 8000, -1), [-np.pi / 2])
