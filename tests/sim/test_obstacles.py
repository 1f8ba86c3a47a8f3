import numpy as np
import pytest

from footscan.coordinates import Side
from footscan.errors import InputError
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.machine import TrueMachine
from footscan.sim.obstacles import HEM_MM, OBSTACLES, build_obstacle, join_parts
from footscan.sim.picture import Painter
from footscan.sim.surface import Surface, trimesh_from_surface


@pytest.fixture(scope="module")
def foot() -> Surface:
    return build_foot()


@pytest.mark.parametrize("name", OBSTACLES)
def test_obstacles_are_closed_bodies_that_touch_no_foot(name: str, foot: Surface):
    for part in build_obstacle(name, foot, "left"):
        mesh = trimesh_from_surface(part.surface)

        assert mesh.is_watertight
        assert mesh.volume > 0.0
        assert not mesh.contains(foot.xyz_world[::50]).any()


def test_stand_and_handhold_stay_outside_the_working_volume(foot: Surface):
    for name in ("idle-leg", "handhold"):
        for part in build_obstacle(name, foot, "left"):
            assert np.hypot(*part.surface.xyz_world[:, :2].T).min() > 200.0


@pytest.mark.parametrize(("side", "inward"), [("left", -1.0), ("right", 1.0)])
def test_idle_leg_stands_on_the_inner_side(side: Side, inward: float):
    parts = build_obstacle("idle-leg", build_foot(FootShape(side)), side)

    assert all(np.sign(part.surface.xyz_world[:, 1].mean()) == inward for part in parts)


def test_hem_hangs_about_the_leg_and_is_widest_below(foot: Surface):
    (hem,) = build_obstacle("trouser-hem", foot, "left")
    xyz_world = hem.surface.xyz_world
    low, high = xyz_world[xyz_world[:, 2] < HEM_MM[0] + 1.0], xyz_world[xyz_world[:, 2] > HEM_MM[1]]

    assert xyz_world[:, 2].min() == pytest.approx(HEM_MM[0])
    assert np.ptp(low[:, 0]) > np.ptp(high[:, 0]) + 15.0


def test_obstacles_hide_the_foot_at_some_angles_and_not_at_others(machine: TrueMachine, foot: Surface):
    parts = build_obstacle("idle-leg", foot, "left")
    joined, tone = join_parts(foot, parts)
    alone, beside = Painter(machine.calibration, foot), Painter(machine.calibration, joined, tone=tone)
    free = [float(alone.paint_light(theta, ("right", "left"))[150:].sum()) for theta in (np.pi / 2, -np.pi / 2)]
    cut = [float(beside.paint_light(theta, ("right", "left"))[150:].sum()) for theta in (np.pi / 2, -np.pi / 2)]

    assert cut[0] == pytest.approx(free[0], rel=0.02)
    assert cut[1] < 0.9 * free[1]


def test_joined_faces_begin_with_those_of_the_foot(foot: Surface):
    joined, tone = join_parts(foot, build_obstacle("handhold", foot, "left"))

    assert np.array_equal(joined.faces[: len(foot.faces)], foot.faces)
    assert (tone[: len(foot.faces)] == 1.0).all()
    assert (tone[len(foot.faces) :] < 1.0).all()


def test_unknown_obstacles_and_a_hem_without_a_leg_are_named(foot: Surface):
    low = Surface(foot.xyz_world * np.array([1.0, 1.0, 0.5]), foot.faces)
    with pytest.raises(InputError, match="one of idle-leg, handhold, trouser-hem; found 'dog'"):
        build_obstacle("dog", foot, "left")
    with pytest.raises(InputError, match="needs a leg up to 204 mm"):
        build_obstacle("trouser-hem", low, "left")
