"""A last leaves as 3DM and comes back; Rhino files as last makers have them are read or refused by name."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rhino3dm
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from footscan.coordinates import Side
from footscan.errors import MeshError
from footscan.shoelast.dimensions import with_points_and_lines
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.file_datum import DATUM_POINTS, frame_from_points
from footscan.shoelast.handed import mirrored, mirrored_mesh
from footscan.shoelast.mesh_out import mesh_of_last
from footscan.shoelast.model import Shoelast
from footscan.shoelast.nurbs_out import clamped_patches
from footscan.shoelast.own_surfaces import shoelast_of_surfaces
from footscan.shoelast.rhino_file import rhino_mesh, rhino_surface, save_last_3dm
from footscan.shoelast.rhino_read import read_3dm

Tub = Callable[[Side], Shoelast]


@pytest.mark.parametrize("side", ["right", "left"])
def test_the_surfaces_of_the_file_are_those_of_the_last(tub: Tub, side: Side, tmp_path: Path):
    shoelast = tub(side)

    save_last_3dm(shoelast, tmp_path / "tub.3dm", "tub")

    model = rhino3dm.File3dm.Read(str(tmp_path / "tub.3dm"))
    assert model.Settings.ModelUnitSystem == rhino3dm.UnitSystem.Millimeters
    bodies = {e.Attributes.Name: e.Geometry for e in model.Objects if isinstance(e.Geometry, rhino3dm.Brep)}
    for patch in clamped_patches(shoelast):
        surface = bodies[patch.name].Faces[0].UnderlyingSurface()
        for u, v in ((0.0, 0.3), (0.27, 0.81), (0.5, 1.0), (0.93, 0.0)):
            point = surface.PointAt(u, v)
            there = patch.grid(np.array([u]), np.array([v]))[0, 0]
            assert np.allclose((point.X, point.Y, point.Z), there, atol=1e-10)
    assert all(body.IsValid for body in bodies.values())


def test_every_line_and_point_is_a_named_object_on_a_layer(tub: Tub, tmp_path: Path):
    shoelast = tub("left")

    save_last_3dm(shoelast, tmp_path / "tub.3dm", "tub", {"stub": shoelast.attachments[0].mesh})

    model = rhino3dm.File3dm.Read(str(tmp_path / "tub.3dm"))
    layers = [layer.Name for layer in model.Layers]
    assert {"upper", "bottom", "cone_top", "stub", "points", "datum", *shoelast.lines} == set(layers)
    points = {e.Attributes.Name: e.Geometry.Location for e in model.Objects if isinstance(e.Geometry, rhino3dm.Point)}
    wanted = mirrored(shoelast.points["toe_point"], "left")
    assert np.allclose((points["toe_point"].X, points["toe_point"].Y, points["toe_point"].Z), wanted)


@pytest.mark.parametrize("side", ["right", "left"])
def test_a_last_read_back_is_the_real_last_with_its_lines(tub: Tub, side: Side, tmp_path: Path):
    shoelast = tub(side)
    save_last_3dm(shoelast, tmp_path / "tub.3dm", "tub")

    source = read_3dm(tmp_path / "tub.3dm")

    closed = source.mesh.copy()
    closed.merge_vertices(digits_vertex=4)
    body = mesh_of_last(shoelast).bodies["last"]
    assert source.unit == "millimeters"
    assert np.allclose(source.mesh.bounds, body.bounds, atol=0.02)
    assert closed.volume == pytest.approx(body.volume, rel=3e-4)
    assert set(source.lines) == set(shoelast.lines)
    for name, line in source.lines.items():
        dense = cKDTree(mirrored(shoelast.lines[name], side))
        assert dense.query(line)[0].max() < 2.0, "no further than half a step of the sampled line"
    edge = shoelast.upper.grid(np.linspace(0, 1, 20001), np.array([0.0]))[0]
    assert cKDTree(mirrored(edge, side)).query(source.lines["feather_edge"])[0].max() < 0.02


def test_the_unit_of_the_file_counts(tub: Tub, tmp_path: Path):
    model = rhino3dm.File3dm()
    model.Settings.ModelUnitSystem = rhino3dm.UnitSystem.Inches
    model.Objects.AddMesh(rhino_mesh(trimesh.creation.box(extents=(10.0, 4.0, 2.0))), rhino3dm.ObjectAttributes())
    model.Write(str(tmp_path / "inch.3dm"), 7)

    source = read_3dm(tmp_path / "inch.3dm")

    assert np.allclose(source.mesh.extents, [254.0, 101.6, 50.8])
    assert source.mesh.is_watertight


def test_pieces_of_a_curve_become_one_line_under_the_name_of_their_layer(tmp_path: Path):
    turn = np.linspace(0.0, 2 * np.pi, 41)
    circle = np.column_stack([50 * np.cos(turn), 50 * np.sin(turn), 0 * turn])
    model = rhino3dm.File3dm()
    model.Settings.ModelUnitSystem = rhino3dm.UnitSystem.Millimeters
    model.Objects.AddMesh(rhino_mesh(trimesh.creation.icosphere(radius=50.0)), rhino3dm.ObjectAttributes())
    attributes = rhino3dm.ObjectAttributes()
    attributes.LayerIndex = model.Layers.AddLayer("Feather Line", (0, 0, 0, 255))
    for piece in (circle[:15], circle[14:30][::-1], circle[29:]):
        points = rhino3dm.Point3dList([rhino3dm.Point3d(*xyz) for xyz in piece.tolist()])
        model.Objects.AddCurve(rhino3dm.PolylineCurve(points), attributes)
    model.Write(str(tmp_path / "pieces.3dm"), 7)

    lines = read_3dm(tmp_path / "pieces.3dm").lines

    assert list(lines) == ["feather_edge"]
    assert len(lines["feather_edge"]) == 41
    assert np.allclose(lines["feather_edge"][0], lines["feather_edge"][-1])


def test_meshes_count_where_surfaces_show_the_same_body(bare_tub: Shoelast, tmp_path: Path):
    mesh = mesh_of_last(bare_tub).bodies["last"]
    save_last_3dm(bare_tub, tmp_path / "both.3dm", "tub", {"mesh": mesh})

    source = read_3dm(tmp_path / "both.3dm")

    assert len(source.mesh.faces) == len(mesh.faces)
    assert any("3 surfaces" in remark for remark in source.remarks)


def test_hidden_objects_stay_out_and_are_counted(tmp_path: Path):
    model = rhino3dm.File3dm()
    model.Settings.ModelUnitSystem = rhino3dm.UnitSystem.Millimeters
    model.Objects.AddMesh(rhino_mesh(trimesh.creation.icosphere()), rhino3dm.ObjectAttributes())
    hidden = rhino3dm.ObjectAttributes()
    hidden.Visible = False
    model.Objects.AddMesh(rhino_mesh(trimesh.creation.box()), hidden)
    model.Write(str(tmp_path / "hidden.3dm"), 7)

    source = read_3dm(tmp_path / "hidden.3dm")

    assert len(source.mesh.faces) == 1280
    assert source.remarks == ("1 hidden objects were left out",)


def test_a_joined_solid_of_untrimmed_faces_is_read_and_a_trimmed_face_is_refused(tmp_path: Path):
    for name, brep in {
        "box": rhino3dm.Brep.CreateFromBox(rhino3dm.Box(rhino3dm.BoundingBox(0, 0, 0, 200, 80, 60))),
        "cylinder": rhino3dm.Brep.CreateFromCylinder(
            rhino3dm.Cylinder(rhino3dm.Circle(rhino3dm.Point3d(0, 0, 0), 40.0), 90.0), True, True
        ),
    }.items():
        model = rhino3dm.File3dm()
        model.Settings.ModelUnitSystem = rhino3dm.UnitSystem.Millimeters
        model.Objects.AddBrep(brep, rhino3dm.ObjectAttributes())
        model.Write(str(tmp_path / f"{name}.3dm"), 7)

    box = read_3dm(tmp_path / "box.3dm").mesh
    box.merge_vertices()

    assert box.is_watertight
    assert box.volume == pytest.approx(200 * 80 * 60)
    with pytest.raises(MeshError, match="trimmed and has no stored mesh"):
        read_3dm(tmp_path / "cylinder.3dm")


def test_a_rational_surface_is_evaluated_with_its_weights(tmp_path: Path):
    model = rhino3dm.File3dm()
    model.Settings.ModelUnitSystem = rhino3dm.UnitSystem.Centimeters
    sphere = rhino3dm.NurbsSurface.CreateFromSphere(rhino3dm.Sphere(rhino3dm.Point3d(0, 0, 0), 3.0))
    model.Objects.AddSurface(sphere, rhino3dm.ObjectAttributes())
    model.Write(str(tmp_path / "sphere.3dm"), 7)

    mesh = read_3dm(tmp_path / "sphere.3dm").mesh

    assert np.abs(np.linalg.norm(mesh.vertices, axis=1) - 30.0).max() < 1e-9


def test_what_is_no_rhino_file_or_holds_no_body_is_refused(bare_tub: Shoelast, tmp_path: Path):
    (tmp_path / "text.3dm").write_bytes(b"nothing of the kind")
    model = rhino3dm.File3dm()
    model.Settings.ModelUnitSystem = rhino3dm.UnitSystem.Millimeters
    model.Write(str(tmp_path / "empty.3dm"), 7)
    model.Settings.ModelUnitSystem = rhino3dm.UnitSystem.LightYears
    model.Objects.AddSurface(rhino_surface(clamped_patches(bare_tub)[0]), rhino3dm.ObjectAttributes())
    model.Write(str(tmp_path / "far.3dm"), 7)

    for name, said in (
        ("text", "Rhino file"),
        ("missing", "Rhino file"),
        ("empty", "no visible"),
        ("far", "LightYears"),
    ):
        with pytest.raises(MeshError, match=said):
            read_3dm(tmp_path / f"{name}.3dm")


def moved_file(path: Path, transform: np.ndarray, inches: bool) -> None:
    """Move all objects of a Rhino file, as people do, and perhaps change its unit."""
    matrix = rhino3dm.Transform(1.0)
    for i, j in np.ndindex(4, 4):
        setattr(matrix, f"M{i}{j}", float(transform[i, j]))
    model = rhino3dm.File3dm.Read(str(path))
    for entry in model.Objects:
        entry.Geometry.Transform(matrix)
        if inches:
            entry.Geometry.Scale(1.0 / 25.4)
    if inches:
        model.Settings.ModelUnitSystem = rhino3dm.UnitSystem.Inches
    model.Write(str(path), 7)


@pytest.mark.parametrize(("side", "inches"), [("right", False), ("left", True)])
def test_a_last_that_was_moved_in_rhino_comes_back_into_its_own_frame(side: Side, inches: bool, tmp_path: Path):
    shoelast = build_shoelast("women", 38.0, "g", 50.0, "almond", side, stub=True)
    stub = mirrored_mesh(shoelast.attachments[0].mesh, side)
    save_last_3dm(shoelast, tmp_path / "last.3dm", "last", {"stub": stub})
    turn = np.eye(4)
    turn[:3, :3] = Rotation.random(random_state=7).as_matrix()
    turn[:3, 3] = 300.0, -200.0, 50.0
    moved_file(tmp_path / "last.3dm", turn, inches)

    back = shoelast_of_surfaces(read_3dm(tmp_path / "last.3dm"), side, "last")

    assert back is not None
    assert np.allclose(back.upper.net_mm, shoelast.upper.net_mm, atol=1e-6)
    assert np.allclose(back.bottom.net_mm, shoelast.bottom.net_mm, atol=1e-6)
    assert np.allclose(back.attachments[0].mesh.bounds, shoelast.attachments[0].mesh.bounds, atol=1e-4)
    for name, point in shoelast.points.items():
        assert np.allclose(back.points[name], point, atol=1e-5), name


def test_surfaces_that_do_not_meet_any_more_are_not_taken_as_they_are(tub: Tub, tmp_path: Path):
    save_last_3dm(with_points_and_lines(tub("right")), tmp_path / "tub.3dm", "tub")
    source = read_3dm(tmp_path / "tub.3dm")
    bottom = source.patches["bottom"]
    torn = {**source.patches, "bottom": replace(bottom, net_mm=bottom.net_mm + 0.1)}

    assert shoelast_of_surfaces(source, "right", "tub") is not None
    assert shoelast_of_surfaces(replace(source, patches=torn), "right", "tub") is None
    assert shoelast_of_surfaces(replace(source, frame=None), "right", "tub") is None


def test_tapes_of_the_file_are_not_taken_for_the_ball_break_line(tmp_path: Path):
    shoelast = build_shoelast("men", 42.0, "g", 12.0)
    save_last_3dm(shoelast, tmp_path / "last.3dm", "last")

    lines = read_3dm(tmp_path / "last.3dm").lines

    assert np.allclose(lines["ball_break_line"], shoelast.lines["ball_break_line"])
    assert np.allclose(lines["ball_tape"], shoelast.lines["ball_tape"])


@given(rotation=st.integers(0, 10_000), shift=st.tuples(*[st.floats(-500, 500)] * 3))
def test_datum_points_give_the_way_back_into_the_frame(rotation: int, shift: tuple[float, float, float]):
    turn = np.eye(4)
    turn[:3, :3], turn[:3, 3] = Rotation.random(random_state=rotation).as_matrix(), shift
    there = {name: turn[:3, :3] @ place + turn[:3, 3] for name, place in DATUM_POINTS.items()}

    frame, words = frame_from_points(there)

    assert words == ()
    assert frame is not None
    assert np.allclose(frame @ turn, np.eye(4), atol=1e-9)


def test_datum_points_that_were_moved_apart_are_told_and_not_used():
    places = {name: np.array(place) + (name == "datum_x") for name, place in DATUM_POINTS.items()}

    frame, words = frame_from_points(places)

    assert frame is None
    assert "moved apart by 1.0 mm" in words[0]
