import re

import numpy as np
import pytest
import trimesh

from footscan.errors import MeshError
from footscan.foot.clip import cut_below
from footscan.foot.measurements import measure
from footscan.foot.mesh_file import load_foot_mesh
from footscan.foot.repair import repair_mesh
from footscan.foot.shell import mesh_from_shell, shell_from_mesh
from footscan.foot.skin_origin import Origin
from footscan.foot.surface_files import save_surface_ply
from footscan.foot.units import check_foot_length, likely_units, mm_from_unit


def values(result):
    return {name: value.value for name, value in result.measurements.items() if value.value is not None}


def assert_same(result, expected, tolerance):
    ours, theirs = values(result), values(expected)

    assert ours.keys() == theirs.keys()
    assert {name: ours[name] - theirs[name] for name in ours} == pytest.approx(dict.fromkeys(ours, 0.0), abs=tolerance)


def test_a_sound_mesh_is_left_as_it_is(foot):
    repaired = repair_mesh(foot)

    assert repaired.remarks == ()
    assert repaired.mesh.is_watertight
    assert repaired.mesh.volume == pytest.approx(foot.volume, rel=1e-9)


def test_inverted_normals_are_turned_and_said_so(foot):
    inverted = trimesh.Trimesh(foot.vertices, foot.faces[:, ::-1], process=False)

    result = measure(inverted, "right")

    assert any("pointed inwards" in remark for remark in result.remarks)
    assert_same(result, measure(foot, "right"), 1e-9)


def test_some_faces_turned_against_their_neighbours_are_turned_round(foot):
    faces = foot.faces.copy()
    faces[::7] = faces[::7, ::-1]

    repaired = repair_mesh(trimesh.Trimesh(foot.vertices, faces, process=False))

    assert any("turned round" in remark for remark in repaired.remarks)
    assert repaired.mesh.is_winding_consistent
    assert repaired.mesh.volume == pytest.approx(foot.volume, rel=1e-9)


def test_duplicate_faces_are_left_out(foot):
    doubled = trimesh.Trimesh(foot.vertices, np.concatenate([foot.faces, foot.faces[:50]]), process=False)

    repaired = repair_mesh(doubled)

    assert repaired.remarks == ("50 duplicate faces were left out",)
    assert len(repaired.mesh.faces) == len(foot.faces)


def test_corners_that_are_no_numbers_cost_only_their_faces(foot):
    xyz = np.array(foot.vertices)
    xyz[2500] = np.nan

    repaired = repair_mesh(trimesh.Trimesh(xyz, foot.faces, process=False))

    assert any("no numbers" in remark for remark in repaired.remarks)
    assert any("hole" in remark for remark in repaired.remarks)
    assert repaired.mesh.is_watertight
    assert repaired.mesh.volume == pytest.approx(foot.volume, rel=1e-3)


def test_separate_triangles_are_joined(foot):
    soup = trimesh.Trimesh(foot.triangles.reshape(-1, 3), np.arange(3 * len(foot.faces)).reshape(-1, 3), process=False)

    repaired = repair_mesh(soup)

    assert repaired.mesh.is_watertight
    assert len(repaired.mesh.vertices) == len(foot.vertices)


def test_an_open_top_and_an_open_sole_are_closed_and_named(foot):
    level = np.abs(foot.face_normals[:, 2]) > 0.999
    middle = foot.triangles_center[:, 2]
    ends = level & ((middle < 0.1) | (middle > 237.9))

    repaired = repair_mesh(trimesh.Trimesh(foot.vertices, foot.faces[~ends], process=False))

    assert any("sole is assumed" in remark for remark in repaired.remarks)
    assert any("open top" in remark for remark in repaired.remarks)
    assert repaired.mesh.is_watertight
    assert repaired.mesh.volume == pytest.approx(foot.volume, rel=1e-6)


def test_a_foot_sawn_lengthwise_has_a_large_hole_and_no_open_sole(foot):
    half = trimesh.Trimesh(foot.vertices, foot.faces[foot.triangles_center[:, 1] > 0.0], process=False)

    repaired = repair_mesh(half)

    assert [remark[:12] for remark in repaired.remarks] == ["a large hole"]


