"""Meshes leave closed, outward, within the chord error, as the real last, with the stub when asked."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from footscan.coordinates import Side
from footscan.errors import MeshError
from footscan.shoelast.chord import CHORD_LIMIT_MM, breaks_within, chord_error
from footscan.shoelast.handed import mirrored
from footscan.shoelast.mesh_out import mesh_of_last, save_last_mesh
from footscan.shoelast.model import Shoelast
from footscan.shoelast.skin import Sampling, even_breaks, skin_of

Tub = Callable[[Side], Shoelast]


def test_no_point_of_the_surface_is_further_from_the_mesh_than_the_bound(bare_tub: Shoelast):
    fine, error = breaks_within(bare_tub)
    mesh = skin_of(bare_tub, fine).mesh()
    rng = np.random.default_rng(3)
    u, v = rng.random(60), rng.random(40)
    xyz = np.vstack([bare_tub.upper.grid(u, v).reshape(-1, 3), bare_tub.bottom.grid(np.sort(u), v).reshape(-1, 3)])

    distance = trimesh.proximity.closest_point(mesh, xyz)[1]

    assert distance.max() <= error.bound_mm <= CHORD_LIMIT_MM
    assert distance.max() > 0.3 * error.bound_mm


def test_a_coarse_mesh_has_a_larger_chord_error(bare_tub: Shoelast):
    coarse, fine = (chord_error(bare_tub, even_breaks(Sampling(*n))) for n in ((60, 20, 6), (120, 40, 12)))

    assert coarse.along.max() == pytest.approx(4.0 * fine.along.max(), rel=0.1)
    assert coarse.bound_mm > fine.bound_mm > CHORD_LIMIT_MM


@pytest.mark.parametrize("kind", ["stl", "obj", "ply"])
@pytest.mark.parametrize("side", ["right", "left"])
def test_a_file_read_back_is_the_real_last(tub: Tub, side: Side, kind: str, tmp_path: Path):
    shoelast, path = tub(side), tmp_path / f"tub.{kind}"
    out = mesh_of_last(shoelast)

    save_last_mesh(out, path, "tub, größe 38")
    back = trimesh.load(path, force="mesh", process=False)
    back.merge_vertices()

    real = mirrored(skin_of(shoelast).xyz_shoelast, side)
    assert back.is_watertight
    assert back.is_winding_consistent
    assert back.volume == pytest.approx(skin_of(shoelast).mesh().volume, rel=1e-3)
    assert np.allclose(back.bounds, [real.min(axis=0), real.max(axis=0)], atol=CHORD_LIMIT_MM)
    assert (back.bounds[1, 1] > -back.bounds[0, 1]) == (side == "right"), "the fuller medial side has changed over"


def test_the_stub_comes_back_joined_or_apart(tub: Tub):
    shoelast = tub("left")
    bare, joined = mesh_of_last(shoelast), mesh_of_last(shoelast, "joined")
    apart = mesh_of_last(shoelast, "separate")

    added = joined.bodies["last"].volume - bare.bodies["last"].volume
    stub = apart.bodies["stub"]
    assert list(apart.bodies) == ["last", "stub"]
    assert joined.bodies["last"].is_watertight
    assert 0.1 * stub.volume < added < 0.9 * stub.volume
    assert stub.is_volume


def test_a_last_without_stub_cannot_give_one_back(bare_tub: Shoelast):
    with pytest.raises(MeshError, match="has no stub"):
        mesh_of_last(bare_tub, "joined")
