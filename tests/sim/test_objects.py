from pathlib import Path

import numpy as np
import pytest
import trimesh

from footscan.errors import InputError
from footscan.sim.objects import OBJECT_NAMES, build_cylinder, build_object, build_plate
from footscan.sim.surface import LONGEST_EDGE_MM, surface_from_trimesh, trimesh_from_surface


@pytest.mark.parametrize("name", OBJECT_NAMES)
def test_named_objects_fit_into_the_machine(name: str):
    xyz_world = build_object(name).xyz_world

    assert np.hypot(xyz_world[:, 0], xyz_world[:, 1]).max() < 200.0
    assert xyz_world[:, 2].min() >= -0.05
    assert xyz_world[:, 2].max() < 260.0


def test_mesh_file_is_read_in_its_unit_and_put_on_the_board(tmp_path: Path):
    box = trimesh.creation.box([0.25, 0.1, 0.08])
    box.apply_translation([3.0, -2.0, 1.0])
    box.export(tmp_path / "box.stl")
    surface = build_object(str(tmp_path / "box.stl"), unit="m")

    assert np.allclose(surface.xyz_world.min(axis=0), [-125.0, -50.0, 0.0], atol=1e-3)
    assert np.allclose(surface.xyz_world.max(axis=0), [125.0, 50.0, 80.0], atol=1e-3)
    assert surface.closed


def test_wrong_unit_unknown_file_empty_file_and_oversize_are_named(tmp_path: Path):
    trimesh.creation.box([0.25, 0.1, 0.08]).export(tmp_path / "box.stl")
    (tmp_path / "empty.stl").write_bytes(b"")
    with pytest.raises(InputError, match=r"0\.25 mm long when read in mm"):
        build_object(str(tmp_path / "box.stl"))
    with pytest.raises(InputError, match="found 'inch'"):
        build_object(str(tmp_path / "box.stl"), unit="inch")
    trimesh.creation.box([500.0, 100.0, 80.0]).export(tmp_path / "long.stl")
    with pytest.raises(InputError, match="spans 255 mm from the axis; at most 200 mm is seen"):
        build_object(str(tmp_path / "long.stl"))
    with pytest.raises(InputError, match="no mesh file"):
        build_object(str(tmp_path / "nothing.stl"))
    with pytest.raises(InputError, match=r"empty\.stl"):
        build_object(str(tmp_path / "empty.stl"))


def test_long_edges_are_divided_without_moving_the_surface():
    box = trimesh.creation.box([100.0, 60.0, 40.0])
    divided = trimesh_from_surface(surface_from_trimesh(box))

    assert divided.edges_unique_length.max() <= LONGEST_EDGE_MM
    assert divided.area == pytest.approx(box.area)
    assert np.allclose(divided.bounds, box.bounds)


def test_plate_is_flat_and_open():
    normal = np.array([0.6, 0.0, 0.8])
    plate = build_plate(np.array([0.0, 0.0, 100.0]), normal, 50.0)

    assert np.allclose(plate.xyz_world @ normal, 80.0)
    assert np.allclose(plate.normal_world @ normal, 1.0)
    assert not plate.closed
    assert trimesh_from_surface(plate).area == pytest.approx(100.0**2)


def test_cylinder_is_a_closed_body_of_its_formula():
    mesh = trimesh_from_surface(build_cylinder(40.0, 120.0))

    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(np.pi * 40.0**2 * 120.0, rel=2e-4)
    assert np.allclose(mesh.bounds, [[-40.0, -40.0, 0.0], [40.0, 40.0, 120.0]])
