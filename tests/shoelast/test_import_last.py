"""Digitised lasts are repaired, laid into the frame and fitted; what is no whole last is refused in one sentence."""

import os
from pathlib import Path

import manifold3d
import numpy as np
import pytest
import trimesh

from footscan.errors import MeshError
from footscan.foot.mesh_file import load_foot_mesh
from footscan.shoelast.crossing_faces import crossing_faces
from footscan.shoelast.dimensions import dimensions
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.import_knobs import without_attachments
from footscan.shoelast.import_last import ImportFit, shoelast_from_mesh
from footscan.shoelast.import_pose import check_length, likely_unit, rough_frame
from footscan.shoelast.model import Shoelast
from footscan.shoelast.skin import CONE_TOP, Sampling, skin_of
from footscan.shoelast.source import LastSource
from tests.shoelast.digitised import Wear, digitise

COARSE = Sampling(200, 80, 30)
WORN = Wear(
    Sampling(300, 110, 40),
    noise=0.01,
    fragments=60,
    crumbs=20,
    holes=6,
    flipped=0.3,
    inverted=True,
    fins=5,
    stub=True,
    turn=True,
)


def imported(mesh: trimesh.Trimesh, side: str = "right", **more) -> tuple[Shoelast, ImportFit]:
    return shoelast_from_mesh(LastSource(mesh), side, "an import", **more)


def sawn(mesh: trimesh.Trimesh, normal: list, origin: list, cap: bool) -> trimesh.Trimesh:
    """What lies on the normal's side of a plane, closed there or open."""
    whole = manifold3d.Manifold(
        manifold3d.Mesh64(np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.faces, dtype=np.uint64))
    )
    left = whole.trim_by_plane(normal, float(np.dot(normal, origin))).to_mesh64()
    half = trimesh.Trimesh(np.asarray(left.vert_properties)[:, :3], np.asarray(left.tri_verts), process=False)
    on_plane = np.abs((half.vertices - origin) @ np.array(normal)) < 1e-6
    faces = half.faces if cap else half.faces[~on_plane[half.faces].all(axis=1)]
    return trimesh.Trimesh(half.vertices, faces, process=False)


@pytest.fixture(scope="module")
def truth() -> Shoelast:
    return build_shoelast("men", 42, "g", 12, "round", "left")


@pytest.fixture(scope="module")
def worn(truth: Shoelast) -> tuple[Shoelast, ImportFit]:
    return imported(digitise(truth, WORN), "left", pitch_mm=dimensions(truth)["pitch"].value)


def test_a_worn_last_is_fitted_as_well_as_it_was_digitised(worn: tuple[Shoelast, ImportFit]):
    assert worn[1].rms_mm <= 0.05
    assert worn[1].edge_rms_mm <= 0.15
    assert worn[1].largest_mm <= 0.2


