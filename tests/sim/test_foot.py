import numpy as np
import pytest

from footscan.errors import InputError
from footscan.sim.foot import LEG_TOP_MM, FootShape, build_foot
from footscan.sim.surface import trimesh_from_surface


@pytest.mark.parametrize("size", [0.45, 0.62, 0.77, 0.9, 1.0, 1.11, 1.2])
def test_foot_is_a_closed_body_of_the_size_asked_for(size: float):
    mesh = trimesh_from_surface(build_foot(FootShape("right", size)))
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)

    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0.0
    assert mesh.euler_number == 2
    assert high[0] - low[0] == pytest.approx(251.0 * size, abs=2.0)
    assert low[2] == pytest.approx(0.0, abs=0.05)
    assert high[2] == pytest.approx(LEG_TOP_MM, abs=0.5)
    assert 20_000 <= len(mesh.faces) <= 50_000


def test_left_foot_is_the_mirror_image_of_the_right_one():
    left, right = build_foot(FootShape("left")), build_foot(FootShape("right"))
    mirrored = trimesh_from_surface(left)

    assert np.allclose(left.xyz_world * [1.0, -1.0, 1.0], right.xyz_world)
    assert mirrored.volume == pytest.approx(trimesh_from_surface(right).volume)


def test_big_toe_of_a_left_foot_lies_on_its_right():
    xyz_world = build_foot(FootShape("left")).xyz_world
    tip = xyz_world[np.argmax(xyz_world[:, 0])]

    assert tip[1] < -10.0


def heights_of_the_arch(arch: float) -> float:
    """Height of the hollow under the inner border at midfoot."""
    xyz = build_foot(FootShape("right", arch=arch)).xyz_world
    under = xyz[(np.abs(xyz[:, 0] + 10.0) < 4.0) & (np.abs(xyz[:, 1] - 24.0) < 3.0)]
    return float(under[:, 2].min())


def test_arch_rises_with_its_parameter():
    flat, usual, high = (heights_of_the_arch(arch) for arch in (0.0, 1.0, 1.5))

    assert flat < 2.5
    assert flat + 3.0 < usual < high - 3.0


def test_heel_and_ball_stand_on_the_board():
    xyz = build_foot().xyz_world
    sole = xyz[xyz[:, 2] < 0.3]

    assert np.sum(sole[:, 0] < -80.0) > 100
    assert np.sum(sole[:, 0] > 30.0) > 100


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        (FootShape(size=0.2), "0.45 to 1.2"),
        (FootShape(arch=3.0), "0 .flat. to 1.5"),
        (FootShape(hallux_valgus_rad=1.0), "0 to 28 degrees"),
    ],
)
def test_impossible_foot_is_refused_with_what_is_allowed(shape: FootShape, words: str):
    with pytest.raises(InputError, match=words):
        build_foot(shape)


@pytest.mark.parametrize("missing", [(2,), (1, 2, 3, 4, 5)])
def test_amputated_toes_leave_a_closed_foot_of_one_piece(missing: tuple[int, ...]):
    whole, foot = trimesh_from_surface(build_foot()), trimesh_from_surface(build_foot(FootShape(missing_toes=missing)))

    assert foot.is_watertight
    assert len(foot.split(only_watertight=False)) == 1
    assert foot.volume < whole.volume - 5_000.0


def test_a_sixth_toe_is_refused():
    with pytest.raises(InputError, match="numbers 1"):
        build_foot(FootShape(missing_toes=(6,)))
