import numpy as np

from footscan.foot.bare_board import find_bare_reach
from footscan.foot.closure import ClosureRule
from footscan.foot.surface import fit_foot_surface
from tests.foot.smooth_foot_cloud import LENGTH_MM, foot_cloud

MIDDLE = (3.0, -2.0)
TURN = 2.0 * np.pi * (np.arange(90) + 0.3) / 90


def oval(turn: np.ndarray, inset_mm: float) -> np.ndarray:
    reach = 60.0 + 40.0 * np.cos(turn) ** 2 - inset_mm
    return np.array(MIDDLE) + reach[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])


def lit_board(inset_mm: float, dark=lambda turn: np.zeros(len(turn), dtype=bool)) -> np.ndarray:
    random = np.random.default_rng(3)
    turn = random.uniform(0.0, 2.0 * np.pi, 60000)
    inset = random.uniform(-40.0, inset_mm, 60000)
    rim = 60.0 + 40.0 * np.cos(turn) ** 2
    xy = np.array(MIDDLE) + (rim - inset)[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    return xy[~dark(turn)]


def test_the_end_of_the_lit_board_is_found_all_around() -> None:
    rim = oval(TURN, 0.0)
    reach = find_bare_reach(lit_board(6.0), MIDDLE, rim)

    np.testing.assert_allclose(np.linalg.norm(rim - MIDDLE, axis=1) - reach, 6.0, atol=1.0)


def test_a_turned_foot_has_the_same_lit_board_around_it() -> None:
    rim, board = oval(TURN, 0.0), lit_board(6.0)
    c, s = np.cos(0.71), np.sin(0.71)
    back = np.array([[c, s], [-s, c]])

    turned = find_bare_reach((board - MIDDLE) @ back + MIDDLE, MIDDLE, (rim - MIDDLE) @ back + MIDDLE, 0.71)

    np.testing.assert_allclose(turned, find_bare_reach(board, MIDDLE, rim), atol=1e-9)


def test_light_beyond_a_gap_and_a_few_strays_under_the_foot_are_not_board_beside_it() -> None:
    rim = oval(TURN, 0.0)
    strays = oval(np.linspace(0.0, 6.0, 40), 35.0)
    board = np.concatenate([lit_board(6.0), strays, oval(np.repeat(TURN, 20), 25.0)])
    reach = find_bare_reach(board, MIDDLE, rim)

    np.testing.assert_allclose(np.linalg.norm(rim - MIDDLE, axis=1) - reach, 6.0, atol=1.0)


def test_a_short_dark_stretch_is_bridged_from_both_sides() -> None:
    rim = oval(TURN, 0.0)
    reach = find_bare_reach(lit_board(6.0, lambda turn: (turn > 1.0) & (turn < 1.2)), MIDDLE, rim)

    np.testing.assert_allclose(np.linalg.norm(rim - MIDDLE, axis=1) - reach, 6.0, atol=1.5)


def test_a_dark_board_says_nothing() -> None:
    rim = oval(TURN, 0.0)

    assert np.isnan(find_bare_reach(np.empty((0, 2)), MIDDLE, rim)).all()
    assert np.isnan(find_bare_reach(lit_board(6.0, lambda turn: turn > 1.0), MIDDLE, rim)).all()


def test_the_bare_board_decides_how_far_out_the_sole_reaches() -> None:
    cloud = foot_cloud()
    turn, out = np.random.default_rng(5).uniform(0.0, 1.0, (2, 80000))
    low = cloud.xyz[cloud.xyz[:, 2] < 8.0][:, :2]
    middle = (low.min(axis=0) + low.max(axis=0)) / 2.0
    half = np.ptp(low, axis=0) / 2.0
    areas = []
    for inset in (2.0, 9.0):
        circle = np.column_stack([np.cos(2.0 * np.pi * turn), np.sin(2.0 * np.pi * turn)])
        board = middle + circle * (half - inset + 40.0 * out[:, None])
        surface = fit_foot_surface(cloud.xyz, cloud.weight, cloud.laser, xy_board=board)
        sole = surface.tube.grid(np.linspace(0.0, 1.0, 200, endpoint=False), np.zeros(1))[0, :, :2]
        areas.append(0.5 * abs(np.cross(sole, np.roll(sole, -1, axis=0)).sum()))

        assert surface.closure == ClosureRule("bare-board", 0.06 * surface.length_mm, 4.0 + 0.02 * surface.length_mm)
    around = 2.0 * (LENGTH_MM + 2.0 * half[1])

    assert areas[0] - areas[1] > 0.5 * 7.0 * 0.8 * around
