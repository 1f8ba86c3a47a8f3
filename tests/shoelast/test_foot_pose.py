"""A flat foot is bent on to a last: sections keep their area, joints obey, and what cannot be bent is refused."""

import numpy as np
import pytest

from footscan.errors import QualityError
from footscan.foot.sole_bend import BentFoot
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.foot_pose import UNPROVEN, InsoleStack, ball_place, bottom_line, pose_foot
from footscan.shoelast.foot_pose_joints import Joints
from footscan.shoelast.model import Shoelast
from footscan.shoelast.prepared_foot import PreparedFoot, prepare_foot
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import trimesh_from_surface
from footscan.sim.wedge import raise_heel


@pytest.fixture(scope="module")
def foot() -> PreparedFoot:
    return prepare_foot(trimesh_from_surface(build_foot(FootShape("right", 1.0))), "right")


@pytest.fixture(scope="module")
def shoelast() -> Shoelast:
    return build_shoelast("men", 40.0, "g", 25.0)


def test_sections_across_keep_their_area_and_the_sole_nearly_its_length(foot: PreparedFoot, shoelast: Shoelast):
    changes = pose_foot(foot, shoelast).changes

    assert max(abs(value) for name, value in changes.items() if name.startswith("section_area")) < 0.02
    assert abs(changes["sole_mm"]) < 6.0
    assert abs(changes["volume_share"]) < 0.02


def test_the_dorsum_bends_without_a_crease(foot: PreparedFoot, shoelast: Shoelast):
    line = np.column_stack([np.linspace(150.0, 225.0, 151), np.zeros(151), np.full(151, 45.0)])
    posed = pose_foot(foot, shoelast)
    bent = BentFoot(posed.bend, ball_place(foot), 20.0, foot.value("foot_length"), 260.0)(line)

    step = np.diff(bent, axis=0)
    turn = np.abs(np.diff(np.arctan2(step[:, 2], step[:, 0])))
    assert np.linalg.norm(step, axis=1).min() > 0.5 * 0.6
    assert turn.max() < np.radians(0.6)


def test_heel_and_ball_lie_on_the_insole(foot: PreparedFoot, shoelast: Shoelast):
    posed = pose_foot(foot, shoelast, InsoleStack(6.0, 4.0, 3.0, 3.0))
    line = bottom_line(shoelast)
    sole = posed.shell.xyz[foot.shell.xyz[:, 2] < 0.5]

    gap = sole[:, 2] - np.interp(sole[:, 0], line[:, 0], line[:, 2])

    heel, ball = sole[:, 0] < 50.0, np.abs(sole[:, 0] - posed.points["metatarsale_tibiale"][0]) < 15.0
    assert np.median(gap[heel]) == pytest.approx(6.0, abs=1.0)
    assert np.median(gap[ball]) == pytest.approx(3.0, abs=1.0)


def test_a_fused_joint_does_not_bend_and_it_is_said(foot: PreparedFoot, shoelast: Shoelast):
    posed = pose_foot(foot, shoelast, joints=Joints(mtp="fused", hallux="limited"))

    assert posed.bend.joint_rad[1] == 0.0
    assert abs(posed.bend.joint_rad[2]) <= np.radians(6.0) + 1e-9
    assert any("mtp fused" in remark for remark in posed.remarks)
    assert UNPROVEN in posed.remarks


def test_a_flat_scan_is_not_bent_to_a_pitch_of_50_mm(foot: PreparedFoot):
    high = build_shoelast("women", 40.0, "g", 50.0)

    with pytest.raises(QualityError, match="at most 35 mm"):
        pose_foot(foot, high)


@pytest.fixture(scope="module")
def on_wedge() -> PreparedFoot:
    raised = raise_heel(build_foot(FootShape("right", 1.0)), "right", 50.0)
    return prepare_foot(trimesh_from_surface(raised.surface), "right", wedge=50.0)


def test_a_scan_on_a_wedge_is_bent_only_by_the_difference(on_wedge: PreparedFoot):
    posed = pose_foot(on_wedge, build_shoelast("women", 40.0, "g", 50.0))

    assert abs(posed.changes["dorsum_over_ball_mm"]) < 0.5
    assert abs(posed.changes["sole_mm"]) < 2.0
    assert any("scanned on a wedge of 50 mm" in remark for remark in posed.remarks)
    assert UNPROVEN not in posed.remarks


def test_a_scan_on_a_wedge_is_refused_for_a_last_of_another_pitch(on_wedge: PreparedFoot):
    with pytest.raises(QualityError, match="Take a last with a pitch of 35 to 65 mm"):
        pose_foot(on_wedge, build_shoelast("women", 40.0, "g", 25.0))


def test_places_of_a_foot_on_a_wedge_go_to_its_frame_and_back(on_wedge: PreparedFoot):
    for name, xyz in on_wedge.points.items():
        scanned = on_wedge.measurements.landmarks[name].xyz

        assert on_wedge.frame.to_input(xyz[None])[0] == pytest.approx(scanned, abs=1e-5), name
