from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footscan.config import load_calibration, save_calibration
from footscan.optics.calibration import (
    EncoderScale,
    camera_from_world,
    fingerprint,
    optical_centre_world,
    theta_from_encoder,
    world_at_theta,
)
from footscan.optics.head import (
    lens_offset_a_mm,
    light_from_world_ideal,
    rotation_camera_from_light,
    rotation_camera_from_world,
    translation_from_head,
)
from footscan.optics.sheet import (
    LightPlane,
    alpha_from_sheet,
    camera_from_ray,
    ideal_normal,
    plane_in_camera,
    world_from_light,
)
from footscan.sim.machine import workshop_machine

ANGLE = st.floats(-3.1, 3.1)
TILT = st.floats(-0.6, 0.6)


@given(ANGLE, TILT, TILT)
def test_the_pose_of_equation_16_is_a_proper_rotation(theta, phi, sigma):
    rotation = rotation_camera_from_world(theta, phi, sigma)

    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


@given(ANGLE, ANGLE, TILT, TILT)
def test_equations_16_a2_and_a4_agree(theta, alpha, phi, sigma):
    through_world = rotation_camera_from_world(theta, phi, sigma) @ light_from_world_ideal(theta, alpha)[:3, :3].T

    np.testing.assert_allclose(rotation_camera_from_light(alpha, phi, sigma), through_world, atol=1e-12)


@given(ANGLE, TILT, TILT)
def test_equation_a5_is_a2_with_minus_alpha(alpha, phi, sigma):
    ca, sa, cp, sp, cs, ss = (f(x) for x in (alpha, phi, sigma) for f in (np.cos, np.sin))
    x_axis_of_a5 = [cp * ca, -cs * sa - ss * sp * ca, -ss * sa + cs * sp * ca]
    y_axis_of_a5 = [-sp, -ss * cp, cs * cp]

    np.testing.assert_allclose(rotation_camera_from_light(-alpha, phi, sigma)[:, 0], x_axis_of_a5, atol=1e-12)
    np.testing.assert_allclose(rotation_camera_from_light(-alpha, phi, sigma)[:, 1], y_axis_of_a5, atol=1e-12)


@given(ANGLE, st.floats(-1.5, 1.5))
def test_the_ideal_sheet_has_the_papers_light_system(theta, alpha):
    sheet = LightPlane("right", ideal_normal(alpha), 0.0)
    ours = world_at_theta(world_from_light(sheet), theta)

    np.testing.assert_allclose(ours, np.linalg.inv(light_from_world_ideal(theta, alpha)), atol=1e-12)


@given(st.floats(-1.5, 1.5))
def test_alpha_comes_back_from_the_sheet(alpha):
    assert alpha_from_sheet(LightPlane("left", ideal_normal(alpha), 1.0)) == pytest.approx(alpha, abs=1e-12)


@given(ANGLE, TILT, TILT)
def test_the_closed_form_solves_equation_7(alpha, phi, sigma):
    plane = (*rotation_camera_from_light(alpha, phi, sigma)[:, 2], -40.0)
    y_i, z_i, f = 1.3, -0.7, 8.0
    h = np.array([[-y_i, -f, 0.0], [-z_i, 0.0, -f], plane[:3]])
    if abs(np.linalg.det(h)) < 1.0:
        return
    expected = np.linalg.solve(h, [-y_i * f, -z_i * f, 40.0])
    found = camera_from_ray(np.array([[f, -y_i, -z_i]]), f, plane)[0]

    if np.isfinite(found).all():
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-8)
    else:
        assert expected[0] < f


def test_table_1_gives_the_known_lengths(prototype, ideal):
    assert lens_offset_a_mm(prototype.head) == pytest.approx(6.39, abs=0.005)
    np.testing.assert_allclose(translation_from_head(prototype.head), [542.52, 0.0, -2.497], atol=0.005)
    np.testing.assert_allclose(optical_centre_world(ideal), [491.1, 0.0, 211.2], atol=0.05)


def test_a_sheet_that_misses_the_axis_has_its_origin_on_the_foot_of_the_perpendicular(workshop):
    sheet = workshop.laser("left")
    origin = world_from_light(sheet)[:3, 3]

    np.testing.assert_allclose(origin, sheet.offset_mm * np.array(sheet.normal), atol=1e-12)
    assert world_from_light(sheet)[2, 0] == 0.0


def test_plane_coefficients_vanish_on_points_of_the_sheet(workshop):
    sheet = workshop.laser("right")
    points = (world_from_light(sheet) @ np.array([[30.0, -80.0, 0.0], [10.0, 90.0, 0.0], [0] * 3, [1] * 3]))[:, :2]
    a, b, c, d = plane_in_camera(sheet, camera_from_world(workshop))
    xyz_camera = camera_from_world(workshop) @ points

    np.testing.assert_allclose(np.array([a, b, c]) @ xyz_camera[:3] + d, 0.0, atol=1e-10)


def test_an_eccentric_disc_adds_one_sine_per_turn():
    scale = EncoderScale(8000, 0, 1, 0.002, 0.5)
    theta = theta_from_encoder(np.array([0.0, 2000.0]), scale)

    np.testing.assert_allclose(theta - [0.0, np.pi / 2], 0.002 * np.sin(np.array([0.0, np.pi / 2]) - 0.5))


def test_the_fingerprint_follows_every_number_and_no_name(workshop):
    renamed = replace(workshop, scanner="other", machine_id="other", created="2020-01-01T00:00:00+00:00")
    moved = replace(workshop, latency_s=workshop.latency_s + 1e-9)

    assert fingerprint(renamed) == fingerprint(workshop)
    assert fingerprint(moved) != fingerprint(workshop)


@pytest.mark.parametrize("seed", range(12))
def test_the_fingerprint_survives_the_calibrations_file(prototype, tmp_path, seed):
    machine = workshop_machine(prototype, seed).calibration
    save_calibration(machine, tmp_path / "a.toml")
    again = load_calibration(tmp_path / "a.toml")
    save_calibration(again, tmp_path / "b.toml")

    assert fingerprint(again) == fingerprint(machine)
    assert fingerprint(load_calibration(tmp_path / "b.toml")) == fingerprint(machine)
