"""Text is cut into the cone top, as deep as stated, readable on either side, and refused when it does not fit."""

from collections.abc import Callable

import numpy as np
import pytest
import trimesh

from footscan.coordinates import Side
from footscan.errors import InputError
from footscan.geometry.raster import front_facets
from footscan.shoelast.engraving import CAP_HEIGHTS_MM, DEPTH_MM, engrave
from footscan.shoelast.mesh_out import mesh_of_last
from footscan.shoelast.model import Shoelast

_PIXEL_MM = 0.1
Tub = Callable[[Side], Shoelast]


def _depths(before: trimesh.Trimesh, after: trimesh.Trimesh) -> tuple[np.ndarray, np.ndarray]:
    """Places (x, y) around the middle of the cone top and how much lower the surface is there."""
    low, shape = np.array([115.0, -10.0]), (200, 250)
    rows, columns = np.indices(shape)
    places = low + _PIXEL_MM * (np.stack([columns, rows], axis=-1) + 0.5)
    heights = []
    for mesh in (before, after):
        corners = np.asarray(mesh.triangles)
        facet = front_facets(corners, low, _PIXEL_MM, shape)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[facet]
        flat = (normal[..., :2] * (places - corners[facet, 0, :2])).sum(axis=-1) / normal[..., 2]
        heights.append(corners[facet, 0, 2] - flat)
    return places.reshape(-1, 2), (heights[0] - heights[1]).ravel()


@pytest.mark.parametrize("side", ["right", "left"])
def test_letters_are_cut_as_deep_as_stated_and_read_from_heel_to_toe(tub: Tub, side: Side):
    shoelast = tub(side)
    body = mesh_of_last(shoelast, limit_mm=0.2).bodies["last"]

    cut, said = engrave(body, shoelast, "L")
    places, depth = _depths(body, cut)

    lower = depth > 0.01
    assert cut.is_watertight
    assert cut.is_winding_consistent
    assert np.allclose(depth[lower], DEPTH_MM, atol=0.02)
    assert said.volume_mm3 == pytest.approx(lower.sum() * _PIXEL_MM**2 * DEPTH_MM, rel=0.05)
    x, y = (places[lower] - places[lower].min(axis=0)).T
    stem, foot = x < 0.3 * x.max(), y < 0.25 * y.max()
    assert stem.sum() + foot.sum() > len(x), "an L has its stem at the heel end and its foot to the right of the reader"
    assert not np.any((x > 0.5 * x.max()) & (y > 0.5 * y.max()))


def test_letters_are_as_large_as_fits(tub: Tub):
    shoelast = tub("right")
    body = mesh_of_last(shoelast, limit_mm=0.2).bodies["last"]

    short, long = engrave(body, shoelast, "A17 R 42")[1], engrave(body, shoelast, "A17-20261126 R 42 G 15 mm")[1]

    assert short.cap_height_mm == pytest.approx(CAP_HEIGHTS_MM[1])
    assert CAP_HEIGHTS_MM[0] <= long.cap_height_mm < short.cap_height_mm


@pytest.mark.parametrize(("text", "said"), [("  ", "empty"), ("A" * 80, "does not fit"), ("Fuß \u5927", "has no '大'")])
def test_a_text_that_cannot_be_cut_is_refused(bare_tub: Shoelast, text: str, said: str):
    body = mesh_of_last(bare_tub, limit_mm=0.2).bodies["last"]

    with pytest.raises(InputError, match=said):
        engrave(body, bare_tub, text)
