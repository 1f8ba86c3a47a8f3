"""Signed distances to a mesh are exact, inside, outside, at sides and corners."""

import numpy as np
import pytest
import trimesh

from footscan.geometry.mesh_distance import DistanceMesh

RNG = np.random.default_rng(3)


def _mesh(solid: trimesh.Trimesh) -> DistanceMesh:
    return DistanceMesh(np.asarray(solid.vertices), np.asarray(solid.faces))


def _box_distance(points: np.ndarray, half: np.ndarray) -> np.ndarray:
    beyond = np.abs(points) - half
    return np.linalg.norm(np.maximum(beyond, 0.0), axis=1) + np.minimum(beyond.max(axis=1), 0.0)


def test_distances_to_a_box_are_those_of_its_formula():
    points = RNG.uniform(-80.0, 80.0, (3000, 3))
    mesh = _mesh(trimesh.creation.box((100.0, 60.0, 40.0)))

    near = mesh.nearest(points)

    assert np.abs(near.signed - _box_distance(points, np.array([50.0, 30.0, 20.0]))).max() < 1e-12
    assert np.abs(np.linalg.norm(points - near.xyz, axis=1) - np.abs(near.signed)).max() < 1e-12


def test_the_nearest_place_lies_on_the_named_face():
    solid = trimesh.creation.icosphere(subdivisions=4, radius=30.0)
    near = _mesh(solid).nearest(RNG.normal(0.0, 25.0, (2000, 3)))

    on_face = np.einsum("nk,nkc->nc", near.weight, solid.vertices[solid.faces[near.face]])

    assert np.abs(on_face - near.xyz).max() < 1e-12
    assert near.weight.min() > -1e-12


@pytest.mark.parametrize("radius", [10.0, 29.0, 31.0, 60.0])
def test_a_ball_has_its_own_distance_everywhere(radius: float):
    points = RNG.normal(size=(1500, 3))
    points *= radius / np.linalg.norm(points, axis=1, keepdims=True)
    solid = trimesh.creation.icosphere(subdivisions=5, radius=30.0)

    signed = _mesh(solid).nearest(points).signed

    assert np.abs(signed - (radius - 30.0)).max() < 0.02


def test_beside_a_thin_edge_inside_and_outside_are_told_apart():
    wedge = trimesh.Trimesh(
        [[0, 0, 0], [10, 0, 0], [10, 0, 0.05], [0, 10, 0], [10, 10, 0], [10, 10, 0.05]],
        [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [0, 3, 5], [0, 5, 2], [1, 2, 5], [1, 5, 4]],
        process=False,
    )
    wedge.fix_normals()
    mesh = _mesh(wedge)

    signed = mesh.nearest(np.array([[-0.1, 5.0, 0.0], [9.0, 5.0, 0.02], [9.0, 5.0, 0.2], [9.0, 5.0, -0.1]])).signed

    assert list(np.sign(signed)) == [1.0, -1.0, 1.0, 1.0]
    assert abs(signed[0] - 0.1) < 1e-3


def test_a_moved_mesh_gives_the_distances_of_a_new_one():
    solid = trimesh.creation.icosphere(subdivisions=4, radius=30.0)
    points = RNG.normal(0.0, 25.0, (1000, 3))
    stretched = np.asarray(solid.vertices) * np.array([1.3, 1.0, 0.8])

    moved = _mesh(solid).moved(stretched).nearest(points)

    fresh = DistanceMesh(stretched, np.asarray(solid.faces)).nearest(points)
    assert np.abs(moved.signed - fresh.signed).max() < 1e-12