def test_many_holes_are_summed_up_in_one_remark(foot):
    whole = np.ones(len(foot.faces), dtype=bool)
    whole[3000:13000:1501] = False

    repaired = repair_mesh(trimesh.Trimesh(foot.vertices, foot.faces[whole], process=False))

    assert len(repaired.remarks) == 1
    assert re.match(r"7 holes \(0 of them large\) were closed flat, the largest at height", repaired.remarks[0])
    assert repaired.mesh.is_watertight


def test_a_foot_with_holes_measures_nearly_the_same(foot):
    middle = foot.triangles_center
    hole = np.linalg.norm(middle - [95.0, 45.0, 60.0], axis=1) < 12.0
    holed = trimesh.Trimesh(foot.vertices, foot.faces[~hole], process=False)

    result = measure(holed, "right")

    assert hole.any()
    assert any("hole" in remark for remark in result.remarks)
    assert result["foot_length"].value == pytest.approx(measure(foot, "right")["foot_length"].value, abs=1e-6)


def test_crumbs_are_dropped_and_said_so(foot):
    crumb = trimesh.creation.icosphere(subdivisions=1, radius=3.0).apply_translation([300.0, 100.0, 40.0])

    result = measure(trimesh.util.concatenate([foot, crumb]), "right")

    assert any("1 loose piece" in remark for remark in result.remarks)
    assert_same(result, measure(foot, "right"), 1e-9)


def test_two_feet_are_refused(foot):
    pair = trimesh.util.concatenate([foot, foot.copy().apply_translation([0.0, 200.0, 0.0])])

    with pytest.raises(MeshError, match="two feet"):
        measure(pair, "right")


def test_a_sphere_is_refused():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=90.0).apply_translation([0.0, 0.0, 90.0])

    with pytest.raises(MeshError, match="like a ball"):
        measure(ball, "right")


def _solid(kind):
    if kind == "box":
        solid = trimesh.creation.box(extents=(270.0, 100.0, 110.0)).subdivide().subdivide().subdivide()
    else:
        solid = trimesh.creation.icosphere(subdivisions=4, radius=1.0).apply_scale([135.0, 50.0, 55.0])
    return solid.apply_translation([0.0, 0.0, 55.0])


@pytest.mark.parametrize("kind", ["box", "ellipsoid"])
def test_a_solid_without_an_ankle_is_refused_even_when_a_side_is_given(kind):
    with pytest.raises(MeshError, match="no ankle narrower than the foot"):
        measure(_solid(kind), "left")


@pytest.mark.parametrize("top_mm", [80.0, 140.0, 238.0])
def test_a_foot_upside_down_is_refused(foot, top_mm):
    shell = cut_below(shell_from_mesh(foot), top_mm)
    upside = trimesh.Trimesh(shell.xyz * [1.0, -1.0, -1.0] + [0.0, 0.0, top_mm], shell.faces, process=False)

    with pytest.raises(MeshError):
        measure(upside, "left")


@pytest.mark.parametrize("top_mm", [60.0, 80.0])
def test_a_foot_cut_low_is_still_a_foot(foot, top_mm):
    low = measure(mesh_from_shell(cut_below(shell_from_mesh(foot), top_mm)), "right")

    assert low["foot_length"].value == pytest.approx(measure(foot, "right")["foot_length"].value, abs=0.02)


def test_an_empty_board_is_refused():
    board = trimesh.creation.box(extents=(300.0, 120.0, 2.0)).subdivide().subdivide().subdivide()

    with pytest.raises(MeshError, match="empty board"):
        measure(board, "right")


def test_a_plantar_scan_is_refused(foot):
    sole = mesh_from_shell(cut_below(shell_from_mesh(foot), 20.0))

    with pytest.raises(MeshError, match="only a sole"):
        measure(sole, "right")


def test_a_mesh_without_a_usable_triangle_is_refused():
    with pytest.raises(MeshError, match="no triangle"):
        measure(trimesh.Trimesh(np.full((3, 3), np.nan), [[0, 1, 2]], process=False), "right")


@pytest.mark.parametrize("height_mm", [-60.0, 30.0, 50.0, 400.0])
def test_a_foot_far_from_the_board_is_refused_with_its_height(foot, height_mm):
    with pytest.raises(MeshError, match=rf"lowest skin at {height_mm:.0f} mm\): put it on the board"):
        measure(foot.copy().apply_translation([0.0, 0.0, height_mm]), "right")


