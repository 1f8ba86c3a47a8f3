import csv
import io

import numpy as np
import pytest
import trimesh

from footscan.errors import MeshError
from footscan.foot.crossing import convex_hull, hull_perimeter_mm
from footscan.foot.measurements import measure
from footscan.foot.section_files import cut_stack, sections_dxf, stack_csv
from footscan.foot.sections import plane_through_points, section
from footscan.foot.shell import shell_from_mesh

LEVEL = np.array([0.0, 0.0, 1.0])


def test_a_level_cut_of_a_box_is_its_rectangle():
    box = trimesh.creation.box(extents=(200.0, 80.0, 60.0))

    cut = section(box, np.array([5.0, 1.0, 7.0]), 3.0 * LEVEL)

    assert cut.closed and len(cut.polylines) == 1
    assert cut.area_mm2 == pytest.approx(16000.0)
    assert cut.perimeter_mm == pytest.approx(560.0)
    assert cut.hull_perimeter_mm == pytest.approx(560.0)
    assert (cut.width_mm, cut.height_mm) == pytest.approx((200.0, 80.0))
    assert cut.centroid == pytest.approx([0.0, 0.0, 7.0])


@pytest.mark.parametrize("normal", [(1.0, 0.0, 0.0), (0.3, -0.9, 0.4), (-0.1, 0.2, -0.97)])
def test_cuts_of_a_ball_are_circles_whatever_the_plane(normal):
    radius, distance = 50.0, 20.0
    ball = trimesh.creation.icosphere(subdivisions=5, radius=radius)
    unit = np.array(normal) / np.linalg.norm(normal)
    circle = np.sqrt(radius**2 - distance**2)

    cut = section(ball, distance * unit, np.array(normal))

    assert cut.area_mm2 == pytest.approx(np.pi * circle**2, rel=2e-3)
    assert cut.perimeter_mm == pytest.approx(2 * np.pi * circle, rel=1e-3)
    assert cut.width_mm == pytest.approx(2 * circle, rel=1e-3)
    assert cut.height_mm == pytest.approx(2 * circle, rel=1e-3)
    assert cut.centroid == pytest.approx(distance * unit, abs=0.05)


def test_a_tape_bridges_the_gap_between_two_toes():
    toes = trimesh.util.concatenate(
        [trimesh.creation.box(extents=(100.0, 20.0, 20.0)).apply_translation([0.0, y, 10.0]) for y in (-20.0, 20.0)]
    )

    cut = section(toes, np.array([0.0, 0.0, 10.0]), np.array([1.0, 0.0, 0.0]))

    assert len(cut.polylines) == 2
    assert cut.perimeter_mm == pytest.approx(160.0)
    assert cut.hull_perimeter_mm == pytest.approx(160.0)  # 60 + 20 twice
    assert cut.width_mm == pytest.approx(60.0)
    assert cut.area_mm2 == pytest.approx(800.0)


def test_a_section_agrees_with_trimesh_on_a_foot(foot):
    origin, normal = np.array([150.0, 0.0, 20.0]), np.array([0.8, 0.5, 0.33])

    cut = section(foot, origin, normal)

    theirs = foot.section(plane_origin=origin, plane_normal=normal)
    assert cut.perimeter_mm == pytest.approx(theirs.length, rel=1e-9)


def test_polylines_are_the_perimeter_and_lie_in_the_plane(foot):
    origin, normal = np.array([120.0, 0.0, 30.0]), np.array([0.6, 0.0, 0.8])

    cut = section(foot, origin, normal)

    length = sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in cut.polylines)
    assert length == pytest.approx(cut.perimeter_mm)
    assert max(np.abs((line - origin) @ normal).max() for line in cut.polylines) < 1e-9


def test_a_plane_through_mesh_corners_still_gives_closed_outlines(foot):
    height = float(np.unique(foot.vertices[:, 2])[20])

    cut = section(foot, np.array([0.0, 0.0, height]), LEVEL)

    assert cut.closed and len(cut.polylines) == 1


def test_the_share_on_unseen_skin_is_that_of_the_marked_half():
    box = trimesh.creation.box(extents=(100.0, 40.0, 40.0)).subdivide().subdivide().subdivide()
    box.vertex_attributes["origin"] = np.where(box.vertices[:, 1] > 0, 1, 0).astype(np.uint8)

    cut = section(box, np.array([3.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]))

    assert cut.unseen_share == pytest.approx(0.5, abs=0.04)
    assert cut.hull_unseen_share == pytest.approx(0.5, abs=0.04)


