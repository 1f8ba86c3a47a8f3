import numpy as np
import pytest
import trimesh

from footscan.errors import EmptyScanError, MeshError
from footscan.foot.nurbs_fit import evaluate_at
from footscan.foot.skin_origin import Origin
from footscan.foot.surface import FootSurface, SurfaceSettings, fit_foot_surface
from footscan.foot.surface_cut import find_leg_cut
from footscan.foot.surface_files import load_surface_ply, save_surface_ply, save_surface_stl
from footscan.foot.surface_mesh import mesh_from_surface, mirrored_mesh
from tests.foot.smooth_foot_cloud import LENGTH_MM, LOWEST_SEEN_MM, FootCloud, distance_mm, foot_cloud, turned


@pytest.fixture(scope="module")
def cloud() -> FootCloud:
    return foot_cloud()


@pytest.fixture(scope="module")
def surface(cloud: FootCloud) -> FootSurface:
    return fit_foot_surface(cloud.xyz, cloud.weight, cloud.laser)


@pytest.fixture(scope="module")
def mesh(surface: FootSurface) -> trimesh.Trimesh:
    return mesh_from_surface(surface)


def test_seen_skin_lies_on_the_true_skin(mesh: trimesh.Trimesh) -> None:
    seen = mesh.vertex_attributes["origin"] == Origin.SEEN
    distance = distance_mm(np.asarray(mesh.vertices)[seen])

    assert np.sqrt((distance**2).mean()) < 0.03
    assert np.abs(distance).max() < 0.5


def test_the_mesh_is_closed_oriented_and_flat_at_both_ends(mesh: trimesh.Trimesh, surface: FootSurface) -> None:
    z = mesh.vertices[:, 2]
    origin = mesh.vertex_attributes["origin"]

    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0
    assert z.min() == 0.0
    assert z.max() == pytest.approx(surface.cut.z_mm)
    assert np.all(z[origin == Origin.CUT] == pytest.approx(surface.cut.z_mm))
    assert np.abs(mesh.face_normals[(z[mesh.faces] == 0.0).all(axis=1), 2] + 1.0).max() < 1e-9


def test_classes_follow_the_points(mesh: trimesh.Trimesh, surface: FootSurface, cloud: FootCloud) -> None:
    z, origin = mesh.vertices[:, 2], mesh.vertex_attributes["origin"]
    skin = z < surface.cut.z_mm - 15.0
    lowest = cloud.xyz[:, 2].min()

    assert (origin[z < lowest - 1.5] == Origin.ASSUMED_SOLE).all()
    assert (origin[skin & (z > LOWEST_SEEN_MM + 1.5)] == Origin.SEEN).mean() > 0.99
    assert set(np.unique(mesh.vertex_attributes["sheets"][origin == Origin.SEEN])) <= {1, 2}
    assert (mesh.vertex_attributes["sheets"][origin != Origin.SEEN] == 0).all()


def test_residuals_are_those_of_the_noise_and_unknown_where_nothing_was_seen(mesh: trimesh.Trimesh) -> None:
    residual, seen = mesh.vertex_attributes["residual_mm"], mesh.vertex_attributes["origin"] == Origin.SEEN

    assert np.isfinite(residual[seen]).all()
    assert np.isnan(residual[~seen]).all()
    assert 0.01 < np.median(residual[seen]) < 0.05


def test_a_hole_on_the_dorsum_is_bridged_and_said_so(cloud: FootCloud) -> None:
    hole = np.array([30.0, 0.0, 59.0])
    kept = np.linalg.norm(cloud.xyz - hole, axis=1) > 12.0

    mesh = mesh_from_surface(fit_foot_surface(cloud.xyz[kept], cloud.weight[kept], cloud.laser[kept]))
    away = np.linalg.norm(mesh.vertices - hole, axis=1)

    assert (mesh.vertex_attributes["origin"][away < 9.0] == Origin.BRIDGED).all()
    assert (mesh.vertex_attributes["origin"][(away > 15.0) & (away < 25.0)] == Origin.SEEN).all()
    assert np.abs(distance_mm(np.asarray(mesh.vertices)[away < 9.0])).max() < 1.0


def test_a_turned_and_shifted_foot_gives_the_same_surface_turned(cloud: FootCloud, surface: FootSurface) -> None:
    moved = fit_foot_surface(turned(cloud.xyz, 2.1, (15.0, -20.0)), cloud.weight, cloud.laser)

    back = turned(moved.tube.net_mm.reshape(-1, 3) - [15.0, -20.0, 0.0], -2.1)

    assert np.abs(back - surface.tube.net_mm.reshape(-1, 3)).max() < 1e-4


def test_a_mirrored_foot_gives_the_same_surface_mirrored(cloud: FootCloud, surface: FootSurface) -> None:
    other_hand = np.array([1.0, -1.0, 1.0])

    image = fit_foot_surface(cloud.xyz * other_hand, cloud.weight, cloud.laser, mirrored=True)
    ours, theirs = mesh_from_surface(surface), mirrored_mesh(mesh_from_surface(image.mirrored()))

    np.testing.assert_allclose(theirs.vertices * other_hand, ours.vertices, atol=1e-9)
    np.testing.assert_allclose(image.residual_mm, surface.residual_mm, atol=1e-9)
    np.testing.assert_allclose(evaluate_at(image.tube, image.u, image.v).xyz_mm, image.xyz_world, atol=1.0)
    np.testing.assert_array_equal(theirs.vertex_attributes["origin"], ours.vertex_attributes["origin"])
    assert theirs.volume == pytest.approx(ours.volume)
    assert mesh_from_surface(image).volume == pytest.approx(ours.volume, rel=1e-4)


