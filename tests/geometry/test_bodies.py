import numpy as np

from footscan.geometry.bodies import label_bodies
from footscan.geometry.nearest import PointTree


def test_two_clouds_a_gap_apart_are_two_bodies_and_the_larger_is_first(rng):
    large, small = rng.uniform(0, 30, (500, 3)), rng.uniform(0, 10, (60, 3)) + np.array([80.0, 0.0, 0.0])
    body, gap = label_bodies(np.concatenate([small, large]), 5.0)

    assert set(body[60:]) == {0}
    assert set(body[:60]) == {1}
    assert np.all(gap[60:] == 0.0)
    assert 44.0 < gap[:60].min() < 58.0


def test_one_cloud_is_one_body(rng):
    body, gap = label_bodies(rng.uniform(0, 30, (500, 3)), 5.0)

    assert not body.any()
    assert not gap.any()


def test_neighbours_beyond_reach_are_marked(rng):
    distance, index = PointTree(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])).nearest(np.zeros((1, 3)), 2, 0.5)

    assert distance[0, 0] == 0.0
    assert np.isinf(distance[0, 1])
    assert index.tolist() == [[0, 2]]
