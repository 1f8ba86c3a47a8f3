"""Cleaning, board check, agreement and merge on clouds whose truth is a formula."""

import numpy as np
import pytest

from footscan.errors import InputError
from footscan.geometry.plane import Plane
from footscan.scanning.agreement import agreement_by_zone, find_overlap, merge_lasers
from footscan.scanning.cleaning import clean_cloud
from footscan.scanning.cloud import Cloud
from footscan.scanning.footboard import check_board
from footscan.scanning.point_file import load_bare_board, load_points, save_bare_board, save_points
from footscan.scanning.zones import ZONES, direction_from_core, zone_of_points

FLOOR = Plane((0.0, 0.0, 1.0), 0.0)


def cloud_of(xyz_world, laser=0, weight=0.5):
    n = len(xyz_world)
    codes = np.broadcast_to(laser, n).astype(np.int64)
    return Cloud(np.asarray(xyz_world), codes, np.full(n, weight, np.float32), np.zeros(n, np.int64))


def dome(rng, n, noise=0.02):
    """A loaf 240 mm long standing on the board, its higher end the heel at negative x."""
    s, a = rng.uniform(-1, 1, n), rng.uniform(0, np.pi, n)
    high = 60.0 - 25.0 * s
    xyz = np.column_stack([120 * s, 40 * np.cos(a) * np.sqrt(1.2 - s**2), 3 + high * np.sin(a) * np.sqrt(1.2 - s**2)])
    return xyz + rng.normal(0, noise, xyz.shape)


def board(rng, n, tilt=0.0, offset=0.0):
    r, a = 190 * np.sqrt(rng.uniform(0.5, 1, n)), rng.uniform(-np.pi, np.pi, n)
    x, y = r * np.cos(a), r * np.sin(a)
    return np.column_stack([x, y, offset + np.tan(tilt) * x + rng.normal(0, 0.03, n)])


def test_board_specks_and_another_body_go_and_the_object_stays(rng):
    thing, floor = dome(rng, 20000), board(rng, 5000)
    post = np.array([150.0, 120.0, 60.0]) + rng.uniform(-8, 8, (800, 3))
    specks = np.column_stack([rng.uniform(-150, 150, 30), rng.uniform(90, 150, 30), rng.uniform(120, 200, 30)])
    spikes = thing[np.abs(thing[:, 1]) < 15][:40] + np.array([0.0, 0.0, 2.5])
    everything = np.concatenate([thing, floor, post, specks, spikes])
    kept, removed = clean_cloud(cloud_of(everything), FLOOR)
    is_left = {tuple(p) for p in kept.xyz_world}

    assert removed["footboard"] >= 5000
    assert removed["other body"] >= 800
    assert sum(tuple(p) in is_left for p in thing[thing[:, 2] > 3.0]) > 0.99 * (thing[:, 2] > 3.0).sum()
    assert not any(tuple(p) in is_left for p in np.concatenate([post, specks]))
    assert sum(tuple(p) in is_left for p in spikes) <= 2
    assert len(kept) + sum(removed.values()) == len(everything)


def test_the_board_is_where_it_is(rng):
    check = check_board(cloud_of(np.concatenate([board(rng, 4000, np.radians(0.05), 0.1), dome(rng, 5000)])), FLOOR)

    assert check.offset_mm == pytest.approx(0.1, abs=0.01)
    assert check.tilt_deg == pytest.approx(0.05, abs=0.005)
    assert check.remark == ""


@pytest.mark.parametrize(("tilt_deg", "offset_mm"), [(0.2, 0.0), (0.0, 0.5)])
def test_a_board_that_moved_is_said(rng, tilt_deg, offset_mm):
    check = check_board(cloud_of(board(rng, 4000, np.radians(tilt_deg), offset_mm)), FLOOR)

    assert "recalibrate" in check.remark
    assert f"{offset_mm:+.2f}" in check.remark or f"{tilt_deg:.2f}" in check.remark


def test_a_board_hardly_seen_is_not_judged(rng):
    check = check_board(cloud_of(dome(rng, 5000)), FLOOR)

    assert check.offset_mm is None
    assert "too little" in check.remark


@pytest.mark.parametrize("shift_mm", [0.0, 0.3])
def test_the_disagreement_of_the_lasers_is_measured_with_its_sign(rng, shift_mm):
    right, left = dome(rng, 20000), dome(rng, 20000)
    outward = np.column_stack([np.zeros(20000), np.sign(right[:, 1]), np.zeros(20000)])
    right = right + shift_mm * outward * (np.abs(right[:, 1:2]) > 25)
    both = cloud_of(np.concatenate([right, left]), np.repeat([0, 1], 20000))
    overlap = find_overlap(both)
    side = np.abs(both.xyz_world[overlap.index, 1]) > 30
    flank = both.xyz_world[overlap.index, 2] < 25

    assert np.median(overlap.distance_mm[side & flank]) == pytest.approx(shift_mm, abs=0.05)
    assert {zone.zone for zone in agreement_by_zone(both, overlap)} == set(ZONES)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (10.0, 70.0), (-60.0, -50.0)])