@pytest.mark.parametrize("scale", [0.45, 1.2])
def test_small_and_large_feet_are_fitted_as_well(cloud: FootCloud, scale: float) -> None:
    mesh = mesh_from_surface(fit_foot_surface(cloud.xyz * scale, cloud.weight, cloud.laser))
    seen = mesh.vertex_attributes["origin"] == Origin.SEEN
    distance = scale * distance_mm(np.asarray(mesh.vertices)[seen] / scale)

    assert mesh.is_watertight
    assert np.sqrt((distance**2).mean()) < 0.04


def test_gross_errors_do_not_count(cloud: FootCloud) -> None:
    rng = np.random.default_rng(4)
    spoiled = cloud.xyz.copy()
    wrong = rng.choice(len(spoiled), len(spoiled) // 200, replace=False)
    spoiled[wrong] += rng.normal(0.0, 8.0, (len(wrong), 3))
    spoiled[:, 2] = np.maximum(spoiled[:, 2], LOWEST_SEEN_MM)

    mesh = mesh_from_surface(fit_foot_surface(spoiled, cloud.weight, cloud.laser))
    z, seen = mesh.vertices[:, 2], mesh.vertex_attributes["origin"] == Origin.SEEN
    distance = distance_mm(np.asarray(mesh.vertices)[seen & (z > 12.0) & (z < 130.0)])

    assert np.sqrt((distance**2).mean()) < 0.06


def test_fewer_points_give_fewer_control_points(cloud: FootCloud, surface: FootSurface) -> None:
    thin = fit_foot_surface(cloud.xyz[::12], cloud.weight[::12], cloud.laser[::12])

    assert thin.tube.net_mm.size < 0.5 * surface.tube.net_mm.size
    assert thin.rms_mm < 0.2


def test_the_leg_is_cut_where_ninety_percent_of_the_directions_end(cloud: FootCloud) -> None:
    full, half = find_leg_cut(cloud.xyz, 0.9), find_leg_cut(cloud.xyz, 0.5)

    assert 135.0 < full.z_mm < 138.0
    assert 147.0 < half.z_mm < 150.0
    assert full.seen_share >= 0.9


def test_the_cut_stays_above_ankle_bones_that_half_the_directions_show(cloud: FootCloud) -> None:
    away = np.arctan2(cloud.xyz[:, 1], cloud.xyz[:, 0] + 67.0)
    kept = (cloud.xyz[:, 2] < 60.0) | (np.abs(away) > 0.9)

    cut = find_leg_cut(cloud.xyz[kept], 0.9)

    assert cut.z_mm == pytest.approx(0.36 * LENGTH_MM, rel=0.03)
    assert "ankle" in cut.reason


def test_files_hold_the_mesh_and_its_attributes(mesh: trimesh.Trimesh, tmp_path) -> None:
    save_surface_stl(mesh, tmp_path / "surface.stl")
    save_surface_ply(mesh, tmp_path / "surface.ply", "test")

    stl = trimesh.load(tmp_path / "surface.stl")
    ply = load_surface_ply(tmp_path / "surface.ply")

    assert stl.is_watertight
    assert stl.volume == pytest.approx(mesh.volume, rel=1e-4)
    assert trimesh.load(tmp_path / "surface.ply", process=False).is_watertight
    for name in ("origin", "sheets", "residual_mm"):
        np.testing.assert_array_equal(ply.vertex_attributes[name], mesh.vertex_attributes[name])


def test_a_ply_of_another_kind_is_refused(tmp_path) -> None:
    (tmp_path / "cloud.ply").write_bytes(b"ply\nelement vertex 1\nend_header\n1234")

    with pytest.raises(MeshError, match=r"no surface\.ply"):
        load_surface_ply(tmp_path / "cloud.ply")


def ball() -> np.ndarray:
    away = np.random.default_rng(1).normal(size=(8000, 3))
    return 60.0 * away / np.linalg.norm(away, axis=1, keepdims=True) + [0.0, 0.0, 60.0]


def fit(xyz: np.ndarray) -> FootSurface:
    return fit_foot_surface(xyz, np.ones(len(xyz)), np.zeros(len(xyz), np.int64))


def test_an_empty_scan_is_refused() -> None:
    with pytest.raises(EmptyScanError, match="only 0 points"):
        fit(np.empty((0, 3)))


def test_a_place_that_is_no_number_is_refused(cloud: FootCloud) -> None:
    spoiled = cloud.xyz.copy()
    spoiled[17, 1] = np.nan

    with pytest.raises(MeshError, match=r"1 of \d+ points"):
        fit(spoiled)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda xyz: xyz + np.array([90.0, 0.0, 0.0]), "end at the border of the view"),
        (lambda xyz: np.concatenate([0.5 * xyz + [0, 60, 0], 0.5 * xyz - [0, 60, 0]]), "2 objects stand apart"),
        (lambda xyz: xyz[xyz[:, 2] < 20.0], "plantar scan"),
        (lambda xyz: xyz / 1000.0, "0 mm long"),
        (lambda xyz: xyz * [1.0, 0.2, 1.0], "which is no foot"),
        (lambda _: ball(), "a ball of 120 mm"),
        (
            lambda _: np.random.default_rng(0).uniform([-100, -50, 0], [100, 50, 100], (20000, 3)),
            "from any smooth foot",
        ),
    ],
)
def test_what_is_no_single_whole_foot_is_refused_by_name(cloud: FootCloud, change, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        fit(change(cloud.xyz))


def test_arrays_that_do_not_belong_together_are_a_mistake_of_the_caller(cloud: FootCloud) -> None:
    with pytest.raises(ValueError, match="a cloud needs"):
        fit_foot_surface(cloud.xyz, cloud.weight[:-1], cloud.laser, SurfaceSettings())
