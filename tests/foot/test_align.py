import numpy as np
import pytest
import trimesh

from footscan.errors import MeshError
from footscan.foot.align import align_foot
from footscan.foot.girth import find_smallest
from footscan.foot.landmarks import find_landmarks
from footscan.foot.repair import repair_shell
from footscan.foot.shell import Shell, shell_from_mesh
from footscan.foot.standing import stand


def turned(xyz, degrees):
    return xyz @ trimesh.transformations.rotation_matrix(np.radians(degrees), [0, 0, 1])[:3, :3].T


def heading_deg(alignment):
    return np.degrees(np.arctan2(alignment.foot_from_input[0, 1], alignment.foot_from_input[0, 0])) % 360.0


@pytest.mark.parametrize("axis", ["A1", "A2", "A4", "A5"])
def test_an_aligned_foot_stays_aligned(foot, axis):
    shell = shell_from_mesh(foot)
    first = align_foot(shell, "right", axis)
    again = Shell(shell.xyz @ first.foot_from_input[:3, :3].T + first.foot_from_input[:3, 3], shell.faces)

    assert align_foot(again, "right", axis).foot_from_input == pytest.approx(np.eye(4), abs=1e-6)


@pytest.mark.parametrize("degrees", [0.0, 33.0, 95.0, 178.0, 270.0, 340.0])
def test_a_cloud_without_faces_is_found_like_the_mesh(foot, degrees):
    dense = foot.subdivide()
    cloud = Shell(turned(np.array(dense.vertices), degrees), np.zeros((0, 3), dtype=np.int64))
    mesh = shell_from_mesh(foot)

    found, expected = align_foot(cloud, "right"), align_foot(mesh, "right")

    assert found.shape_side == "right"
    assert (heading_deg(found) - heading_deg(expected) - degrees + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=1.5)
    assert found.length_mm == pytest.approx(expected.length_mm, abs=1.0)


def test_heel_is_at_the_origin_and_toes_point_to_x(foot):
    alignment = align_foot(shell_from_mesh(foot), "right")

    assert alignment.outline.xy[:, 0].min() == pytest.approx(0.0, abs=1e-9)
    assert alignment.outline.xy[:, 0].max() == pytest.approx(alignment.length_mm)
    assert alignment.foot_from_input[2] == pytest.approx([0.0, 0.0, 1.0, 0.0])


def test_medial_is_positive_y_for_both_feet(foot):
    right = shell_from_mesh(foot)
    left = Shell(right.xyz * [1.0, -1.0, 1.0], np.ascontiguousarray(right.faces[:, ::-1]))

    for shell, side in ((right, "right"), (left, "left")):
        standing = stand(shell, align_foot(shell, side), {}, ())
        marks, _ = find_landmarks(standing)
        assert marks["metatarsale_tibiale"].xyz_foot[1] > 0 > marks["metatarsale_fibulare"].xyz_foot[1]
        assert marks["metatarsale_tibiale"].xyz_foot[0] > marks["metatarsale_fibulare"].xyz_foot[0]


def test_the_default_axis_runs_midway_between_the_metatarsal_heads(foot):
    shell = shell_from_mesh(foot)
    marks, _ = find_landmarks(stand(shell, align_foot(shell, "right"), {}, ()))

    middle = marks["metatarsale_tibiale"].xyz_foot[1] + marks["metatarsale_fibulare"].xyz_foot[1]
    assert middle == pytest.approx(0.0, abs=1e-6)


def test_the_medial_tangent_touches_heel_and_ball_and_nothing_is_beyond(foot):
    alignment = align_foot(shell_from_mesh(foot), "right", "A5")

    y = alignment.outline.xy[:, 1]
    touching = alignment.outline.xy[y > y.max() - 1e-6, 0]
    assert touching.min() < 0.3 * alignment.length_mm
    assert touching.max() > 0.5 * alignment.length_mm


def test_heads_given_by_hand_turn_the_axis(foot):
    shell = shell_from_mesh(foot)
    heads = {
        "metatarsale_tibiale": np.array([190.0, 65.0, 15.0]),
        "metatarsale_fibulare": np.array([160.0, -35.0, 10.0]),
    }

    alignment = align_foot(shell, "right", given=heads)

    ends = [alignment.foot_from_input[:3, :3] @ xyz + alignment.foot_from_input[:3, 3] for xyz in heads.values()]
    assert ends[0][1] + ends[1][1] == pytest.approx(0.0, abs=1e-6)


def test_a_foot_far_from_z_0_raises_a_question_and_is_not_moved(foot):
    lifted = shell_from_mesh(foot.copy().apply_translation([0.0, 0.0, 15.0]))

    alignment = align_foot(lifted, "right")

    assert any("is z = 0 the board" in question for question in alignment.questions)
    assert alignment.foot_from_input[2, 3] == 0.0


def test_two_feet_grown_together_are_refused(foot):
    xyz = np.concatenate([foot.vertices, foot.vertices * [1.0, -1.0, 1.0] + [0.0, 103.0, 0.0]])
    pair = Shell(xyz, np.concatenate([foot.faces, foot.faces[:, ::-1] + len(foot.vertices)]))

    with pytest.raises(MeshError, match="too broad for one foot"):
        align_foot(pair, "right")


def test_a_shape_that_tells_no_side_needs_the_operator(foot):
    xyz = np.array(foot.vertices)
    even = trimesh.Trimesh(xyz, foot.faces, process=False)
    mirrored = trimesh.Trimesh(xyz * [1.0, -1.0, 1.0], foot.faces[:, ::-1], process=False)
    both = np.concatenate([even.vertices, mirrored.vertices])
    shell = Shell(both, np.zeros((0, 3), dtype=np.int64))

    assert align_foot(shell, "left").shape_side is None
    with pytest.raises(MeshError, match="say which side"):
        align_foot(shell)


def test_a_handful_of_points_is_no_foot():
    with pytest.raises(MeshError, match="5 points"):
        align_foot(Shell(np.zeros((5, 3)), np.zeros((0, 3), dtype=np.int64)), "right")


def test_the_smallest_place_inside_a_band_is_found_to_a_ten_thousandth():
    place, value, at_end = find_smallest(lambda x: 3.0 + (x - 0.37) ** 2, (0.0, 1.0))

    assert place == pytest.approx(0.37, abs=1e-4)
    assert value == pytest.approx(3.0, abs=1e-8)
    assert not at_end


@pytest.mark.parametrize("measure", [lambda x: 5.0 + x, lambda x: 5.0 - x, lambda _: 5.0])
def test_the_end_of_a_band_and_a_flat_band_are_no_minimum(measure):
    assert find_smallest(measure, (0.0, 1.0))[2]


def test_repair_leaves_the_arrays_it_was_given(foot):
    shell = shell_from_mesh(foot)
    before = shell.xyz.copy()

    repair_shell(shell)

    assert np.array_equal(shell.xyz, before)