def test_outward_is_out_of_the_foot_wherever_it_stands(rng, shift):
    xyz = dome(rng, 5000)
    outward = np.column_stack([0.3 * xyz[:, 0] / 120, xyz[:, 1] / 40, (xyz[:, 2] - 3) / 50])
    moved = xyz + np.array([*shift, 0.0])
    agree = np.sum(direction_from_core(moved) * outward, axis=1) > 0.0

    assert agree.mean() > 0.995


def test_a_laser_alone_has_no_overlap(rng):
    single = cloud_of(dome(rng, 3000))

    assert all(zone.median_mm is None for zone in agreement_by_zone(single, find_overlap(single)))
    assert merge_lasers(single) is single


def test_where_both_see_the_better_lit_one_counts_more(rng):
    right, left = dome(rng, 8000), dome(rng, 8000)
    right = right[right[:, 0] < 40]
    laser = np.concatenate([np.zeros(len(right)), np.ones(8000)]).astype(np.int64)
    weight = np.where(laser == 0, 0.8, 0.2).astype(np.float32)
    xyz = np.concatenate([right, left])
    merged = merge_lasers(Cloud(xyz, laser, weight, np.zeros(len(xyz), np.int64)))
    alone = (laser == 1) & (xyz[:, 0] > 60)
    shared = xyz[:, 0] < 20

    np.testing.assert_allclose(merged.weight[alone], 0.2, rtol=1e-6)
    np.testing.assert_allclose(np.median(merged.weight[shared & (laser == 0)]), 0.8 * 0.8, rtol=1e-3)
    np.testing.assert_allclose(np.median(merged.weight[shared & (laser == 1)]), 0.2 * 0.2, rtol=1e-3)


@pytest.mark.parametrize("turn", [0.0, 1.0, np.pi, 4.0])
def test_zones_do_not_depend_on_the_heading(rng, turn):
    xyz = dome(rng, 20000)
    leg = np.column_stack([rng.uniform(-110, -60, 3000), rng.uniform(-25, 25, 3000), rng.uniform(60, 140, 3000)])
    xyz = np.concatenate([xyz, leg])
    c, s = np.cos(turn), np.sin(turn)
    turned = xyz @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    zone = zone_of_points(turned)

    assert (zone[(xyz[:, 0] > 95) & (xyz[:, 2] < 40)] == ZONES.index("toes")).all()
    assert (zone[(xyz[:, 0] < -95) & (xyz[:, 2] < 40)] == ZONES.index("heel")).all()
    assert (zone[(xyz[:, 2] > 100)] == ZONES.index("ankle")).all()


def test_points_come_back_from_their_file(rng, tmp_path):
    original = cloud_of(dome(rng, 100), np.arange(100) % 2)
    save_points(original, tmp_path / "points.ply", "test")
    again = load_points(tmp_path / "points.ply")

    np.testing.assert_allclose(again.xyz_world, original.xyz_world, atol=1e-4)
    np.testing.assert_array_equal(again.laser, original.laser)
    np.testing.assert_array_equal(again.weight, original.weight)


def test_a_cut_point_file_is_named(rng, tmp_path):
    save_points(cloud_of(dome(rng, 100)), tmp_path / "points.ply", "test")
    content = (tmp_path / "points.ply").read_bytes()
    (tmp_path / "points.ply").write_bytes(content[:-5])

    with pytest.raises(InputError, match="cut"):
        load_points(tmp_path / "points.ply")


def test_the_bare_board_is_read_as_it_was_written_and_may_be_missing(tmp_path):
    places = np.random.default_rng(2).uniform(-200.0, 200.0, (50, 2))
    save_bare_board(places, tmp_path / "board.npy")

    np.testing.assert_allclose(load_bare_board(tmp_path / "board.npy"), places, atol=1e-4)
    assert load_bare_board(tmp_path / "other.npy") is None


@pytest.mark.parametrize("damage", [lambda whole: whole[:90], lambda whole: b"no numbers at all"])
def test_a_damaged_bare_board_is_refused(tmp_path, damage):
    path = tmp_path / "board.npy"
    save_bare_board(np.ones((50, 2)), path)
    path.write_bytes(damage(path.read_bytes()))

    with pytest.raises(InputError, match="process the recording again"):
        load_bare_board(path)