def test_without_an_origin_the_unseen_share_is_unknown(foot):
    cut = section(foot, np.array([100.0, 0.0, 20.0]), LEVEL)

    assert cut.unseen_share is None
    assert cut.hull_unseen_share is None


def test_a_hole_shows_as_an_outline_that_is_not_closed(foot):
    open_foot = trimesh.Trimesh(foot.vertices, foot.faces[foot.triangles_center[:, 1] < 40.0], process=False)

    cut = section(open_foot, np.array([180.0, 0.0, 20.0]), LEVEL)

    assert not cut.closed


def test_a_plane_beside_the_foot_is_refused(foot):
    with pytest.raises(MeshError, match="does not meet the foot"):
        section(foot, np.array([900.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]))


@pytest.mark.parametrize("normal", [(0.0, 0.0, 0.0), (np.nan, 0.0, 1.0), (1.0, 0.0)])
def test_what_is_no_plane_is_refused(foot, normal):
    with pytest.raises(MeshError, match="plane"):
        section(foot, np.zeros(3), np.array(normal))


def test_a_plane_through_three_points_holds_them():
    xyz = np.array([[10.0, 2.0, 3.0], [200.0, -40.0, 8.0], [90.0, 50.0, 70.0]])

    origin, normal = plane_through_points(xyz)

    assert np.abs((xyz - origin) @ normal).max() < 1e-10
    assert np.linalg.norm(normal) == pytest.approx(1.0)


def test_three_points_on_a_line_fix_no_plane():
    with pytest.raises(MeshError, match="one line"):
        plane_through_points(np.array([[0.0, 0.0, 0.0], [50.0, 50.0, 50.0], [100.0, 100.0, 100.0]]))


def test_a_hull_is_the_polygon_of_the_outermost_points():
    rng = np.random.default_rng(3)
    inner = rng.uniform(-0.6, 0.6, (200, 2))
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])

    corner = convex_hull(np.concatenate([inner, square, square]))

    assert sorted(map(tuple, np.concatenate([inner, square, square])[corner])) == sorted(map(tuple, square))
    assert hull_perimeter_mm(inner[:1]) == 0.0


def test_a_stack_goes_from_heel_to_toe_in_the_foots_own_axis(foot):
    turned = foot.copy().apply_transform(trimesh.transformations.rotation_matrix(1.1, [0, 0, 1]))
    shares = [0.1, 0.25, 0.5, 0.75, 0.9]

    straight, slanted = (cut_stack(shell_from_mesh(mesh), measure(mesh, "right"), shares) for mesh in (foot, turned))

    assert [named.share for named in slanted] == shares
    for one, other in zip(straight, slanted, strict=True):
        assert other.section.area_mm2 == pytest.approx(one.section.area_mm2, abs=0.01)
        assert other.section.width_mm == pytest.approx(one.section.width_mm, abs=0.001)


def test_the_csv_of_a_stack_reads_back(foot):
    stack = cut_stack(shell_from_mesh(foot), measure(foot, "right"), [0.2, 0.5])

    rows = list(csv.DictReader(io.StringIO(stack_csv(stack))))

    assert [float(row["share_percent"]) for row in rows] == [20.0, 50.0]
    assert float(rows[1]["area_mm2"]) == pytest.approx(stack[1].section.area_mm2, abs=1e-3)
    assert rows[0]["unseen_share"] == ""


def test_the_dxf_of_a_stack_holds_every_corner_once(foot):
    stack = cut_stack(shell_from_mesh(foot), measure(foot, "right"), [0.2, 0.5])

    lines = sections_dxf(stack).splitlines()

    pairs = list(zip(lines[0::2], lines[1::2], strict=True))
    xs = [float(value) for code, value in pairs if code == "10"]
    corners = sum(len(line) - 1 for named in stack for line in named.section.polylines)
    outlines = sum(len(named.section.polylines) for named in stack)
    assert pairs[0] == ("0", "SECTION") and pairs[-1] == ("0", "EOF")
    assert pairs.count(("0", "VERTEX")) == corners
    assert pairs.count(("0", "POLYLINE")) == pairs.count(("0", "SEQEND")) == outlines
    assert len(xs) == corners + outlines
    assert sorted({value for code, value in pairs if code == "70"}) == ["32", "9"]  # corners; closed in space
    assert {value for code, value in pairs if code == "8"} == {"SECTION_020_0", "SECTION_050_0"}