@pytest.mark.parametrize(("unit", "factor"), [("m", 1e-3), ("cm", 0.1), ("in", 1 / 25.4)])
def test_a_mesh_in_another_unit_is_refused_with_the_unit_it_probably_is(foot, unit, factor):
    with pytest.raises(MeshError, match=f"pass --unit {unit}"):
        measure(foot.copy().apply_scale(factor), "right")


def test_the_refusal_of_metres_reads_as_promised():
    with pytest.raises(MeshError, match=r"^0\.276 mm long, .*: in metres \(276 mm\)\? pass --unit m$"):
        check_foot_length(0.276)


def test_a_size_that_is_a_foot_in_two_units_names_both_and_the_more_usual_first():
    with pytest.raises(
        MeshError, match=r"inches \(277 mm\)\? pass --unit in .*centimetres \(109 mm\)\? pass --unit cm$"
    ):
        check_foot_length(10.9)


def test_a_size_that_is_a_foot_in_no_unit_says_to_check():
    assert likely_units(3.2) == ()
    with pytest.raises(MeshError, match="check the unit"):
        check_foot_length(3.2)


def test_units_are_those_of_the_trade_and_others_are_refused():
    assert [mm_from_unit(unit) for unit in ("mm", "cm", "m", "in")] == [1.0, 10.0, 1000.0, 25.4]
    with pytest.raises(MeshError, match="allowed are mm, cm, m, in"):
        mm_from_unit("feet")


def test_a_cut_is_closed_flat_and_marked(foot):
    marked = foot.copy()
    marked.vertex_attributes["origin"] = np.zeros(len(foot.vertices), dtype=np.uint8)

    below = mesh_from_shell(cut_below(shell_from_mesh(marked), 90.3))

    assert below.is_watertight and below.is_winding_consistent
    assert below.bounds[1, 2] == pytest.approx(90.3)
    above_skin = below.vertex_attributes["origin"] == Origin.CUT
    assert above_skin.sum() == 1 and below.vertices[above_skin, 2] == pytest.approx(90.3)


def test_cutting_above_the_top_changes_nothing(foot):
    shell = shell_from_mesh(foot)

    assert cut_below(shell, 500.0) is shell


@pytest.mark.parametrize(("ending", "unit", "factor"), [("stl", "m", 1e-3), ("ply", "cm", 0.1), ("obj", "mm", 1.0)])
def test_a_mesh_file_of_any_unit_is_read_in_mm(foot, tmp_path, ending, unit, factor):
    path = tmp_path / f"foot.{ending}"
    foot.copy().apply_scale(factor).export(path)

    mesh = load_foot_mesh(path, unit)

    assert_same(measure(mesh, "right"), measure(foot, "right"), 0.02)


def test_a_folder_brings_the_origin_of_the_skin(foot, tmp_path):
    marked = foot.copy()
    marked.vertex_attributes["origin"] = np.where(foot.vertices[:, 2] < 5.0, 2, 0).astype(np.uint8)
    marked.vertex_attributes["sheets"] = np.ones(len(foot.vertices), dtype=np.uint8)
    marked.vertex_attributes["residual_mm"] = np.zeros(len(foot.vertices), dtype=np.float32)
    save_surface_ply(marked, tmp_path / "surface.ply", "test")

    result = measure(load_foot_mesh(tmp_path), "right")

    assert result.origin_known
    assert result["ball_girth"].interval == pytest.approx(measure(marked, "right")["ball_girth"].interval, abs=0.01)


def test_what_is_no_mesh_file_is_refused_in_words(tmp_path):
    (tmp_path / "notes.txt").write_text("hello")
    (tmp_path / "broken.stl").write_bytes(b"solid nothing\nendsolid\n")
    with pytest.raises(MeshError, match="not there"):
        load_foot_mesh(tmp_path / "absent.stl")
    with pytest.raises(MeshError, match=r"kind \.txt is not read"):
        load_foot_mesh(tmp_path / "notes.txt")
    with pytest.raises(MeshError, match=r"broken\.stl"):
        load_foot_mesh(tmp_path / "broken.stl")


def test_a_binary_stl_that_was_cut_off_is_refused_as_such(foot, tmp_path):
    path = tmp_path / "foot.stl"
    foot.export(path)
    path.write_bytes(path.read_bytes()[:5084])

    with pytest.raises(MeshError, match=f"counts {len(foot.faces)} triangles, it holds 100;"):
        load_foot_mesh(path)
