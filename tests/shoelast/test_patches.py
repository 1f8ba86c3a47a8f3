"""Upper, bottom and cone top share their edges exactly, and their mesh is closed."""

import numpy as np
import pytest

from footscan.foot.nurbs import SplineTube, clamped_knots
from footscan.shoelast.model import Shoelast
from footscan.shoelast.patches import LATERAL, MEDIAL, boundary_half, lower_edge, ruled_disc, upper_edge, with_boundary
from footscan.shoelast.skin import BOTTOM, CONE_TOP, UPPER, Sampling, skin_of


@pytest.fixture
def shoelast() -> Shoelast:
    """A lumpy tub: an oval below, a smaller one above."""
    turn = 2 * np.pi * np.arange(24) / 24
    rng = np.random.default_rng(5)
    rows = []
    for height, size in zip(np.linspace(0.0, 80.0, 9), np.linspace(1.0, 0.5, 9), strict=True):
        x, y = 120.0 - 120.0 * size * np.cos(turn), 45.0 * size * np.sin(turn)
        rows.append(np.column_stack([x, y, np.full(24, height)]) + rng.normal(0.0, 0.5, (24, 3)))
    upper = SplineTube(np.array(rows), clamped_knots(np.linspace(0.0, 1.0, 7)))
    breaks = np.linspace(0.0, 1.0, 5)
    return Shoelast("tub", "right", upper, ruled_disc(lower_edge(upper), breaks), ruled_disc(upper_edge(upper), breaks))


@pytest.mark.parametrize("half", [MEDIAL, LATERAL])
def test_a_disc_has_the_tubes_own_edge(shoelast: Shoelast, half: tuple[float, float]):
    share = np.linspace(0.0, 1.0, 101)
    edge = shoelast.upper.grid(half[0] + (half[1] - half[0]) * share, np.array([0.0]))[0]

    on_disc = shoelast.bottom.grid(share, np.array([1.0 if half is MEDIAL else 0.0]))[:, 0]

    assert np.abs(on_disc - edge).max() < 1e-10


def test_a_disc_follows_another_edge(shoelast: Shoelast):
    row = lower_edge(shoelast.upper) + np.array([0.0, 3.0, 1.0])

    moved = with_boundary(shoelast.bottom, row)

    assert np.abs(moved.net_mm - shoelast.bottom.net_mm - [0.0, 3.0, 1.0]).max() < 1e-9


def test_an_odd_number_of_points_round_cannot_be_halved():
    with pytest.raises(ValueError, match="even"):
        boundary_half(np.zeros((9, 3)), MEDIAL)


def test_the_mesh_is_closed_outward_and_knows_its_patches(shoelast: Shoelast):
    skin = skin_of(shoelast, Sampling(40, 12, 6))
    mesh = skin.mesh()

    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0
    assert set(skin.patch) == {UPPER, BOTTOM, CONE_TOP}
    assert np.all(mesh.face_normals[skin.patch == BOTTOM][:, 2] < 0)
    assert np.abs(shoelast.upper.grid(skin.uv[77:78, 0], skin.uv[77:78, 1])[0, 0] - skin.xyz_shoelast[77]).max() < 1e-12
