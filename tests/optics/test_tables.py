from dataclasses import replace

import numpy as np
import pytest

from footscan.config.toml_file import write_whole
from footscan.coordinates import LASER_NAMES, WORKING_RADIUS_MM, WORKING_Z_MM
from footscan.errors import InputError, StaleTableError
from footscan.geometry.rigid import transform_points
from footscan.optics.table_store import load_tables, tables_bytes
from footscan.optics.tables import build_table
from tests.optics.paper import slow_chain


def world_of(table, xy_light):
    return transform_points(table.world_from_light, np.column_stack([xy_light, np.zeros(len(xy_light))]))


@pytest.mark.parametrize("laser", LASER_NAMES)
@pytest.mark.parametrize("machine", ["ideal", "workshop"])
def test_a_table_is_the_papers_slow_chain(machine, laser, request, rng):
    calibration = request.getfixturevalue(machine)
    table = build_table(calibration, laser)
    uv = np.column_stack([rng.uniform(0, 581, 400), rng.uniform(0, 499, 400)])
    uv[:200] = np.rint(uv[:200])
    xy_light = table.lookup(uv)
    seen = np.isfinite(xy_light[:, 0])
    truth = slow_chain(calibration, laser, uv[seen])
    inner = (np.hypot(truth[:, 0], truth[:, 1]) < WORKING_RADIUS_MM - 2) & (truth[:, 2] < WORKING_Z_MM[1] - 2)
    inner &= truth[:, 2] > WORKING_Z_MM[0] + 1
    error_mm = np.linalg.norm(world_of(table, xy_light[seen]) - truth, axis=1)

    assert seen.sum() > 50
    assert error_mm[inner].max() < 1e-4
    assert error_mm.max() < 2e-3  # at the rim of the volume neighbours are missing


def test_nothing_outside_the_working_volume_is_ever_given(workshop):
    table = build_table(workshop, "right")
    rows, columns = np.nonzero(np.isfinite(table.xy_light[:, :, 0]))
    xyz_world = world_of(table, table.xy_light[rows, columns].astype(float))

    assert np.hypot(xyz_world[:, 0], xyz_world[:, 1]).max() <= WORKING_RADIUS_MM + 1e-4
    assert xyz_world[:, 2].min() > WORKING_Z_MM[0] - 1e-4
    assert xyz_world[:, 2].max() < WORKING_Z_MM[1] + 1e-4


def test_a_whole_pixel_is_read_exactly_also_at_the_rim(ideal):
    table = build_table(ideal, "left")
    rows, columns = np.nonzero(np.isfinite(table.xy_light[:, :, 0]))
    read = table.lookup(np.column_stack([columns, rows]).astype(float))

    np.testing.assert_allclose(read, table.xy_light[rows, columns], atol=1e-6)


def test_places_outside_the_frame_give_nothing(ideal):
    table = build_table(ideal, "right")
    outside = np.array([[-0.1, 100.0], [581.01, 100.0], [100.0, -0.1], [100.0, 499.2], [np.nan, 3.0]])

    assert np.isnan(table.lookup(outside)).all()


def test_the_last_corner_of_a_frame_can_be_read(ideal):
    rows, columns = np.nonzero(np.isfinite(build_table(ideal, "right").xy_light[:, :, 0]))
    width, height = int(columns[len(columns) // 2]) + 1, 500 - int(rows[len(rows) // 2])
    small = replace(ideal.camera, width_px=width, height_px=500 - height + 1)
    shifted = replace(small, principal_point_px=(small.principal_point_px[0], small.principal_point_px[1] - height + 1))
    table = build_table(replace(ideal, camera=shifted), "right")
    corner = table.lookup(np.array([[shifted.width_px - 1.0, shifted.height_px - 1.0]]))

    assert np.isfinite(corner).all()
    np.testing.assert_allclose(corner[0], table.xy_light[-1, -1], atol=1e-6)


def test_tables_come_back_from_disk_only_for_their_own_calibration(tmp_path, workshop):
    tables = {name: build_table(workshop, name) for name in LASER_NAMES}
    write_whole(tmp_path / "tables.npz", tables_bytes(tables))
    again = load_tables(tmp_path / "tables.npz", workshop)

    np.testing.assert_array_equal(again["left"].xy_light, tables["left"].xy_light)
    np.testing.assert_array_equal(again["left"].world_from_light, tables["left"].world_from_light)
    with pytest.raises(StaleTableError, match="another calibration"):
        load_tables(tmp_path / "tables.npz", replace(workshop, latency_s=0.5))


def test_a_cut_table_file_is_named(tmp_path, workshop):
    tables = {name: build_table(workshop, name) for name in LASER_NAMES}
    (tmp_path / "tables.npz").write_bytes(tables_bytes(tables)[:5000])

    with pytest.raises(InputError, match="no complete calibration tables"):
        load_tables(tmp_path / "tables.npz", workshop)


@pytest.mark.parametrize("uv", [np.zeros((5, 1)), np.zeros((2, 5)), np.zeros(2), np.zeros((3, 3))])
def test_places_of_another_shape_are_refused(ideal, uv):
    with pytest.raises(ValueError, match="places are"):
        build_table(ideal, "right").lookup(uv)


def test_no_places_give_no_points_and_a_third_laser_is_none(ideal):
    assert build_table(ideal, "right").lookup(np.empty((0, 2))).shape == (0, 2)
    with pytest.raises(ValueError, match="right or left"):
        build_table(ideal, "middle")
