import numpy as np
import pytest
import trimesh

from footscan.geometry.nearest import PointTree
from footscan.scanning.cloud import Cloud
from footscan.scanning.facing import find_facing
from footscan.scanning.matrix import ScanMatrix
from footscan.scanning.motion import WHOLE_FOOT, FrameTable, frame_table, judge_motion
from footscan.scanning.recording import FrameRecord
from footscan.scanning.zones import ZONES
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.person import STATUE, Move, Person

FRAMES = 240
STEP_RAD = 2.0 * np.pi / FRAMES
POINTS = 30000
SHEET_RAD = np.pi / 4.0
NOISE_MM = 0.05


@pytest.fixture(scope="module")
def foot():
    return build_foot(FootShape("right", 0.95))


def skin(foot, rng, moves=()):
    """Points of the skin that a machine can see, after some moves."""
    moved = Person(foot, STATUE, 0, moves).surface_at(10.0)
    mesh = trimesh.Trimesh(moved.xyz_world, moved.faces, process=False)
    at_rest = trimesh.Trimesh(foot.xyz_world, foot.faces, process=False)
    corner, share = rng.integers(len(mesh.faces), size=4 * POINTS), rng.dirichlet([1.0, 1.0, 1.0], 4 * POINTS)
    keep = rng.random(len(corner)) < np.asarray(mesh.area_faces)[corner] / 8.0
    xyz = np.einsum("nk,nkd->nd", share, np.asarray(mesh.triangles)[corner])
    seen = keep & (np.asarray(at_rest.face_normals)[corner, 2] > -0.3) & (xyz[:, 2] > 5.0) & (xyz[:, 2] < 140.0)
    return xyz[seen] + rng.normal(0.0, NOISE_MM, (int(seen.sum()), 3))


def look(xyz, laser, first_frame, turned_rad=0.0):
    """A cloud whose points were lit one after the other: (xyz, laser, frame)."""
    side = SHEET_RAD if laser == 0 else -SHEET_RAD
    theta = np.mod(np.arctan2(xyz[:, 1], xyz[:, 0]) - side, 2.0 * np.pi) + turned_rad
    return xyz, np.full(len(xyz), laser), first_frame + np.floor(theta / STEP_RAD).astype(np.int64)


def cloud_and_frames(looks, sweeps):
    """Join looks; `sweeps` are (first frame, number of frames, sweep)."""
    xyz, laser, frame = (np.concatenate([part[i] for part in looks]) for i in range(3))
    cloud = Cloud(xyz, laser, np.ones(len(xyz), np.float32), frame)
    parts = [(first + np.arange(count), STEP_RAD * (np.arange(count) + 0.5), number) for first, count, number in sweeps]
    number = np.concatenate([np.full(len(part[0]), part[2]) for part in parts])
    return cloud, FrameTable(
        np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts]), number
    )


def two_sweeps(first, second):
    looks = [look(first, 0, 0), look(second, 1, FRAMES)]
    return cloud_and_frames(looks, [(0, FRAMES, 1), (FRAMES, FRAMES, 2)])


def by_zone(result):
    return {zone.zone: zone for zone in result.zones}


def test_a_foot_that_stood_still_is_judged_still_in_every_zone(foot, rng):
    result = judge_motion(*two_sweeps(skin(foot, rng), skin(foot, rng)))

    assert result.finding is None
    assert result.not_judged == ()
    assert all(zone.moved is False and zone.displacement_mm < 0.3 for zone in result.zones)


@pytest.mark.parametrize("zone", ZONES)
def test_the_zone_that_moved_is_named_with_how_far(foot, rng, zone):
    second = skin(foot, rng, (Move(zone, (-0.9, 1.2, 0.0)),))
    finding = judge_motion(*two_sweeps(skin(foot, rng), second)).finding

    assert finding is not None
    assert finding.zone == zone
    assert finding.displacement_mm == pytest.approx(1.4, abs=0.4)
    assert finding.when == "between sweeps 1 and 2, or during one of them"


@pytest.mark.parametrize("move", [Move("foot", (1.0, 1.0, 0.0)), Move("foot", turn_rad=np.radians(1.0))])
def test_a_foot_that_moved_as_one_is_said_to_have_done_so(foot, rng, move):
    finding = judge_motion(*two_sweeps(skin(foot, rng), skin(foot, rng, (move,)))).finding

    assert finding is not None
    assert finding.zone == WHOLE_FOOT


def test_a_sheet_that_is_a_little_off_all_the_way_round_is_no_motion(foot, rng):
    off = skin(foot, rng)
    outward = off * [1.0, 1.0, 0.0] / np.hypot(off[:, 0], off[:, 1])[:, None]
    result = judge_motion(*two_sweeps(skin(foot, rng), off + 0.2 * outward))

    assert result.finding is None
    assert result.calibration_mm == pytest.approx(0.15, abs=0.06)


def test_one_laser_alone_says_nothing(foot, rng):
    result = judge_motion(*cloud_and_frames([look(skin(foot, rng), 0, 0)], [(0, FRAMES, 1)]))

    assert result.finding is None
    assert result.not_judged == ZONES