def test_long_facets_across_a_flat_cone_top_as_cad_writes_them_are_no_hindrance(truth: Shoelast):
    skin = skin_of(truth, COARSE)
    rim = np.flatnonzero(skin.uv[:, 1] == 1.0)
    ahead, back = rim[: len(rim) // 2 + 1], np.append(rim[:1], rim[: len(rim) // 2 - 1 : -1])
    strips = [np.column_stack([ahead[:-1], ahead[1:], back[1:]]), np.column_stack([ahead[:-1], back[1:], back[:-1]])]
    top = np.vstack(strips)
    top = top[(top != np.roll(top, 1, axis=1)).all(axis=1)]
    cad = trimesh.Trimesh(skin.xyz_shoelast, np.vstack([skin.faces[skin.patch != CONE_TOP], top]), process=False)

    _, fit = imported(cad)

    assert cad.edges_unique_length.max() > 20.0
    assert fit.rms_mm <= 0.05
    assert fit.largest_mm <= 0.2


def test_its_dimensions_are_those_of_the_last_without_the_stub(truth: Shoelast, worn: tuple[Shoelast, ImportFit]):
    before, after = dimensions(truth), dimensions(worn[0])

    for name in (
        "stick_length",
        "bottom_length",
        "ball_length",
        "ball_girth",
        "ball_width",
        "heel_width",
        "cone_length",
    ):
        assert after[name].value == pytest.approx(before[name].value, abs=0.5), name
    for name in ("waist_girth", "instep_girth", "long_heel_girth", "toe_box_height", "toe_spring", "cone_height"):
        assert after[name].value == pytest.approx(before[name].value, abs=0.8), name


def test_the_stub_is_kept_apart_behind_the_heel(worn: tuple[Shoelast, ImportFit]):
    (stub,) = worn[0].attachments

    assert stub.kind == "stub"
    assert stub.mesh.bounds[0][0] == pytest.approx(-19.0, abs=1.0)
    assert np.ptp(stub.mesh.vertices[stub.mesh.vertices[:, 0] < -8.0, 1]) == pytest.approx(14.0, abs=1.0)


def test_everything_that_was_changed_is_told(worn: tuple[Shoelast, ImportFit]):
    told = " | ".join(worn[0].remarks)

    for words in ("fragments", "crumbs", "turned round", "outwards", "stub", "bridged", "feather edge", "RMS"):
        assert words in told, words


def test_a_toe_centre_becomes_a_body_of_its_own_and_a_narrow_toe_keeps_its_nose_under_it():
    truth = build_shoelast("women", 38, "g", 50, "almond")
    found, _ = imported(digitise(truth, Wear(COARSE, toe_centre=True, turn=True, seed=3)), pitch_mm=50.0)

    assert [part.kind for part in found.attachments] == ["toe_centre"]
    assert dimensions(found)["stick_length"].value == pytest.approx(dimensions(truth)["stick_length"].value, abs=0.3)


@pytest.mark.parametrize(("scale", "words"), [(10.0, "--unit cm"), (25.4, "--unit in"), (1000.0, "--unit m")])
def test_a_wrong_unit_is_named(truth: Shoelast, scale: float, words: str):
    with pytest.raises(MeshError, match=words):
        imported(digitise(truth, Wear(COARSE, scale=scale)))


def test_a_bare_number_suggests_its_unit():
    assert "--unit in" in likely_unit(11.3)
    assert "no last" in likely_unit(70000.0)


def test_a_left_last_is_not_taken_for_a_right_one(truth: Shoelast):
    with pytest.raises(MeshError, match="shape is that of a left one"):
        imported(digitise(truth, Wear(COARSE, turn=True)), "right")


@pytest.mark.parametrize(
    ("normal", "origin", "words"),
    [
        ([-1, 0, 0], [180, 0, 0], "cut off across|part of the last|length over width"),
        ([0, 1, 0], [0, 0, 0], "cut off lengthwise|part of the last"),
        ([0, -1, 0], [0, 0, 0], "cut off lengthwise|part of the last"),
    ],
)
@pytest.mark.parametrize("cap", [True, False])
def test_half_a_last_is_refused(truth: Shoelast, normal: list, origin: list, words: str, cap: bool):
    half = sawn(digitise(truth, Wear(COARSE)), normal, origin, cap)

    with pytest.raises(MeshError, match=words):
        imported(half, "left")


def test_a_last_without_its_sole_is_refused(truth: Shoelast):
    mesh = digitise(truth, Wear(COARSE))
    bottom = (mesh.face_normals[:, 2] < -0.8) & (mesh.triangles_center[:, 2] < 20)

    with pytest.raises(MeshError, match="sole is missing"):
        imported(trimesh.Trimesh(mesh.vertices, mesh.faces[~bottom], process=False), "left")


@pytest.mark.parametrize("lean_deg", [-20.0, 0.0, 20.0])
def test_a_stub_is_cut_off_however_it_leans_on_a_high_heel(lean_deg: float):
    high = build_shoelast("women", 38, "g", 50, "almond")
    box = trimesh.creation.box(extents=[32.0, 14.0, 20.0])
    box.apply_translation([-4.0, 0.0, 0.0])
    box.apply_transform(trimesh.transformations.rotation_matrix(np.radians(lean_deg), [0, 1, 0]))
    box.apply_translation(high.points["rear_point"] + np.array([0.0, 0.0, 4.0]))
    skin = skin_of(high, COARSE)
    body, stub = (
        manifold3d.Manifold(manifold3d.Mesh64(np.ascontiguousarray(v), np.ascontiguousarray(f, dtype=np.uint64)))
        for v, f in ((skin.xyz_shoelast, skin.faces), (box.vertices, box.faces))
    )
    mesh = (body + stub).to_mesh64()
    xyz, faces = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts, dtype=np.int64)
    frame = rough_frame(xyz, faces, "right")

    trimmed = without_attachments(xyz @ frame[:3, :3].T + frame[:3, 3], faces, ())

    assert [part.kind for part in trimmed.attachments] == ["stub"]
    back = frame[:3, :3].T @ (trimmed.xyz[np.unique(trimmed.faces)] - frame[:3, 3]).T
    assert back[0].min() == pytest.approx(skin.xyz_shoelast[:, 0].min(), abs=1.0)


