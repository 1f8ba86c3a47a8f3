"""A surface gets as many facets as its bend asks for, and its poles and seams stay points and lines."""

import numpy as np
import pytest
import trimesh

from footscan.shoelast.surface_facets import facets_of


def ball(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A ball of 30 mm: poles at u = 0 and 1, a seam at v = 0 and 1."""
    down, round_ = np.meshgrid(np.pi * u, 2 * np.pi * v, indexing="ij")
    return 30.0 * np.stack(
        [np.sin(down) * np.cos(round_), np.sin(down) * np.sin(round_), np.cos(down) * np.ones_like(round_)], axis=-1
    )


@pytest.mark.parametrize("chord", [0.2, 0.02])
@pytest.mark.parametrize("spans", [1, 5])
def test_no_facet_of_a_ball_lies_further_off_than_the_chord_error(chord: float, spans: int):
    breaks = np.linspace(0.0, 1.0, spans + 1)

    xyz, faces = facets_of(ball, (breaks, breaks), chord, 50.0)

    off = 30.0 - np.linalg.norm(xyz[faces].mean(axis=1), axis=1)
    assert off.max() <= chord
    assert off.max() >= 0.4 * chord, "and there are no more facets than that asks for"


def test_a_ball_closes_at_its_poles_and_its_seam():
    xyz, faces = facets_of(ball, (np.array([0.0, 1.0]), np.array([0.0, 1.0])), 0.1, 5.0)

    mesh = trimesh.Trimesh(xyz, faces)
    mesh.update_faces(mesh.nondegenerate_faces())
    assert mesh.is_watertight
    assert abs(mesh.volume) == pytest.approx(4 / 3 * np.pi * 30.0**3, rel=0.01)


def test_many_spans_of_a_flat_place_are_cut_no_further():
    def flat(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        x, y = np.meshgrid(100.0 * u, 60.0 * v, indexing="ij")
        return np.stack([x, y, np.zeros_like(x)], axis=-1)

    xyz, faces = facets_of(flat, (np.linspace(0, 1, 41), np.linspace(0, 1, 3)), 0.02, 4.0)

    assert len(faces) == 2 * 40 * 16
    assert np.ptp(xyz, axis=0).tolist() == [100.0, 60.0, 0.0]
