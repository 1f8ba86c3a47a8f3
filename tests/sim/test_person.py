import numpy as np
import pytest

from footscan.errors import InputError
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.person import CALM, RESTLESS, STATUE, Move, Person, PersonSettings
from footscan.sim.person_parts import PARTS, find_frame, part_weights
from footscan.sim.surface import Surface

MOMENTS_S = np.arange(0.0, 30.0, 0.5)


@pytest.fixture(scope="module")
def foot() -> Surface:
    return build_foot(FootShape("right", 0.9))


@pytest.fixture(scope="module")
def weights(foot):
    return part_weights(foot.xyz_world, find_frame(foot.xyz_world))


def ways_mm(person: Person, moments=MOMENTS_S):
    return np.array([np.linalg.norm(person.xyz_world_at(t) - person.surface.xyz_world, axis=1) for t in moments])


def after(foot, move: Move):
    return Person(foot, STATUE, 0, (move,)).xyz_world_at(10.0) - foot.xyz_world


@pytest.mark.parametrize("heading_deg", [0.0, 70.0, 180.0, 300.0])
def test_heel_and_toes_are_found_whatever_the_heading(foot, heading_deg):
    a = np.radians(heading_deg)
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    frame = find_frame(foot.xyz_world @ turn.T + np.array([20.0, -10.0, 0.0]))

    assert frame.length_mm == pytest.approx(0.9 * 253.0, abs=2.0)
    assert frame.axis_xy_world @ turn[:2, 0] > 0.99


def test_parts_share_the_skin_between_them(weights):
    total = sum(weights[part] for part in PARTS if part != "foot")

    np.testing.assert_allclose(total, 1.0, atol=1e-12)
    assert all(weights[part].min() >= 0.0 and weights[part].max() == pytest.approx(1.0, abs=0.01) for part in PARTS)


def test_a_statue_stands_still(foot):
    assert np.array_equal(Person(foot, STATUE).xyz_world_at(3.0), foot.xyz_world)


def test_the_leg_sways_about_a_degree_and_the_sole_does_not(foot, weights):
    person = Person(foot, PersonSettings(drift_mm=0, turn_rad=0, lean_mm=0, sink_mm=0, arch_mm=0, twitch_mm=0), 4)
    way = ways_mm(person)
    top = foot.xyz_world[:, 2] > 200.0
    lever_mm = 220.0 - 0.2 * person.frame.length_mm

    assert 0.3 * np.radians(1.0) * lever_mm < way[:, top].max() <= np.radians(1.0) * lever_mm * 1.2
    assert way[:, foot.xyz_world[:, 2] < 20.0].max() == 0.0


def test_the_foot_drifts_up_to_two_millimetres_as_one_piece(foot):
    person = Person(foot, PersonSettings(0, 2.0, 0, 0, 0, 0, 0), 4)
    way = ways_mm(person, np.arange(0.0, 120.0, 1.0))

    assert np.ptp(way, axis=1).max() < 1e-9
    assert 1.0 < way.max() <= 2.0


def test_weight_shift_never_pushes_the_sole_through_the_board(foot):
    person = Person(foot, PersonSettings(0, 0, 0, 0.6, 0.4, 0.6, 0), 4)

    assert min(person.xyz_world_at(t)[:, 2].min() for t in MOMENTS_S) > -0.02
    assert max(ways_mm(person).max(axis=1)) > 0.3


def test_toes_twitch_now_and_then_and_rest_in_between(foot, weights):
    person = Person(foot, PersonSettings(0, 0, 0, 0, 0, 0, 1.5), 4)
    moments = np.arange(0.0, 24.0, 0.05)
    tip = ways_mm(person, moments)[:, weights["toes"] > 0.95].max(axis=1)

    assert 0.7 < tip.max() < 2.0
    assert 0.02 < (tip > 0.0).mean() < 0.1
    assert ways_mm(person)[:, weights["heel"] > 0.5].max() == 0.0


def test_a_calm_person_moves_by_about_a_tenth_of_a_millimetre(foot):
    way = ways_mm(Person(foot, CALM, 9))

    assert 0.02 < np.sqrt(np.mean(way**2)) < 0.12
    assert way.max() < 0.3


def test_skin_is_a_smooth_and_pure_function_of_time(foot):
    person, again = Person(foot, RESTLESS, 5), Person(foot, RESTLESS, 5)
    dt = 1e-3
    path = np.array([person.xyz_world_at(2.0 + k * dt) for k in range(3)])
    speed = np.linalg.norm(np.diff(path, axis=0), axis=2) / dt

    assert np.array_equal(person.xyz_world_at(7.0), again.xyz_world_at(7.0))
    assert not np.array_equal(person.xyz_world_at(7.0), Person(foot, RESTLESS, 6).xyz_world_at(7.0))
    assert speed.max() < 60.0  # mm/s
    assert np.abs(np.diff(speed, axis=0)).max() < 1.0


@pytest.mark.parametrize("part", PARTS)
def test_a_told_part_moves_by_what_was_told_and_stays_so(foot, weights, part):
    person = Person(foot, STATUE, 0, (Move(part, (2.0, 0.0, 0.0), at_s=5.0),))
    moved = after(foot, Move(part, (2.0, 0.0, 0.0), at_s=5.0))
    core = weights[part] > 0.99

    assert np.array_equal(person.xyz_world_at(5.0), foot.xyz_world)
    np.testing.assert_allclose(moved[core] @ person.frame.along, 2.0, atol=0.03)
    assert np.linalg.norm(moved, axis=1).max() <= 2.0 + 1e-9
    np.testing.assert_allclose(np.linalg.norm(moved, axis=1), 2.0 * weights[part], atol=1e-9)


def test_neighbouring_skin_moves_nearly_alike_at_a_border(foot):
    moved = after(foot, Move("ball", (0.0, 3.0, 0.0)))
    edge = foot.faces[:, [0, 1]]
    length = np.linalg.norm(foot.xyz_world[edge[:, 0]] - foot.xyz_world[edge[:, 1]], axis=1)
    stretch = np.linalg.norm(moved[edge[:, 0]] - moved[edge[:, 1]], axis=1)

    assert np.max(stretch - 0.2 * length) < 1e-9


def test_a_degree_of_the_leg_is_a_degree(foot):
    moved = after(foot, Move("ankle", turn_rad=np.radians(1.0)))
    top = foot.xyz_world[:, 2] > 180.0
    lever_mm = foot.xyz_world[top, 2] - 0.2 * find_frame(foot.xyz_world).length_mm
    forward = moved[top] @ find_frame(foot.xyz_world).along

    np.testing.assert_allclose(forward, np.sin(np.radians(1.0)) * lever_mm, atol=0.02)


def test_impossible_moves_are_refused(foot):
    with pytest.raises(InputError, match="found 'nose'"):
        Person(foot, CALM, 0, (Move("nose"),))  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match="takes time"):
        Person(foot, CALM, 0, (Move("toes", lasts_s=0.0),))
