"""Colours of the foot: measured, bridged and assumed skin are never of one colour."""

import numpy as np
import pytest
import trimesh

from footscan.foot.skin_origin import Origin
from footscan.gui.view_foot import colours


@pytest.fixture
def mesh() -> trimesh.Trimesh:
    mesh = trimesh.creation.icosahedron()
    origin = np.full(12, Origin.SEEN)
    origin[4:8], origin[8:] = Origin.BRIDGED, Origin.ASSUMED_SOLE
    residual = np.linspace(0.0, 0.5, 12)
    residual[8:] = np.nan
    mesh.vertex_attributes.update(origin=origin, residual_mm=residual)
    return mesh


def test_seen_bridged_and_assumed_have_three_colours(mesh: trimesh.Trimesh) -> None:
    rgb = colours(mesh, "Seen / assumed")

    assert len({tuple(colour) for colour in rgb}) == 3
    assert len({tuple(colour) for colour in rgb[:4]}) == 1


def test_skin_without_points_has_no_colour_of_a_distance(mesh: trimesh.Trimesh) -> None:
    rgb = colours(mesh, "Distance to points")

    assert tuple(rgb[0]) == (32, 96, 255)
    assert len({tuple(colour) for colour in rgb[8:]}) == 1
    assert tuple(rgb[8]) not in {tuple(colour) for colour in rgb[:8]}


def test_shaded_skin_is_of_one_colour(mesh: trimesh.Trimesh) -> None:
    assert len(np.unique(colours(mesh, "Shaded"), axis=0)) == 1
