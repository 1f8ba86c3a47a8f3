import numpy as np

from footscan.sim.cut import cut_mesh
from footscan.sim.foot import build_foot
from footscan.sim.objects import build_sphere

LAYERS = np.array([-7.0, 0.0, 3.0])


def test_cut_of_a_sphere_has_the_circumference_of_its_circle():
    ball = build_sphere(40.0, np.zeros(3))
    cut = cut_mesh(ball.xyz_world, ball.faces, LAYERS)
    length = np.hypot(cut.pieces[:, 2] - cut.pieces[:, 0], cut.pieces[:, 3] - cut.pieces[:, 1])
    around = [length[a:b].sum() for a, b in zip(cut.start[:-1], cut.start[1:], strict=True)]

    assert np.allclose(around, 2.0 * np.pi * np.sqrt(40.0**2 - LAYERS**2), rtol=1e-3)


def test_normals_of_the_pieces_point_outwards():
    ball = build_sphere(40.0, np.zeros(3))
    cut = cut_mesh(ball.xyz_world, ball.faces, np.array([3.0]))
    middle = np.column_stack([(cut.pieces[:, 0:2] + cut.pieces[:, 2:4]) / 2.0, np.full(len(cut.pieces), 3.0)])

    assert np.allclose(cut.pieces[:, 4:7], middle / 40.0, atol=0.05)


def test_cut_of_a_closed_mesh_is_closed():
    foot = build_foot()
    x_sideways = foot.xyz_world[:, [0, 2, 1]].copy()
    cut = cut_mesh(x_sideways, foot.faces, np.array([-4.0, 6.5]))
    for a, b in zip(cut.start[:-1], cut.start[1:], strict=True):
        ends, uses = np.unique(cut.pieces[a:b, 0:4].reshape(-1, 2), axis=0, return_counts=True)

        assert len(ends) > 100
        assert (uses % 2 == 0).all()


def test_plane_beside_the_mesh_cuts_nothing():
    ball = build_sphere(40.0, np.zeros(3), subdivisions=2)
    cut = cut_mesh(ball.xyz_world, ball.faces, np.array([41.0, 42.0]))

    assert len(cut.pieces) == 0
    assert cut.start.tolist() == [0, 0, 0]
