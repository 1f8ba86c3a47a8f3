"""Colours of the foot: measured, bridged and assumed skin are never of one colour."""

import json

import numpy as np
import pytest
import trimesh

from footscan.foot.skin_origin import Origin
from footscan.gui.matte import matte_glb
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


def test_the_browser_gets_a_matt_skin_of_the_colours_of_the_legend(mesh: trimesh.Trimesh) -> None:
    rgb = colours(mesh, "Seen / assumed")
    glb = matte_glb(mesh, rgb)
    length = int.from_bytes(glb[12:16], "little")
    tree = json.loads(glb[20 : 20 + length])
    primitive = tree["meshes"][0]["primitives"][0]
    view = tree["bufferViews"][tree["accessors"][primitive["attributes"]["COLOR_0"]]["bufferView"]]
    begin = 28 + length + view.get("byteOffset", 0)
    sent = np.frombuffer(glb[begin : begin + view["byteLength"]], np.uint8).reshape(len(rgb), 4)
    share = sent[:, :3] / 255.0
    on_screen = 255.0 * np.where(share <= 0.0031308, 12.92 * share, 1.055 * share ** (1 / 2.4) - 0.055)

    assert tree["materials"][primitive["material"]]["pbrMetallicRoughness"]["metallicFactor"] == 0.0
    np.testing.assert_allclose(on_screen, rgb, atol=3.0)
