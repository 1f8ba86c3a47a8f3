"""Splitting long facets changes neither shape nor seams."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from footscan.shoelast.split_faces import with_short_edges


@settings(max_examples=20, deadline=None)
@given(
    size=st.tuples(st.floats(2.0, 60.0), st.floats(0.5, 40.0), st.floats(3.0, 30.0)),
    longest_mm=st.floats(1.5, 6.0),
)
def test_a_box_stays_the_same_closed_box_with_short_edges(size: tuple[float, float, float], longest_mm: float):
    box = trimesh.creation.box(extents=size)

    xyz, faces = with_short_edges(np.asarray(box.vertices), np.asarray(box.faces, dtype=np.int64), longest_mm)

    after = trimesh.Trimesh(xyz, faces, process=False)
    assert after.is_watertight
    assert after.is_winding_consistent
    assert after.edges_unique_length.max() <= longest_mm
    assert after.volume == pytest.approx(box.volume, rel=1e-9)
    assert after.area == pytest.approx(box.area, rel=1e-9)
    assert np.array_equal(xyz[:8], box.vertices)


def test_short_edges_are_left_alone():
    ball = trimesh.creation.icosphere(3, 10.0)

    xyz, faces = with_short_edges(np.asarray(ball.vertices), np.asarray(ball.faces, dtype=np.int64))

    assert len(xyz) == len(ball.vertices)
    assert np.array_equal(faces, ball.faces)
