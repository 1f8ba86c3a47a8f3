"""Holes are closed as the skin around them runs in."""

import numpy as np
import trimesh

from footscan.shoelast.hole_caps import with_caps


def test_a_cap_on_a_sphere_lies_on_the_sphere_and_closes_it():
    ball = trimesh.creation.icosphere(5, 20.0)
    keep = ~(ball.triangles_center @ np.array([0.6, 0.0, 0.8]) > 18.5)

    xyz, faces, added = with_caps(ball.vertices, ball.faces[keep])
    closed = trimesh.Trimesh(xyz, faces, process=False)
    cap = xyz[len(xyz) - added :]

    assert added > 50
    assert closed.is_watertight
    assert closed.is_winding_consistent
    assert closed.volume > 0.0
    assert np.abs(np.linalg.norm(cap, axis=1) - 20.0).max() < 0.1


def test_a_small_hole_gets_a_fan():
    ball = trimesh.creation.icosphere(5, 20.0)
    keep = ~(ball.triangles_center[:, 2] > 19.95)

    xyz, faces, added = with_caps(ball.vertices, ball.faces[keep])

    assert added == 1
    assert trimesh.Trimesh(xyz, faces, process=False).is_watertight
