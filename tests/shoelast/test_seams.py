"""Patches whose rims lie on each other become one closed surface, and sound fine facets stay as they are."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from footscan.shoelast.mesh_topology import edges_of, pieces, rims
from footscan.shoelast.seams import with_closed_seams


def strip(y: np.ndarray, height: float, at: float) -> tuple[np.ndarray, np.ndarray]:
    """A standing wall of 50 mm along y at x = at, with its lower vertices at some y."""
    count = len(y)
    low, high = np.column_stack([0 * y + at, y, 0 * y]), np.column_stack([0 * y + at, y, 0 * y + height])
    a = np.arange(count - 1)
    faces = np.vstack([np.column_stack([a, a + 1, a + count]), np.column_stack([a + 1, a + 1 + count, a + count])])
    return np.vstack([low, high]), faces


@settings(max_examples=15, deadline=None)
@given(counts=st.tuples(st.integers(2, 60), st.integers(2, 60)), seed=st.integers(0, 999), gap_mm=st.floats(0.0, 0.015))
def test_two_walls_with_other_vertices_along_their_common_edge_become_one(
    counts: tuple[int, int], seed: int, gap_mm: float
):
    rng = np.random.default_rng(seed)
    walls = [
        strip(np.sort(np.r_[0.0, 50.0, rng.uniform(0, 50, n)]), sign * 5.0, 0.0)
        for n, sign in zip(counts, (1, -1), strict=True)
    ]
    (xyz, faces), (below, lower) = walls
    both = np.vstack([xyz, below + np.array([gap_mm, 0.0, 0.0])])

    joined, parts = with_closed_seams(both, np.vstack([faces, lower[:, ::-1] + len(xyz)]), 0.02, 0.05)

    assert pieces(parts)[0] == 1
    assert len(rims(parts)) == 1
    corner = joined[parts]
    area = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1).sum()
    assert area == pytest.approx(500.0, rel=0.003)


def test_facets_finer_than_the_joining_distance_are_left_alone():
    ball = trimesh.creation.icosphere(3, 0.1)

    xyz, faces = with_closed_seams(np.asarray(ball.vertices), np.asarray(ball.faces, dtype=np.int64), 0.02, 0.05)

    assert np.array_equal(faces, ball.faces)
    assert np.array_equal(xyz, ball.vertices)


def test_a_wide_gap_stays_open():
    (xyz, faces), (below, lower) = strip(np.linspace(0, 50, 9), 5.0, 0.0), strip(np.linspace(0, 50, 14), -5.0, 0.3)

    _, parts = with_closed_seams(np.vstack([xyz, below]), np.vstack([faces, lower[:, ::-1] + len(xyz)]), 0.02, 0.05)

    assert pieces(parts)[0] == 2
    assert (edges_of(parts).faces[:, 1] < 0).sum() == 2 * 9 + 2 * 14
