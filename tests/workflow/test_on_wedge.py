"""A scan of a foot on a wedge: the wedge is found, the foot measured as standing flat, its sole closed on the wedge."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from footscan.config import Subject
from footscan.coordinates import Floats
from footscan.foot.measurements import Measurements, measure
from footscan.foot.skin_origin import Origin
from footscan.geometry.plane import Plane
from footscan.scanning.cloud import Cloud
from footscan.scanning.ramp import find_cells, find_ramp, find_wall
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import trimesh_from_surface
from footscan.sim.wedge import RaisedFoot, raise_heel
from footscan.workflow.foot import MeasuredFoot, measure_scan
from footscan.workflow.on_wedge import find_ground, wedge_report

FLOOR = Plane((0.0, 0.0, 1.0), 0.0)
HEIGHT_MM = 50.0


@pytest.fixture(scope="module")
def raised() -> RaisedFoot:
    return raise_heel(build_foot(FootShape("left", 1.0)), "left", HEIGHT_MM)


@pytest.fixture(scope="module")
def skin(raised: RaisedFoot) -> Floats:
    """Skin as a scan shows it: nothing of the lowest five millimetres above board and wedge."""
    mesh = trimesh_from_surface(raised.surface)
    xyz = np.asarray(trimesh.sample.sample_surface(mesh, 24000, seed=3)[0])
    height = raised.wedge.flat(xyz)[:, 2]
    return xyz[(height > 5.0) & (xyz[:, 2] < 150.0)]


@pytest.fixture(scope="module")
def ramp(raised: RaisedFoot) -> Floats:
    """The top of the wedge where the foot does not stand on it, and its sides."""
    body = trimesh_from_surface(raised.body.surface)
    xyz = np.asarray(trimesh.sample.sample_surface(body, 20000, seed=4)[0])
    away = xyz[:, :2] - np.array(raised.wedge.heel_xy)
    across = away @ np.array([-raised.wedge.forward_xy[1], raised.wedge.forward_xy[0]])
    return xyz[(np.abs(across) > 42.0) & (xyz[:, 2] > 0.5)]


def test_the_wedge_that_is_seen_is_found_where_it_lies(raised: RaisedFoot, skin: Floats, ramp: Floats):
    found = find_ground(np.concatenate([skin, ramp]), FLOOR, HEIGHT_MM, "left", None)
    assert found.wedge is not None
    report = wedge_report(found.wedge)
    assert report is not None

    assert found.wedge.seen
    assert found.refusal is None
    assert found.wedge.slope_rad == pytest.approx(raised.wedge.slope_rad, abs=np.radians(0.1))
    assert (found.wedge.edge_xy - raised.wedge.edge_xy) @ np.array(raised.wedge.forward_xy) == pytest.approx(0, abs=0.3)
    assert report["seen_height_mm"] == pytest.approx(HEIGHT_MM, abs=1.0)


def test_a_wedge_that_nobody_declared_is_refused(skin: Floats, ramp: Floats):
    found = find_ground(np.concatenate([skin, ramp]), FLOOR, None, "left", None)

    assert found.wedge is None
    assert "no wedge was declared" in str(found.refusal)


def test_a_narrow_wedge_that_nobody_declared_is_told_by_its_side(raised: RaisedFoot, skin: Floats, ramp: Floats):
    sides = ramp[raised.wedge.flat(ramp)[:, 2] < -2.0]
    found = find_ground(np.concatenate([skin, sides]), FLOOR, None, "left", None)

    assert found.ramp is None
    assert "an upright plane of" in str(found.refusal)


def test_another_wedge_than_the_declared_one_is_refused(skin: Floats, ramp: Floats):
    found = find_ground(np.concatenate([skin, ramp]), FLOOR, 30.0, "left", None)

    assert "a wedge of 30 mm was declared, but the one that is seen is 50 mm high" in str(found.refusal)


def test_a_wedge_that_was_not_seen_is_taken_to_end_under_the_ball(raised: RaisedFoot, skin: Floats):
    found = find_ground(skin, FLOOR, HEIGHT_MM, "left", None)
    assert found.wedge is not None

    assert not found.wedge.seen
    assert found.wedge.slope_rad == pytest.approx(raised.wedge.slope_rad, abs=np.radians(2.0))
    assert any("was not seen" in remark for remark in found.remarks)


def test_a_foot_on_the_flat_board_for_which_a_wedge_was_declared_is_refused():
    mesh = trimesh_from_surface(build_foot(FootShape("left", 1.0)))
    xyz = np.asarray(trimesh.sample.sample_surface(mesh, 24000, seed=6)[0])
    found = find_ground(xyz[(xyz[:, 2] > 5.0) & (xyz[:, 2] < 150.0)], FLOOR, HEIGHT_MM, "left", None)

    assert found.wedge is None
    assert "a wedge of 50 mm was declared, but" in str(found.refusal)


def test_bare_skin_holds_no_ramp(skin: Floats):
    mesh = trimesh_from_surface(build_foot(FootShape("right")))
    flat = np.asarray(trimesh.sample.sample_surface(mesh, 60000, seed=5)[0])

    assert find_ramp(find_cells(skin, FLOOR), FLOOR) is None
    assert find_ramp(find_cells(flat, FLOOR), FLOOR) is None
    assert find_wall(find_cells(skin, FLOOR), FLOOR) is None


@pytest.fixture(scope="module")
def flat() -> Measurements:
    return measure(trimesh_from_surface(build_foot(FootShape("left", 1.0))), "left")


@pytest.fixture(scope="module")
def scanned(raised: RaisedFoot, skin: Floats) -> MeasuredFoot:
    wedge = replace(raised.wedge, seen=True)
    count = len(skin)
    cloud = Cloud(skin, np.zeros(count, np.int64), np.ones(count, np.float32), np.zeros(count, np.int64))
    return measure_scan(cloud, "left", Subject(wedge_mm=HEIGHT_MM), wedge=wedge)


def test_a_scan_on_a_wedge_measures_like_the_flat_foot(flat: Measurements, scanned: MeasuredFoot):
    within_mm = {"foot_length": 1.0, "foot_breadth": 0.5, "instep_girth": 2.0, "ball_girth": 3.0}

    for name, off_mm in within_mm.items():
        assert scanned.measurements[name].value == pytest.approx(flat[name].value, abs=off_mm), name


def test_the_assumed_sole_lies_on_the_wedge(raised: RaisedFoot, scanned: MeasuredFoot):
    sole = scanned.mesh.vertices[scanned.mesh.vertex_attributes["origin"] == Origin.ASSUMED_SOLE]
    back = (sole[:, :2] - np.array(raised.wedge.heel_xy)) @ np.array(raised.wedge.forward_xy) < 100.0
    top = raised.wedge.flat(sole[back])[:, 2]
    lowest = top[top < 1.5]

    assert scanned.mesh.is_watertight
    assert len(lowest) > 0.3 * len(top)
    assert np.median(lowest) == pytest.approx(0.0, abs=0.5)
    assert sole[back][:, 2].min() > 20.0