def test_a_clean_last_has_no_stub_and_no_toe_centre():
    skin = skin_of(build_shoelast("women", 36, "f", 60, "almond"), Sampling(160, 60, 20))
    frame = rough_frame(skin.xyz_shoelast, skin.faces, "right")

    trimmed = without_attachments(skin.xyz_shoelast @ frame[:3, :3].T + frame[:3, 3], skin.faces, ())

    assert trimmed.attachments == ()


def test_a_body_that_is_neither_behind_nor_before_the_last_is_left_out(truth: Shoelast):
    skin = skin_of(truth, COARSE)
    ball = trimesh.creation.icosphere(3, 8.0).apply_translation([150.0, 0.0, 20.0])

    trimmed = without_attachments(skin.xyz_shoelast, skin.faces, (ball,))

    assert trimmed.attachments == ()
    assert "neither behind the heel nor at the toe" in trimmed.remarks[0]


def test_faces_beside_each_other_in_one_plane_do_not_cross():
    rng = np.random.default_rng(4)
    turn = trimesh.transformations.random_rotation_matrix(rng.random(3))[:3, :3]
    x = np.sort(rng.uniform(0, 250, 400))
    rails = [np.column_stack([x, np.full(400, y), np.zeros(400)]) @ turn.T for y in (-40.0, 0.0, 0.0, 40.0)]
    a = np.arange(399)
    strip = np.vstack([np.column_stack([a, a + 1, a + 400]), np.column_stack([a + 1, a + 401, a + 400])])

    crossing = crossing_faces(np.vstack(rails), np.vstack([strip, strip + 800]))

    assert not crossing.any()


def test_a_file_that_states_its_unit_is_to_be_corrected_where_it_was_made():
    with pytest.raises(MeshError, match=r"11\.23 mm.*probably inches: set that unit where the file was made"):
        check_length(11.23, "mm", stated=True)


def test_two_lasts_in_one_file_are_refused(truth: Shoelast):
    mesh = digitise(truth, Wear(COARSE))
    other = mesh.copy().apply_translation([0, 150, 0])

    with pytest.raises(MeshError, match="one last at a time"):
        imported(trimesh.util.concatenate([mesh, other]), "left")


def test_another_body_is_refused():
    ball = trimesh.creation.icosphere(5, 120.0)

    with pytest.raises(MeshError):
        imported(ball)


def test_a_surface_that_passes_through_itself_is_refused(truth: Shoelast):
    """A dent so deep that the back of the vamp comes out through the bottom."""
    mesh = digitise(truth, Wear(COARSE))
    away = np.linalg.norm(mesh.vertices[:, :2] - np.array([200.0, 0.0]), axis=1)
    dent = np.where(mesh.vertices[:, 2] > 15.0, 60.0 * np.exp(-((away / 15.0) ** 2)), 0.0)
    mesh.vertices = mesh.vertices - dent[:, None] * np.array([0.0, 0.0, 1.0])

    with pytest.raises(MeshError, match="passes through itself"):
        imported(mesh, "left")


def test_curves_of_the_file_count_before_what_is_detected(truth: Shoelast):
    real = np.array([1.0, -1.0, 1.0])
    lines = {name: truth.lines[name] * real for name in ("feather_edge", "cone_edge", "ball_break_line")}
    lines["cone_edge"] = lines["cone_edge"] + np.array([0.0, 0.0, 5.0])
    mesh = digitise(truth, Wear(COARSE, noise=0.02))
    found, _ = shoelast_from_mesh(LastSource(mesh, lines), "left", "with curves", pitch_mm=12.0)
    edge = truth.upper.grid(np.arange(20000) / 20000, np.array([0.0]))[0]
    told = " | ".join(found.remarks)

    assert "feather edge was taken from the file" in told
    assert "cone edge lies 5.0 mm off" in told
    assert np.ptp(found.lines["feather_edge"], axis=0) == pytest.approx(np.ptp(edge, axis=0), abs=0.3)
    assert length(found.lines["ball_break_line"]) == pytest.approx(length(truth.lines["ball_break_line"]), abs=1e-6)


def length(line: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def test_a_scanned_foot_is_no_last():
    shared = os.environ.get("FOOTSCAN_SHARED")
    if not shared:
        pytest.skip("FOOTSCAN_SHARED names no shared data")
    foot = load_foot_mesh(Path(shared) / "data/feet/left_foot.stl", "m")

    with pytest.raises(MeshError, match="looks like a foot"):
        imported(foot, "left")


@pytest.mark.parametrize(
    ("extent_mm", "factor"), [(2870.0, "10 times"), (7300.0, "25.4 times"), (287000.0, "1000 times")]
)
def test_a_unit_that_is_too_large_is_named(extent_mm: float, factor: str):
    with pytest.raises(MeshError, match=f"about {factor} too large"):
        check_length(extent_mm, "mm")
