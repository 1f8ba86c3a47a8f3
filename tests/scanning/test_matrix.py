import numpy as np
import pytest

from footscan.errors import RecordingError, StaleTableError
from footscan.optics.tables import build_table
from footscan.scanning.cloud import cloud_from_matrix
from footscan.scanning.matrix import ScanMatrix, load_scan_matrix


@pytest.fixture
def matrix(rng):
    filled = ScanMatrix("abc", frames=2, points=4)
    for k in range(9):
        n = 3 * k
        filled.append(k, "right" if k % 2 else "left", 0.1 * k, rng.normal(size=(n, 2)), np.full(n, k / 10))
    return filled


def test_memory_that_runs_out_is_doubled_without_losing_a_point(matrix):
    assert matrix.points_per_frame.tolist() == [3 * k for k in range(9)]
    assert matrix.frame.tolist() == list(range(9))
    assert matrix.laser.tolist() == [1, 0, 1, 0, 1, 0, 1, 0, 1]
    np.testing.assert_allclose(matrix.weight, np.repeat(np.arange(9) / 10, 3 * np.arange(9)), atol=1e-7)


def test_a_matrix_comes_back_from_disk(matrix, tmp_path):
    matrix.save(tmp_path / "m.npz")
    again = load_scan_matrix(tmp_path / "m.npz", "abc")

    np.testing.assert_array_equal(again.xy_light, matrix.xy_light)
    np.testing.assert_array_equal(again.theta_rad, matrix.theta_rad)
    np.testing.assert_array_equal(again.points_per_frame, matrix.points_per_frame)


def test_a_matrix_of_another_calibration_is_stale(matrix, tmp_path):
    matrix.save(tmp_path / "m.npz")

    with pytest.raises(StaleTableError, match="another calibration"):
        load_scan_matrix(tmp_path / "m.npz", "abd")


def test_a_cut_matrix_is_named(matrix, tmp_path):
    matrix.save(tmp_path / "m.npz")
    (tmp_path / "m.npz").write_bytes((tmp_path / "m.npz").read_bytes()[:300])

    with pytest.raises(RecordingError, match="no complete scan matrix"):
        load_scan_matrix(tmp_path / "m.npz", "abc")


def test_the_ideal_machines_cloud_follows_the_papers_w(ideal, rng):
    tables = {name: build_table(ideal, name) for name in ("right", "left")}
    matrix = ScanMatrix("x")
    xy_light = rng.uniform(-80, 80, (5, 2))
    matrix.append(0, "left", 0.7, xy_light, np.ones(5))
    cloud = cloud_from_matrix(matrix, tables)
    angle = 0.7 - np.pi / 4  # theta + alpha of the left laser
    expected = np.column_stack([-np.cos(angle) * xy_light[:, 0], -np.sin(angle) * xy_light[:, 0], xy_light[:, 1]])

    np.testing.assert_allclose(cloud.xyz_world, expected, atol=1e-5)
    assert cloud.laser.tolist() == [1] * 5