def test_a_part_that_only_one_laser_saw_is_not_judged(foot, rng):
    first, second = skin(foot, rng), skin(foot, rng)
    second = second[second[:, 0] < 60.0]
    result = judge_motion(*two_sweeps(first, second))

    assert result.not_judged == ("toes",)


def test_a_zone_that_is_not_there_is_not_missed(foot, rng):
    low = [part[part[:, 2] < 55.0] for part in (skin(foot, rng), skin(foot, rng))]
    result = judge_motion(*two_sweeps(*low))

    assert result.absent == ("ankle",)
    assert result.not_judged == ()


def seam(xyz, laser, first_frame):
    """The first 20 degrees of a pass once more, a full turn later."""
    again = look(xyz, laser, first_frame, 2.0 * np.pi)
    keep = again[2] < first_frame + FRAMES + 14
    return tuple(part[keep] for part in again)


def test_a_second_visit_by_the_same_laser_says_in_which_sweep(foot, rng):
    count = FRAMES + 14
    late = skin(foot, rng, (Move("foot", (0.0, 1.5, 0.0)),))
    looks = [look(skin(foot, rng), 0, 0), seam(late, 0, 0), look(late, 1, count), seam(late, 1, count)]
    result = judge_motion(*cloud_and_frames(looks, [(0, count, 1), (count, count, 2)]))

    assert result.finding is not None
    assert (result.finding.zone, result.finding.when) == (WHOLE_FOOT, "during sweep 1")
    assert not any(row.moved for row in result.evidence if row.when == "during sweep 2")


def test_two_sweeps_still_in_themselves_put_the_motion_between_them(foot, rng):
    count = FRAMES + 14
    first, second = skin(foot, rng), skin(foot, rng, (Move("foot", (0.0, 1.5, 0.0)),))
    looks = [look(first, 0, 0), seam(skin(foot, rng), 0, 0)]
    looks += [look(second, 1, count), seam(second, 1, count)]
    result = judge_motion(*cloud_and_frames(looks, [(0, count, 1), (count, count, 2)]))
    visits = [row for row in result.evidence if row.evidence == "same laser"]

    assert result.finding is not None
    assert result.finding.when.startswith("between sweeps 1 and 2")
    assert not any(row.moved for row in visits)


def test_lasers_in_turns_within_one_sweep_say_during_that_sweep(foot, rng):
    looks = [look(skin(foot, rng), 0, 0), look(skin(foot, rng, (Move("heel", (0.0, 2.0, 0.5)),)), 1, 0)]
    finding = judge_motion(*cloud_and_frames(looks, [(0, FRAMES, 1)])).finding

    assert finding is not None
    assert (finding.zone, finding.when) == ("heel", "during sweep 1")


def test_a_laser_that_lit_both_sweeps_is_compared_with_itself(foot, rng):
    moved = (Move("ball", (0.0, 2.0, 0.0)),)
    looks = [look(skin(foot, rng), laser, 0) for laser in (0, 1)]
    looks += [look(skin(foot, rng, moved), laser, FRAMES) for laser in (0, 1)]
    result = judge_motion(*cloud_and_frames(looks, [(0, FRAMES, 1), (FRAMES, FRAMES, 2)]))
    across = {(row.evidence, row.when) for row in result.evidence}

    assert ("same laser", "between sweeps 1 and 2") in across
    assert ("other laser", "between sweeps 1 and 2") not in across
    assert result.finding is not None
    assert (result.finding.zone, result.finding.when) == ("ball", "between sweeps 1 and 2")


def test_too_few_points_are_no_evidence(rng):
    cloud, frames = cloud_and_frames([look(rng.uniform(10, 60, (50, 3)), 0, 0)], [(0, FRAMES, 1)])

    assert judge_motion(cloud, frames).not_judged == ZONES


def test_sweeps_are_counted_by_their_direction_in_time_order():
    labels = ["ccw", "ccw", "cw", "cw", "ccw"]
    records = [FrameRecord(k, "", 10.0 + k, "right", label, "") for k, label in enumerate(labels)]
    matrix = ScanMatrix("")
    for k in (0, 2, 4):
        matrix.append(k, "right", 0.1 * k, np.zeros((1, 2)), np.ones(1))
    table = frame_table(records[::-1], matrix)

    assert table.sweep.tolist() == [1, 2, 3]
    assert table.theta_rad.tolist() == pytest.approx([0.0, 0.2, 0.4])


def test_heights_over_a_curved_surface_are_exact(rng):
    direction = rng.normal(size=(20000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    sphere, above = 30.0 * direction[:18000], 30.4 * direction[18000:]
    facing = find_facing(above, above, PointTree(sphere), sphere, 5.0)

    assert len(facing.index) > 1900
    np.testing.assert_allclose(facing.distance_mm, 0.4, atol=0.03)
    assert np.sqrt(np.mean((facing.distance_mm - 0.4) ** 2)) < 0.008
    assert np.min(np.sum(facing.normal * direction[18000:][facing.index], axis=1)) > 0.9999
