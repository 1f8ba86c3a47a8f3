import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from footscan.geometry.plane import Plane, fit_plane
from footscan.geometry.rigid import inverse_rigid, rigid, rotation_z, transform_points, turn_z

ANGLES = st.floats(-10.0, 10.0)
SHIFTS = arrays(float, 3, elements=st.floats(-1e3, 1e3))


@given(ANGLES, SHIFTS)
def test_a_rigid_transform_times_its_inverse_is_the_identity(angle, shift):
    transform = rigid(rotation_z(angle), shift)

    np.testing.assert_allclose(transform @ inverse_rigid(transform), np.eye(4), atol=1e-9)


@given(ANGLES, ANGLES)
def test_turns_about_z_add_up(first, second):
    np.testing.assert_allclose(turn_z(first) @ turn_z(second), turn_z(first + second), atol=1e-12)


@given(ANGLES)
def test_a_positive_turn_is_counter_clockwise_seen_from_above(angle):
    turned = transform_points(turn_z(angle), np.array([[1.0, 0.0, 5.0]]))

    np.testing.assert_allclose(turned, [[np.cos(angle), np.sin(angle), 5.0]], atol=1e-12)


@given(arrays(float, 3, elements=st.floats(-1.0, 1.0)), st.floats(-50.0, 50.0))
def test_the_fitted_plane_is_the_plane_the_points_lie_on(direction, offset):
    normal = direction + np.array([0.0, 0.0, 3.0])
    normal /= np.linalg.norm(normal)
    across = np.linalg.svd(normal[None])[2][1:]
    grid = np.mgrid[-2:3, -2:3].reshape(2, -1).T * 10.0
    plane = fit_plane(offset * normal + grid @ across)

    np.testing.assert_allclose(plane.normal, normal, atol=1e-9)
    assert plane.offset_mm == pytest.approx(offset, abs=1e-9)


def test_points_on_one_line_fix_no_plane():
    with pytest.raises(ValueError, match="one line"):
        fit_plane(np.arange(5.0)[:, None] * np.array([[1.0, 2.0, 3.0]]))


def test_distance_is_positive_on_the_side_the_normal_points_to():
    plane = Plane((0.0, 0.0, 1.0), 2.0)

    np.testing.assert_allclose(plane.distance_mm(np.array([[5.0, 5.0, 3.5], [0.0, 0.0, 0.0]])), [1.5, -2.0])
