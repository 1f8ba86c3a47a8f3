"""An edge that a hole interrupts is led across as it runs on either side."""

import numpy as np
import pytest

from footscan.shoelast.bridged_edge import edges_across_holes

ANGLE = 2 * np.pi * np.arange(600) / 600
ROUND = np.column_stack([60.0 * np.cos(ANGLE), 40.0 * np.sin(ANGLE), 5.0 * np.cos(2 * ANGLE)])


@pytest.mark.parametrize("first", [100, 590])
def test_the_line_across_is_the_one_that_was_there(first: int):
    places = (first + np.arange(15)) % 600
    around_hole = ROUND.copy()
    around_hole[places[1:-1]] += np.array([1.0, 2.0, -3.0]) * np.sin(np.linspace(0.3, 2.8, 13))[:, None]
    at_hole = np.zeros(600, dtype=np.bool_)
    at_hole[places] = True

    moved, length = edges_across_holes(around_hole, np.arange(600), at_hole)

    assert np.abs(moved - ROUND).max() < 0.05
    assert length == pytest.approx(np.linalg.norm(np.diff(ROUND[places], axis=0), axis=1).sum(), rel=0.01)


def test_without_a_hole_and_across_a_very_long_one_nothing_moves():
    for at_hole in (np.zeros(600, dtype=np.bool_), np.arange(600) < 200):
        moved, length = edges_across_holes(ROUND, np.arange(600), at_hole)

        assert np.array_equal(moved, ROUND)
        assert length == 0.0
